"""Claims of the paper in the order of its text, each with the number and limit that decide it.

Words of the paper are read as numbers: "largely" is within 1 per cent, "identical" within 0.1 per
cent, "considerable" above 5 per cent of the largest growth rate.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any

import pandas as pd

from comparisons.paper.crowned_pad import COLLOCATION, QUADRATURE
from comparisons.paper.disc_pad import HIGH, LOW, MIDDLE
from comparisons.paper.figure import MESHES, Mesh, Row
from comparisons.study.result import StudyResult


@dataclass(frozen=True)
class Evidence:
    """Results of the figures on one kind of mesh."""

    result: StudyResult
    mesh: Mesh

    def rows(self, table: str, *figures: str) -> pd.DataFrame:
        """Return rows of a table of some figures; a LookupError if none was computed."""
        frame = pd.concat(self.result.frame(table, figure=f, mesh=self.mesh) for f in figures)
        if frame.empty:
            raise LookupError(f"no {table} of {figures} on {self.mesh}")
        return frame

    def __call__(self, figure: str, P: float, number: int) -> Any:
        """Return the measures of a case of a diagram relative to its reference."""
        rows = self.rows("measures", figure)
        (row,) = rows[(rows["P"] == P) & (rows["number"] == number)].itertuples()
        return row

    def off(self, column: str, formulation: str) -> pd.Series:
        """Return the distance of a formulation from segments on the crowned pad, by load."""
        rows = self.rows("crowned", "crowned")
        return rows.loc[rows["formulation"] == formulation, column].abs().reset_index(drop=True)


@dataclass(frozen=True)
class Claim:
    """A claim of the paper, or a question it leaves open."""

    name: str
    claim: str  # in our words
    measure: str  # definition of the deciding number
    value: Callable[[Evidence], float]  # the number on a kind of mesh
    holds: Callable[[float, Evidence], bool]
    depends: Callable[[float, Evidence], bool] = lambda value, e: False  # it holds in part
    section: str = "3"  # section of the paper

    def judged(self, evidence: Evidence) -> tuple[str, float]:
        """Return verdict and number on a kind of mesh; LookupError if figures are missing."""
        value = float(self.value(evidence))
        if self.holds(value, evidence):
            return "holds", value
        return "depends" if self.depends(value, evidence) else "does not", value


def judged(result: StudyResult) -> pd.DataFrame:
    """Every claim whose figures were computed, with verdict and number on each kind of mesh."""
    rows = []
    for claim in CLAIMS:
        row: Row = {name: getattr(claim, name) for name in ("name", "claim", "section", "measure")}
        try:
            for mesh in MESHES:
                verdict, value = claim.judged(Evidence(result, mesh))
                row |= {f"{mesh}_verdict": verdict}
                row |= {f"{mesh}_value": value if isfinite(value) else None}
        except LookupError:
            continue
        rows.append(row)
    return pd.DataFrame(rows)


def _lumped_patch(e: Evidence) -> float:
    rows = e.rows("patch_tests", "3")
    lumped = rows["case"].str.contains("lumped") & (rows["P"] == 1e14)
    return rows.loc[lumped, "oscillation"].item() / 1000.0


def _b_over_a(e: Evidence) -> pd.Series:
    rows = e.rows("patch_tests", "7", "12")
    return rows.loc[rows["P"] == 1e6, "b_over_a"]


def _higher_degrees(e: Evidence) -> pd.DataFrame:
    rows = e.rows("measures", "14").query("degree > 2")
    return rows.assign(ratio=rows["shift_above_13k"] / rows["shift_below_13k"])


def _worst_degree(e: Evidence) -> Any:
    def rank(row: Any) -> tuple[bool, bool, float]:
        far = row.shift_below_13k >= 0.01
        return far, row.growth_part >= 0.05, row.shift_below_13k

    return max(_higher_degrees(e).itertuples(), key=rank)


def _pressure_over(e: Evidence) -> pd.Series:
    return e.off("pressure_off", COLLOCATION) / e.off("pressure_off", QUADRATURE)


def _saddle_over_penalty(e: Evidence) -> float:
    shifts = [e("stiff", HIGH, number).shift for number in (1, 2, 3, 4)]
    return max(shifts[2:]) / max(shifts[:2])


def _worst(e: Evidence, column: str, formulation: str) -> float:
    return float(e.off(column, formulation).max())


CLAIMS = (
    Claim(
        "lumped patch test",
        "Lumped contact passes the patch test to machine precision at P = 10¹⁴",
        "oscillation of σₙ over the exact pressure; below 1e-10: machine precision",
        _lumped_patch,
        lambda v, e: v < 1e-10,
    ),
    Claim(
        "lumping locks",
        "Lumping locks the interface at P = 10⁶: the disc moves less along the "
        "normal in the contact than elsewhere",
        "normal motion in the contact over elsewhere, lumped over plain, median of modes; "
        "below 0.5: locks",
        lambda e: e("4 and 5", 1e6, 1).contact_motion,
        lambda v, e: v < 0.5,
        lambda v, e: e("6", LOW, 1).contact_motion < 0.5,
    ),
    Claim(
        "false stiffness",
        "Frequency shifts by lumping are due to the false stiffness it gives to rotations "
        "common to both bodies",
        "part of the frequency shifts at P = 10⁹ that the false stiffness explains to first "
        "order; above 0.8: explained",
        lambda e: e.rows("lumping", "lumping")["explained"].item(),
        lambda v, e: v > 0.8,
        lambda v, e: v > 0.5,
        section="3, left open",
    ),
    Claim(
        "lumped spectra",
        "With and without lumping, unstable modes largely do not coincide at P = 10⁹",
        "share that coincides in frequency within 1 %; depends: only growth rates differ",
        lambda e: e("6", LOW, 1).share_frequency,
        lambda v, e: v < 0.5,
        lambda v, e: e("6", LOW, 1).share_both < 0.5,
    ),
    Claim(
        "side b",
        "σₙ of side b oscillates more than that of side a, because the points lie on a, "
        "whichever side is finer",
        "smallest oscillation of b over a at P = 10⁶, with both assignments of meshes",
        lambda e: _b_over_a(e).min(),
        lambda v, e: v > 1,
        lambda v, e: _b_over_a(e).max() > 1,
    ),
    Claim(
        "collocation grows",
        "Collocation overestimates growth below 10 kHz at P = 10⁹",
        "sum of growth rates below 10 kHz, collocation over GPTS",
        lambda e: e("13", LOW, 1).growth_below_10k,
        lambda v, e: v > 1.01,
    ),
    Claim(
        "identical",
        "Collocation and GPTS are identical at P = 10¹²",
        "largest relative distance of eigenvalues; below 1e-3: identical",
        lambda e: e("13", MIDDLE, 1).distance,
        lambda v, e: v < 1e-3,
    ),
    Claim(
        "less identical",
        "Collocation and GPTS differ more at P = 10¹⁴ than at 10¹²",
        "largest relative distance of eigenvalues at P = 10¹⁴",
        lambda e: e("13", HIGH, 1).distance,
        lambda v, e: v > e("13", MIDDLE, 1).distance,
    ),
    Claim(
        "round-off",
        "The difference at P = 10¹⁴ is round-off of ill-conditioned matrices",
        "largest frequency shift from mortar, saddle form over penalty; below 0.5: round-off",
        _saddle_over_penalty,
        lambda v, e: v < 0.5,
    ),
    Claim(
        "over-constraint",
        "The difference at P = 10¹⁴ is over-constraint: more points than side a has functions",
        "largest frequency shift of GPTS from mortar in the saddle form; holds above three times "
        "that at P = 10¹²",
        lambda e: e("stiff", HIGH, 4).shift,
        lambda v, e: v > 3 * e("stiff", MIDDLE, 4).shift,
        section="3, left open",
    ),
    Claim(
        "more points",
        "CEA is insensitive to more Gauss points",
        "largest frequency shift below 13 kHz; holds below 1 %, and 5 % of the largest growth",
        lambda e: e("14", LOW, 1).shift_below_13k,
        lambda v, e: v < 0.01 and e("14", LOW, 1).growth_part < 0.05,
        lambda v, e: v < 0.01,
    ),
    Claim(
        "higher degree",
        "CEA is insensitive to degree and continuity below 13 kHz",
        "largest frequency shift below 13 kHz of the worst degree up to 5 (Lagrange 4); holds "
        "below 1 %, and 5 % of the largest growth",
        lambda e: _worst_degree(e).shift_below_13k,
        lambda v, e: v < 0.01 and _worst_degree(e).growth_part < 0.05,
        lambda v, e: v < 0.01,
    ),
    Claim(
        "above 13 kHz",
        "A higher degree shifts frequencies above 13 kHz more than those below",
        "largest shift above over largest below, minimum over degrees; depends: only for some "
        "degrees",
        lambda e: _higher_degrees(e)["ratio"].min(),
        lambda v, e: v > 1,
        lambda v, e: _higher_degrees(e)["ratio"].max() > 1,
    ),
    Claim(
        "places of points",
        "Collocation is sensitive to the places of its points at P = 10⁹",
        "share of unstable modes that coincide within 1 % in frequency and growth",
        lambda e: e("15", LOW, 1).share_both,
        lambda v, e: v < 0.5,
    ),
    Claim(
        "GPTS suffices",
        "GPTS loses little against segments and mortar, and costs less",
        "largest frequency shift from segments; holds below 1e-3, and 1 % of growth",
        lambda e: e("yardsticks", LOW, 1).shift,
        lambda v, e: (
            v < 1e-3
            and e("yardsticks", LOW, 1).growth_part < 0.01
            and e("yardsticks", LOW, 1).search_over < 1
        ),
        lambda v, e: v < 1e-3 and e("yardsticks", LOW, 1).growth_part < 0.01,
        section="4",
    ),
    Claim(
        "boundary",
        "The mesh of the disc must trace the boundary of the contact",
        "largest difference of growth rates from a mesh refined there, over the largest, if the "
        "boundary is ignored; holds above 0.01 and 1.5 times that with traced boundary",
        lambda e: e("boundary", LOW, 2).growth_part,
        lambda v, e: v > max(1.5 * e("boundary", LOW, 1).growth_part, 0.01),
        lambda v, e: v > e("boundary", LOW, 1).growth_part,
    ),
    Claim(
        "full pass",
        "A full pass overcomes the bias of collocation",
        "largest difference of growth rates from segments, full over half pass; below 0.5: "
        "overcomes",
        lambda e: (
            e("yardsticks", LOW, 6).growth_difference / e("yardsticks", LOW, 4).growth_difference
        ),
        lambda v, e: v < 0.5,
        lambda v, e: v < 1,
        section="3, left open",
    ),
    Claim(
        "equilibrium",
        "Collocation disturbs the equilibrium of steady sliding more than quadrature",
        "distance of the pressure on a crowned pad from segments on the same mesh, collocation "
        "over GPTS 3 × 3, minimum over loads",
        lambda e: _pressure_over(e).min(),
        lambda v, e: v > 1,
        lambda v, e: _pressure_over(e).max() > 1,
        section="1, left open",
    ),
    Claim(
        "p of the scheme",
        "p(x) of steady sliding depends on the contact scheme",
        "largest relative difference of the integral of p from segments, for collocation and "
        "GPTS; holds if both exceed 0.01, depends: only one does",
        lambda e: max(_worst(e, "P_off", COLLOCATION), _worst(e, "P_off", QUADRATURE)),
        lambda v, e: min(_worst(e, "P_off", COLLOCATION), _worst(e, "P_off", QUADRATURE)) > 0.01,
        lambda v, e: v > 0.01,
    ),
    Claim(
        "growth of the scheme",
        "Each with its own equilibrium, collocation has a larger error of growth than quadrature",
        "largest difference of the largest growth rate from segments over all loads, collocation "
        "over GPTS 3 × 3",
        lambda e: _worst(e, "growth_off", COLLOCATION) / _worst(e, "growth_off", QUADRATURE),
        lambda v, e: v > 1,
        section="1, left open",
    ),
)
"""Every claim."""
