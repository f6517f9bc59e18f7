"""Runs of a case: a scene in several ways, and what must come out of each, said beforehand."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from comparisons.stability.problems import OfScene, Problem
from comparisons.stability.references import Reference, dense
from comparisons.stability.ways import WAYS, Way

Verdict = Literal["accurate", "warned", "refused", "WRONG"]

ACCURATE: tuple[Verdict, ...] = ("accurate",)
"""The answer has the digits of the tolerance and no warning but those allowed."""
WARNED: tuple[Verdict, ...] = ("accurate", "warned")
"""Digits may be lost, and the result then says so."""
HONEST: tuple[Verdict, ...] = ("accurate", "warned", "refused")
"""Anything but a wrong answer without a word."""
REFUSED: tuple[Verdict, ...] = ("refused",)
"""There is no answer: the run ends with an error that names what is wrong."""
NOT_ACCURATE: tuple[Verdict, ...] = ("warned", "refused")
"""The answer is that of another problem: the run says so or is refused."""

MESH = (
    *("short-modes", "under-sampled", "over-constrained", "point-rule"),
    *("volumetric-locking", "doubtful-units"),
)
"""Warnings about the mesh, the point rule or the units: beside a reference on the same mesh they
may come, and they excuse no error."""
MESH_AND_PENALTY = (*MESH, "penalty-rounding")
"""The same with the warning of digits that a penalty loses."""
MESH_AND_UNDECIDED = (*MESH, "undecided")
"""The same where errors of eigenvalues may hide a growth or decay."""
NONE: tuple[str, ...] = ()
"""No warning may come."""


@dataclass(frozen=True)
class Run:
    """One run of a case."""

    row: str  # what distinguishes it within its case: "P = 1e6 N/m"
    way: Way
    problem: Problem
    reference: Reference | None  # None where only a refusal is right
    expected: tuple[Verdict, ...] = ACCURATE  # the verdicts that may come out
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
    instead: Mapping[str, Any] | None = None,
    problem: Callable[[dict[str, Any]], Problem] = OfScene,
    **fields: Any,
) -> Runs:
    """A scene in every one of some ways.

    ``row`` distinguishes it within its case; ``true`` is the reference of every run, or makes it
    from the scene as it is run, or from another one ``instead``; None where only a refusal is
    right. ``problem`` makes what is solved of that scene. Other fields are those of :class:`Run`.
    """
    for way in ways:
        reference = true(way.of(instead or scene)) if callable(true) else true
        yield Run(row, way, problem(way.of(scene)), reference, **fields)


def refused(
    row: str, scene: Mapping[str, Any], ways: Iterable[Way] = WAYS, names: str = ""
) -> Runs:
    """A scene that must be refused, by a message that contains a name."""
    return runs(row, scene, ways, None, expected=REFUSED, names=names)
