"""The catalogue of cases, and the runs of each."""

from collections.abc import Callable
from functools import cache
from inspect import getdoc, getmembers, isfunction

from cea.errors import InputError
from comparisons.stability import (
    cases_bodies,
    cases_contact,
    cases_friction,
    cases_matrices,
    cases_meshes,
    cases_motion,
)
from comparisons.stability.case import Run, Runs
from comparisons.stability.ways import QUICK

_MODULES = (
    *(cases_bodies, cases_contact, cases_friction),
    *(cases_matrices, cases_meshes, cases_motion),
)


@cache
def catalogue() -> dict[str, Callable[[], Runs]]:
    """Every case by its name: the public functions of the modules of cases."""
    found = {
        name: function
        for module in _MODULES
        for name, function in getmembers(module, isfunction)
        if function.__module__ == module.__name__ and not name.startswith("_")
    }
    return dict(sorted(found.items()))


def title_of(name: str) -> str:
    """What a case shows: its docstring."""
    return (getdoc(catalogue()[name]) or "").rstrip(".")


@cache
def runs_of(name: str) -> tuple[Run, ...]:
    """Runs of a case.

    Raises
    ------
    InputError
        When there is no such case.
    """
    if name not in catalogue():
        raise InputError("case", name, f"one of {', '.join(catalogue())}")
    return tuple(catalogue()[name]())


def numbers_of(name: str, *, quick: bool) -> list[int]:
    """Numbers of the runs of a case, from 0; a quick study takes a few of each row.

    These are the ways of :data:`comparisons.stability.ways.QUICK`, on one backend each, which
    alternates from row to row; a row without them keeps its first run.
    """
    runs = runs_of(name)
    if not quick:
        return list(range(len(runs)))
    rows = list(dict.fromkeys(run.row for run in runs))
    numbers = []
    for r, row in enumerate(rows):
        own = [i for i, run in enumerate(runs) if run.row == row]
        turn = {name: ("fe", "iga")[(r + k) % 2] for k, name in enumerate(QUICK)}
        picked = [i for i in own if turn.get(runs[i].way.name) == runs[i].way.backend]
        numbers += picked or own[:1]
    return numbers
