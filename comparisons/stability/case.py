"""Runs of a case: a scene in several ways, and what must come out of each, said beforehand."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np

from cea.arrays import Complexes
from comparisons.stability.dense import dense_eigenvalues
from comparisons.stability.problems import OfScene, Problem
from comparisons.stability.ways import WAYS, Way

Verdict = Literal["accurate", "warned", "refused", "WRONG"]

EXPECTED: dict[str, tuple[Verdict, ...]] = {
    "accurate": ("accurate",),
    "warned": ("accurate", "warned"),
    "honest": ("accurate", "warned", "refused"),
    "refused": ("refused",),
    "not accurate": ("warned", "refused"),
}
"""Verdicts that may come out.

Accurate: the answer has the digits of the tolerance and no warning but those allowed. Warned:
digits may be lost, and the result then says so. Honest: anything but a wrong answer without a word.
Refused: there is no answer, and the run ends with an error that names what is wrong. Not accurate:
the answer is that of another problem, which the run says if it is not refused.
"""
MESH = (
    "short-modes",
    "under-sampled",
    "over-constrained",
    "point-rule",
    "volumetric-locking",
    "doubtful-units",
)
"""Warnings about the mesh, the point rule or the units: beside a reference on the same mesh they
may come, and they excuse no error."""
_BEYOND = 1.3  # how far beyond the modes looked at an exact list reaches


@dataclass(frozen=True)
class Reference:
    """A true answer."""

    name: str  # where it comes from: "dense", "exact", "formula"
    values: Callable[[], Complexes]  # lambda (1/s) with Im >= 0, far beyond the window


def dense(scene: Mapping[str, Any], *, factor: float = 1.0, copies: int = 1) -> Reference:
    """Dense eigenvalues of a scene (scipy) times a factor, each so many times."""

    def values() -> Complexes:
        return np.repeat(factor * _dense(_key(scene)), copies)

    return Reference("dense", values)


def exact(problem: str, *, max_frequency: float, **parameters: Any) -> Reference:
    """Exact eigenvalues of a problem with its parameters, beyond a window's end (Hz)."""

    def values() -> Complexes:
        from exact_cea.reference import whole_spectrum

        top = _BEYOND * 2 * np.pi * max_frequency
        return whole_spectrum(problem, max_frequency=top, **parameters).values

    return Reference("exact", values)


def formula(values: Sequence[complex]) -> Reference:
    """Values by a closed formula."""
    return Reference("formula", lambda: np.asarray(values, dtype=complex))


def _key(scene: Mapping[str, Any]) -> str:
    """A scene as text, the saddle form for the penalty: both have the same eigenvalues."""
    data = json.loads(json.dumps(scene))
    for contact in data.get("contacts", {}).values():
        contact.pop("form", None)
    return json.dumps(data, sort_keys=True)


@cache
def _dense(scene: str) -> Complexes:
    return dense_eigenvalues(json.loads(scene))


@dataclass(frozen=True)
class Run:
    """One run of a case."""

    row: str  # what distinguishes it within its case: "P = 1e6 N/m"
    way: Way
    problem: Problem
    reference: Reference | None  # None where only a refusal is right
    expected: tuple[Verdict, ...] = EXPECTED["accurate"]  # the verdicts that may come out
    tolerance: float = 1e-8  # relative error of lambda up to which an answer is accurate
    lowest: int = 8  # true modes in the window, where the problem gives no frequency
    warnings: tuple[str, ...] = MESH  # kinds that may come although the answer is accurate
    names: str = ""  # what the message of a refusal must contain


Runs = Iterator[Run]


def runs(
    row: str,
    scene: Mapping[str, Any],
    ways: Iterable[Way] = WAYS,
    true: Callable[[dict[str, Any]], Reference] | Reference | None = dense,
    *,
    expected: str = "accurate",
    instead: Mapping[str, Any] | None = None,
    also: tuple[str, ...] = (),
    **fields: Any,
) -> Runs:
    """A scene in every one of some ways; ``row`` distinguishes it within its case.

    ``true`` is the reference, or makes it from the scene as it is run, or from another one
    ``instead``; None where only a refusal is right. ``also`` are warnings that may come beside
    those about the mesh; others are fields of Run.
    """
    fields = {"warnings": (*MESH, *also), **fields}
    for way in ways:
        reference = true(way.of(instead or scene)) if callable(true) else true
        yield Run(row, way, OfScene(way.of(scene)), reference, EXPECTED[expected], **fields)


def refused(
    row: str, scene: Mapping[str, Any], ways: Iterable[Way] = WAYS, names: str = ""
) -> Runs:
    """A scene that must be refused, by a message that contains a name."""
    return runs(row, scene, ways, None, expected="refused", names=names)
