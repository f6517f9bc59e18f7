"""Windows that hold every mode there is."""

from collections.abc import Iterator
from math import inf
from typing import Any

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, changed, layers
from comparisons.stability.parts.ways import ALONE, SADDLE, WAYS, chosen


def _few(**fields: Any) -> Scene:
    return layers(upper_elements=(3, 2), lower_elements=(2, 2), **fields)


@case("Windows that hold the whole spectrum", subject="friction and spectra")
def whole_spectrum() -> Iterator[Run]:
    """All modes, none of those at infinity that a tied contact has."""
    for name, frequency in (("just", None), ("far beyond", 1e3)):
        for P in (1.0, inf):
            own = chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar")
            for way in own if P == 1 else tuple(way for way in own if way in SADDLE):
                data = way.of(_few(P=P))
                if frequency is not None:
                    data = changed(data, {"analysis.max_frequency": frequency})
                row = f"{name} all modes, P = {P:g}"
                yield Run(row, way, OfScene(data), dense(data), lowest=10_000)
    for way in ALONE:
        data = way.of(_few(P=1.0, mu=0.0))
        data = changed(data, {"analysis.max_frequency": 1e3})
        yield Run("all modes, no friction", way, OfScene(data), dense(data))
