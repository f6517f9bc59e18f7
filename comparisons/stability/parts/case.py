"""A case: runs with their references, and what must come out of each, said beforehand."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

from comparisons.stability.parts.problems import Problem
from comparisons.stability.parts.references import Reference
from comparisons.stability.parts.ways import Way

Verdict = Literal["accurate", "warned", "refused", "WRONG"]

ACCURATE: tuple[Verdict, ...] = ("accurate",)
"""The answer has the digits of the tolerance, and comes without a warning that is not allowed."""
WARNED: tuple[Verdict, ...] = ("accurate", "warned")
"""Digits may be lost, and the result then says so."""
HONEST: tuple[Verdict, ...] = ("accurate", "warned", "refused")
"""Anything but a wrong answer without a word."""
REFUSED: tuple[Verdict, ...] = ("refused",)
"""There is no answer: the run ends before it or without it, and names what is wrong."""

MESH = (
    "short-modes",
    "under-sampled",
    "over-constrained",
    "point-rule",
    "volumetric-locking",
    "doubtful-units",
)
"""Kinds of warnings that tell how far a mesh or a rule is from the continuum, or numbers from those
of solids in SI units: beside a reference on the same mesh they may come, and excuse no error."""
MESH_AND_PENALTY = (*MESH, "penalty-rounding")
"""The same with the one of digits that a penalty costs: it may come where they are left over."""
NONE: tuple[str, ...] = ()
"""No warning may come: where the run must be accurate, it is easy."""


@dataclass(frozen=True)
class Run:
    """One run of a case.

    Parameters
    ----------
    row
        What sets it apart within its case, in words: "P = 1e6 N/m".
    way
        Backend and formulation.
    problem
        What is solved.
    reference
        The true answer; None where there is none, and only a refusal is right.
    expected
        The verdicts that may come out.
    tolerance
        Relative error of lambda up to which an answer is accurate.
    lowest
        How many of the reference's modes are looked at, where the problem does not say up to which
        frequency.
    warnings
        Kinds of warnings that may come although it is accurate; they excuse no error.
    names
        What a refusal must name.
    """

    row: str
    way: Way
    problem: Problem
    reference: Reference | None
    expected: tuple[Verdict, ...] = ACCURATE
    tolerance: float = 1e-8
    lowest: int = 8
    warnings: tuple[str, ...] = MESH
    names: str = ""

    @property
    def easy(self) -> bool:
        """Whether it must be accurate and free of warnings."""
        return self.expected == ACCURATE and not self.warnings


@dataclass(frozen=True)
class Case:
    """A case of the catalogue.

    Parameters
    ----------
    title
        What it shows, in words.
    subject
        What it belongs to: cases of a subject share a heat map.
    runs
        Makes its runs.
    """

    title: str
    subject: str
    runs: Callable[[], Iterable[Run]]


def case(title: str, *, subject: str) -> Callable[[Callable[[], Iterable[Run]]], Case]:
    """Make a function that yields runs a case; its file in the folder of cases names it."""
    return lambda runs: Case(title, subject, runs)
