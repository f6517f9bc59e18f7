"""A claim of the paper, and what the figures' data say of it on each kind of mesh."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from comparisons.kit.numbers import number
from comparisons.paper.common.families import Family
from comparisons.paper.common.figure import Data

Verdict = Literal["holds", "does not", "depends"]

Evidence = Mapping[str, Data]
"""Stored data of figures by name, all of one backend."""


@dataclass(frozen=True)
class Judgement:
    """What the data say of a claim on one kind of mesh.

    Parameters
    ----------
    verdict
        Whether it holds.
    value
        The number that decides.
    why
        What else a reader must know, in a few words.
    """

    verdict: Verdict
    value: float
    why: str = ""


@dataclass(frozen=True)
class Claim:
    """A claim of the paper, or a question it leaves open.

    Parameters
    ----------
    name
        Short name.
    claim
        The claim, in our words.
    section
        Where the paper makes it; what it leaves open says so.
    measure
        What the deciding number is.
    figures
        Figures whose data decide.
    decide
        Judges by these data on a kind of mesh.
    """

    name: str
    claim: str
    section: str
    measure: str
    figures: tuple[str, ...]
    decide: Callable[[Evidence, Family], Judgement]


@dataclass(frozen=True)
class JudgedClaim:
    """A claim with its judgement on every kind of mesh."""

    claim: Claim
    judgements: Mapping[Family, Judgement]

    def told(self) -> str:
        """The claim and its verdicts as a paragraph."""
        verdicts = [
            f"  {family}: {judged.verdict}, {number(judged.value)}"
            + (f" ({judged.why})" if judged.why else "")
            for family, judged in self.judgements.items()
        ]
        head = f"{self.claim.claim} [{self.claim.section}]"
        return "\n".join([head, f"  decided by: {self.claim.measure}", *verdicts])
