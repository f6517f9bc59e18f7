"""Numbers of the paper's patch tests beside those computed here, each with a verdict."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from comparisons.kit.progress import Progress
from comparisons.paper.common.figure import Number
from comparisons.paper.patch_test.case import EXACT
from comparisons.paper.patch_test.figures import PATCH_TEST_FIGURES
from scenes.spec.body import Backend

FIGURES = {figure.name: figure for figure in PATCH_TEST_FIGURES}
"""Figures with results of the patch test, by their numbers; 2 and 11 show its settings."""

WITHIN = 0.1
"""Largest relative difference with which a number of the paper is met."""

_BACKEND: Backend = "iga"
"""Backend of the paper."""
_ROUND_OFF = 1e-10 * abs(EXACT)
"""Oscillation (N/m^2) that is round-off."""

_WORDS: dict[str, Callable[[float], bool]] = {
    "below 1": lambda value: value < 1,
    "above 1": lambda value: value > 1,
    "not zero": lambda value: value > _ROUND_OFF,
    "machine precision": lambda value: value <= _ROUND_OFF,
}
"""What words of the paper ask of a number."""


def run_paper_numbers(
    progress: Progress, names: tuple[str, ...] = tuple(FIGURES)
) -> dict[str, Any]:
    """Numbers of figures of the paper, computed on NURBS as there.

    Parameters
    ----------
    progress
        Where progress is shown.
    names
        Numbers of the figures.

    Returns
    -------
    dict
        Plain data: ``within``, the bound of a number that is met; ``figures`` with ``name``,
        ``title``, ``note`` and ``numbers``: ``what``, ``paper`` (number, words or None), ``ours``,
        ``unit``, ``remark`` and ``met``, None where the paper says nothing that can be judged.
    """
    return {"within": WITHIN, "figures": [_numbers(progress, name) for name in names]}


def _numbers(progress: Progress, name: str) -> dict[str, Any]:
    figure = FIGURES[name]
    described = {"figure": name, "title": figure.title, "backend": _BACKEND}
    data = described | figure.compute(_BACKEND, progress)
    return {
        "name": name,
        "title": figure.title,
        "note": figure.note(data),
        "numbers": [asdict(number) | {"met": met(number)} for number in figure.numbers(data)],
    }


def met(number: Number) -> bool | None:
    """Whether a number of the paper is met; None where nothing can be judged."""
    if isinstance(number.paper, str):
        asked = _WORDS.get(number.paper)
        return None if asked is None else asked(number.ours)
    if number.paper is None:
        return None
    return abs(number.ours - number.paper) <= WITHIN * abs(number.paper)
