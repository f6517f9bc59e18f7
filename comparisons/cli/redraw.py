"""Options beside ``--redraw``, which runs nothing: those that only a run could use are refused."""

from collections.abc import Mapping
from typing import Any

from cea.errors import InputError


def refuse_with_redraw(redraw: bool, options: Mapping[str, Any]) -> None:
    """Refuse options of a run where a stored result is drawn.

    Parameters
    ----------
    redraw
        Whether it is drawn.
    options
        Options by name; those that were not given are empty, False or None.

    Raises
    ------
    InputError
        Naming the first that was given.
    """
    for name, value in options.items():
        if redraw and value:
            raise InputError(name, value, "left out with --redraw, which runs nothing")


def refuse_another(given: Mapping[str, Any], stored: Mapping[str, Any]) -> None:
    """Refuse to draw a stored result as another one.

    Parameters
    ----------
    given
        What was asked for, by name.
    stored
        Inputs of the stored result.

    Raises
    ------
    InputError
        Naming the first that differs.
    """
    for name, value in given.items():
        if value != stored.get(name):
            raise InputError(name, value, f"{stored.get(name)!r}, as the stored result has it")
