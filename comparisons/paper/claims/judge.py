"""The paper's claims judged by the data of the figures, for every kind of mesh."""

from collections.abc import Mapping
from math import isfinite
from pathlib import Path

from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.claims.catalogue import CLAIMS
from comparisons.paper.claims.claim import Claim, Evidence, JudgedClaim
from comparisons.paper.common.families import FAMILIES
from comparisons.paper.common.store import figure_data
from comparisons.paper.registry import FIGURES
from scenes.results.record import record, write_record
from scenes.spec.body import Backend


def judge(out: Path, progress: Progress) -> list[JudgedClaim]:
    """Judge every claim by the stored data of figures; those that are missing are computed.

    Parameters
    ----------
    out
        Folder of the figures, which are not drawn.
    progress
        Where progress is shown.
    """
    needed = [name for name in FIGURES if any(name in claim.figures for claim in CLAIMS)]
    evidence: dict[Backend, Evidence] = {}
    for backend in FAMILIES:
        evidence[backend] = {
            name: figure_data(FIGURES[name], backend, out, progress).data for name in needed
        }
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


def write_claims(every: list[JudgedClaim], out: Path, seconds: float) -> list[Path]:
    """Write ``claims.csv`` and ``claims.json``.

    Parameters
    ----------
    every
        The claims, judged.
    out
        Folder of both files.
    seconds
        How long judging them took.
    """
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
    data = {"claims": [dict(zip(columns, row, strict=True)) for row in rows]}
    figures = sorted({name for each in every for name in each.claim.figures})
    write_record(record("claims", data, inputs={"figures": figures}, seconds=seconds), file)
    table = Table("claims", "Claims", tuple(Column(name, name) for name in columns), rows)
    return [table.write_csv(out), file]


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
