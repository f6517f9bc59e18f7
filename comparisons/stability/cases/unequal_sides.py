"""A full pass over sides of unequal area, with p given."""

from collections.abc import Iterator
from math import inf

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import pad
from comparisons.stability.parts.ways import WAYS, chosen


@case("Full pass with p over sides of unequal area", subject="contact stiffness")
def unequal_sides() -> Iterator[Run]:
    """Each half has half of p, whichever side its points lie on."""
    for p in (1.0, 1e4):
        for way in chosen(WAYS, "GPTS, full pass"):
            data = way.of(pad(p=p))
            yield Run(f"p = {p:.0e} N/m³", way, OfScene(data), dense(data))
    for way in chosen(WAYS, "GPTS, full pass, saddle"):
        data = way.of(pad(p=inf))
        yield Run("p infinite", way, OfScene(data), dense(data))
