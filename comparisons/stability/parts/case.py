"""A case of the catalogue: rows of scenes, and what must come out of each, said beforehand."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from comparisons.stability.parts.problems import OfScene, Problem
from comparisons.stability.parts.references import Reference, dense
from comparisons.stability.parts.ways import WAYS, Way

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
    "short-modes",
    "under-sampled",
    "over-constrained",
    "point-rule",
    "volumetric-locking",
    "doubtful-units",
)
"""Warnings about the mesh, the point rule or the units: beside a reference on the same mesh they
may come, and they excuse no error."""
MESH_AND_PENALTY = (*MESH, "penalty-rounding")
"""The same with the warning of digits that a penalty loses."""
NONE: tuple[str, ...] = ()
"""No warning may come. A run that must be accurate without any warning is easy."""


@dataclass(frozen=True)
class Run:
    """One run of a case.

    Parameters
    ----------
    row
        What distinguishes it within its case: "P = 1e6 N/m".
    way
        Backend and formulation.
    problem
        What is solved.
    reference
        The true answer; None where only a refusal is right.
    expected
        The verdicts that may come out.
    tolerance
        Relative error of lambda up to which an answer is accurate.
    lowest
        Number of true modes in the window, where the problem gives no frequency.
    warnings
        Kinds of warnings that may come although the answer is accurate.
    names
        What the message of a refusal must contain.
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


class Rows:
    """Scenes by row, each run in every one of some ways.

    Parameters
    ----------
    scenes
        Scenes as plain data, by what distinguishes them.
    ways
        Backends and formulations.
    true
        The reference of every run, or a function that makes it from the scene as it is run; None
        where only a refusal is right.
    instead
        Scene of which the reference is made, where it is another one.
    problem
        Makes what is solved from the scene as it is run.
    options
        Other fields of :class:`Run`.
    """

    def __init__(
        self,
        scenes: Mapping[str, Mapping[str, Any]],
        ways: Iterable[Way] = WAYS,
        true: Callable[[dict[str, Any]], Reference] | Reference | None = dense,
        *,
        instead: Mapping[str, Any] | None = None,
        problem: Callable[[dict[str, Any]], Problem] = OfScene,
        **options: Any,
    ) -> None:
        self.scenes, self.ways, self.true, self.instead = scenes, tuple(ways), true, instead
        self.problem, self.options = problem, options

    def runs(self) -> Iterator[Run]:
        """Every scene in every way."""
        for row, scene in self.scenes.items():
            for way in self.ways:
                true = self.true
                if true is not None and not isinstance(true, Reference):
                    true = true(way.of(self.instead or scene))
                yield Run(row, way, self.problem(way.of(scene)), true, **self.options)


def refused(
    scenes: Mapping[str, Mapping[str, Any]], ways: Iterable[Way] = WAYS, names: str = ""
) -> Rows:
    """Rows of scenes that must be refused, by a message that contains a name."""
    return Rows(scenes, ways, None, expected=REFUSED, names=names)


class Case:
    """A case of the catalogue.

    Parameters
    ----------
    title
        What it shows.
    parts
        Rows, or functions that yield runs.
    subject
        Cases of one subject share a heat map: that of its module where it has no other.
    """

    def __init__(
        self, title: str, *parts: Rows | Callable[[], Iterable[Run]], subject: str = ""
    ) -> None:
        self.title, self.parts, self.subject = title, parts, subject

    def of(self, subject: str) -> "Case":
        """The case with a subject, unless it has one."""
        return Case(self.title, *self.parts, subject=self.subject or subject)

    def runs(self) -> Iterator[Run]:
        """Its runs."""
        for part in self.parts:
            yield from part.runs() if isinstance(part, Rows) else part()
