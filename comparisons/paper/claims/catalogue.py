"""Claims of the paper in the order of its text, with the rule that decides each."""

from comparisons.paper.claims import equilibrium_rules, rules
from comparisons.paper.claims.claim import Claim

_TEXT = "3"
_OPEN = "3, left open"

CLAIMS = (
    Claim(
        "lumped patch test",
        "Lumped contact passes the patch test to machine precision at P = 10¹⁴",
        _TEXT,
        "oscillation of σₙ over σₙ; 1e-10 is precision",
        ("3",),
        rules.lumped_patch,
    ),
    Claim(
        "lumping locks",
        "Lumping locks the interface at P = 10⁶: the disc moves less along the "
        "normal in the contact than elsewhere",
        _TEXT,
        "that part of its motion, lumped over plain, median of all modes; 0.5 is much less",
        ("4", "6"),
        rules.locks,
    ),
    Claim(
        "false stiffness",
        "What lumping changes comes of the false stiffness it gives to "
        "rotations common to both bodies",
        _OPEN,
        "part of the shifts of frequencies at P = 10⁹ "
        "that it explains to first order; 0.8 is explained",
        ("lumping",),
        rules.false_stiffness,
    ),
    Claim(
        "lumped spectra",
        "With and without lumping, unstable modes largely do not coincide at P = 10⁹",
        _TEXT,
        "part of them that coincide in frequency within 1 %; it depends where only growth does not",
        ("6",),
        rules.lumped_spectra,
    ),
    Claim(
        "side b",
        "σₙ of side b oscillates more than that of side a, for the points lie on a, "
        "whichever side is finer",
        _TEXT,
        "least oscillation of b over a at P = 10⁶, before and after the exchange of meshes",
        ("7", "12"),
        rules.side_b,
    ),
    Claim(
        "collocation grows",
        "Collocation overestimates growth below 10 kHz at P = 10⁹",
        _TEXT,
        "sum of growth rates, collocation over GPTS",
        ("13",),
        rules.overestimates,
    ),
    Claim(
        "identical",
        "Collocation and GPTS are identical at P = 10¹²",
        _TEXT,
        "largest relative distance of eigenvalues; 1e-3 is identical",
        ("13",),
        rules.identical,
    ),
    Claim(
        "less identical",
        "Collocation and GPTS differ more at P = 10¹⁴ than at 10¹²",
        _TEXT,
        "largest relative distance of eigenvalues at P = 10¹⁴",
        ("13",),
        rules.worse,
    ),
    Claim(
        "round-off",
        "The difference at P = 10¹⁴ is round-off of ill-conditioned matrices",
        _TEXT,
        "largest shift of a frequency from mortar, saddle form over penalty; below 0.5 it is",
        ("stiff",),
        rules.round_off,
    ),
    Claim(
        "over-constraint",
        "The difference at P = 10¹⁴ is over-constraint: more points than side a has functions",
        _OPEN,
        "largest shift of GPTS from mortar, both in the saddle form; "
        "three times that at P = 10¹² or more",
        ("stiff",),
        rules.over_constraint,
    ),
    Claim(
        "more points",
        "CEA is insensitive to more Gauss points",
        _TEXT,
        "largest shift below 13 kHz; 1 % and 5 % of the largest growth are none",
        ("14",),
        rules.more_points,
    ),
    Claim(
        "higher degree",
        "CEA is insensitive to degree and continuity below 13 kHz",
        _TEXT,
        "largest shift below 13 kHz of the worst degree to 5 (Lagrange 4); 1 % and 5 % of the "
        "largest growth are none",
        ("14",),
        rules.higher_degree,
    ),
    Claim(
        "above 13 kHz",
        "A higher degree shifts frequencies above 13 kHz more than those below",
        _TEXT,
        "largest shift above over largest below, least of all degrees; it depends where only "
        "some shift more",
        ("14",),
        rules.above_13,
    ),
    Claim(
        "places of points",
        "Collocation is sensitive to where its points lie at P = 10⁹",
        _TEXT,
        "part of the unstable modes that coincide within 1 %, growth too",
        ("15",),
        rules.places,
    ),
    Claim(
        "GPTS suffices",
        "GPTS loses little against segments and mortar, and costs less",
        "4",
        "largest shift of a frequency from segments; 1e-3 and 1 % of growth are little",
        ("yardsticks",),
        rules.gpts,
    ),
    Claim(
        "boundary",
        "The mesh of the disc must trace the boundary of the contact",
        _TEXT,
        "largest difference of growth rates over the largest, from a mesh refined there, where "
        "it is ignored; 0.01 and half as much again as where traced matter",
        ("boundary",),
        rules.boundary,
    ),
    Claim(
        "full pass",
        "A full pass overcomes the bias of collocation",
        _OPEN,
        "largest difference of growth rates from segments, full over half pass; 0.5 and less "
        "overcomes it",
        ("yardsticks",),
        rules.full_pass,
    ),
    Claim(
        "equilibrium",
        "Collocation disturbs the equilibrium of steady sliding more than quadrature",
        "1, left open",
        "distance of the pressure on a crowned pad from segments on the same mesh, collocation "
        "over GPTS 3 × 3, least of all loads",
        ("crowned",),
        equilibrium_rules.equilibrium,
    ),
    Claim(
        "p of the scheme",
        "p(x) of steady sliding varies with the scheme that finds it",
        _TEXT,
        "largest relative difference of the integral of p from segments, of collocation and GPTS; "
        "0.01 varies, it depends where only one does",
        ("crowned",),
        equilibrium_rules.stiffness,
    ),
    Claim(
        "growth of the scheme",
        "Each in its own equilibrium, collocation errs more in growth than quadrature",
        "1, left open",
        "largest difference of the largest growth rate from segments over all loads, collocation "
        "over GPTS 3 × 3",
        ("crowned",),
        equilibrium_rules.growth,
    ),
)
"""Every claim."""
