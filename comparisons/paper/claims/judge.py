"""The paper's claims judged by the data of the figures, for every kind of mesh."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Literal

from comparisons.kit.numbers import number
from comparisons.kit.progress import Progress
from comparisons.kit.tabular import Column, Table
from comparisons.paper.disc_pad.case import FAMILIES, Family
from comparisons.paper.figure import Data
from scenes.results import write_json
from scenes.spec import Backend

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


def judge(out: Path, progress: Progress) -> list[JudgedClaim]:
    """Judge every claim by stored figures; those that are missing are made.

    Parameters
    ----------
    out
        Folder of the figures.
    progress
        Where progress is shown.
    """
    from comparisons.paper.claims.claims import CLAIMS
    from comparisons.paper.registry import FIGURES
    from comparisons.paper.store import make_figure, read_data

    needed = [name for name in FIGURES if any(name in claim.figures for claim in CLAIMS)]
    evidence: dict[Backend, Evidence] = {}
    for backend in FAMILIES:
        made = {name: make_figure(FIGURES[name], backend, out, progress) for name in needed}
        evidence[backend] = {name: read_data(each.data_file) for name, each in made.items()}
    return [judged(claim, evidence) for claim in CLAIMS]


def judged(claim: Claim, evidence: Mapping[Backend, Evidence]) -> JudgedClaim:
    """A claim judged on every kind of mesh."""
    return JudgedClaim(
        claim,
        {
            family: claim.decide(evidence[backend], family)
            for backend, families in FAMILIES.items()
            for family in families
        },
    )


def write_claims(every: list[JudgedClaim], out: Path) -> list[Path]:
    """Write ``claims.csv`` and ``claims.json``."""
    families = [family for each in FAMILIES.values() for family in each]
    columns = (
        *("name", "claim", "section", "measure"),
        *(f"{family}_{part}" for family in families for part in ("verdict", "value", "why")),
    )
    rows = []
    for each in every:
        row: list[object] = [getattr(each.claim, name) for name in columns[:4]]
        for judgement in (each.judgements[family] for family in families):
            row += [judgement.verdict, _finite(judgement.value), judgement.why]
        rows.append(tuple(row))
    file = out / "claims.json"
    write_json({"claims": [dict(zip(columns, row, strict=True)) for row in rows]}, file)
    table = Table("claims", "Claims", tuple(Column(name, name) for name in columns), rows)
    return [table.write_csv(out), file]


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
