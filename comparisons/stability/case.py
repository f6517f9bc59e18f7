"""Runs of a case: a scene solved in several ways, with the verdicts allowed for each."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from json import dumps, loads
from typing import Any, Literal

import numpy as np

from cea.arrays import Complexes
from comparisons.stability.dense import carried_eigenvalues, dense_eigenvalues
from comparisons.stability.problems import Problem, of_scene
from comparisons.stability.ways import WAYS, Way, Ways
from scenes.spec.plain import plain_data

Verdict = Literal["accurate", "warned", "refused", "WRONG"]

EXPECTED: dict[str, tuple[Verdict, ...]] = {
    "accurate": ("accurate",),
    "warned": ("accurate", "warned"),
    "honest": ("accurate", "warned", "refused"),
    "refused": ("refused",),
    "not accurate": ("warned", "refused"),
}
"""Verdicts allowed by each expectation.

Accurate: the error is within the tolerance, without warnings except allowed ones. Warned: the error
may be larger if the result warns. Honest: anything but a wrong answer without a warning. Refused:
the run must end with an error that names the cause. Not accurate: the answer is that of another
problem; the run must warn or be refused.
"""
MESH = (
    "short-modes",
    "under-sampled",
    "over-constrained",
    "point-rule",
    "volumetric-locking",
    "doubtful-units",
)
"""Warnings about the mesh, the point rule or the units: they are allowed, since references are on
the same mesh, but excuse no error."""
_BEYOND = 1.3  # upper end of exact lists, relative to the end of the window


@dataclass(frozen=True)
class Reference:
    """Reference eigenvalues."""

    name: str  # where it comes from: "dense", "at rest", "exact", "formula"
    values: Callable[[], Complexes]  # lambda (1/s) with Im >= 0, far beyond the window


def dense(scene: Mapping[str, Any], *, factor: float = 1.0, copies: int = 1) -> Reference:
    """Dense eigenvalues of a scene (scipy) times a factor, each repeated ``copies`` times."""

    def values() -> Complexes:
        return np.repeat(factor * _values(dense_eigenvalues, _key(scene)), copies)

    return Reference("dense", values)


def carried(scene: Mapping[str, Any]) -> Reference:
    """Eigenvalues of a damped rotating body, from dense ones at rest (scipy)."""
    return Reference("at rest", lambda: _values(carried_eigenvalues, _key(scene)))


def exact(problem: str, *, max_frequency: float, **parameters: Any) -> Reference:
    """Exact eigenvalues of a problem with its parameters, to beyond the window's end (Hz)."""

    def values() -> Complexes:
        from exact_cea.reference import whole_spectrum

        top = _BEYOND * 2 * np.pi * max_frequency
        return whole_spectrum(problem, max_frequency=top, **parameters).values

    return Reference("exact", values)


def formula(values: Sequence[complex] | Complexes) -> Reference:
    """Eigenvalues in closed form."""
    return Reference("formula", lambda: np.asarray(values, dtype=complex))


def _key(scene: Mapping[str, Any]) -> str:
    """A scene as text without its forms: penalty and saddle have the same eigenvalues."""
    data = plain_data(scene)
    for contact in data.get("contacts", {}).values():
        contact.pop("form", None)
    return dumps(data, sort_keys=True)


@cache
def _values(compute: Callable[[dict[str, Any]], Complexes], scene: str) -> Complexes:
    return compute(loads(scene))


@dataclass(frozen=True)
class Run:
    """One run of a case."""

    row: str  # what distinguishes it within its case: "P = 1e6 N/m"
    way: Way
    problem: Problem
    reference: Reference | None  # None if only a refusal is right
    expected: tuple[Verdict, ...] = EXPECTED["accurate"]  # the verdicts that may come out
    tolerance: float = 1e-8  # relative error of lambda up to which an answer is accurate
    lowest: int = 8  # reference modes in the window, if the problem gives no frequency
    warnings: tuple[str, ...] = MESH  # kinds allowed although the answer is accurate
    names: str = ""  # what the message of a refusal must contain


Runs = Iterator[Run]


def runs(
    rows: Mapping[str, Mapping[str, Any]],
    ways: Ways = WAYS,
    true: Callable[[dict[str, Any]], Reference] | Reference | None = dense,
    *,
    expected: str = "accurate",
    instead: Mapping[str, Any] | None = None,
    problem: Callable[..., Any] = of_scene,
    also: tuple[str, ...] = (),
    **fields: Any,
) -> Runs:
    """Yield a run in each way for each of several scenes, by the label that distinguishes it.

    ``true`` is the reference, or makes it from the scene as it is run, or from another scene
    ``instead``; None if only a refusal is right. ``problem`` solves a scene up to a frequency,
    ``also`` are warnings allowed in addition to those about the mesh; others are fields of Run.
    """
    fields = {"warnings": (*MESH, *also), **fields}
    for row, scene in rows.items():
        for way in ways:
            reference = true(way.of(instead or scene)) if callable(true) else true
            solve = partial(problem, way.of(scene))
            yield Run(row, way, solve, reference, EXPECTED[expected], **fields)


def refused(rows: Mapping[str, Mapping[str, Any]], ways: Ways = WAYS, names: str = "") -> Runs:
    """Yield runs of scenes that must be refused, with a message that contains ``names``."""
    return runs(rows, ways, None, expected="refused", names=names)
