"""Modes that no search found: continued from a coarser mesh."""

from collections.abc import Iterator
from math import inf

from comparisons.stability.parts.case import HONEST, Run, case
from comparisons.stability.parts.continued import OfContinued
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS, chosen

_LINEAR = {"degree": 1}


@case("Modes continued from elements of degree 1", subject="friction and spectra")
def continued() -> Iterator[Run]:
    """Their residuals vouch for them however stiff the contact; that none is missing, nothing."""
    for P in (1e-3, 1e4, inf):
        for mu in (0.0, 1.0):
            for way in chosen(WAYS, "GPTS, saddle", "mortar, saddle"):
                data = way.of(layers(P=P, mu=mu))
                coarse = way.of(layers(P=P, mu=mu, upper=_LINEAR, lower=_LINEAR))
                row = f"P = {P:.0e} N/m, μ = {mu:g}"
                yield Run(row, way, OfContinued(data, coarse), dense(data), HONEST)
