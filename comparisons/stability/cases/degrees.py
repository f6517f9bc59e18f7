"""Degrees of elements and splines."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense, exact
from comparisons.stability.parts.scenes import changed, layers
from comparisons.stability.parts.ways import WAYS, chosen

_FREQUENCY = 0.4
_ENOUGH = 3
"""Degree from which six elements meet exact eigenvalues to the tolerance."""


@case("Degrees 1 to 8", subject="elements and splines")
def degrees() -> Iterator[Run]:
    """Splines to degree 8, Lagrange elements to 4: the algebra, and the exact eigenvalues."""
    for degree in range(1, 9):
        fields = {"degree": degree}
        scene = layers(upper=fields, lower=fields, upper_elements=(3, 1), lower_elements=(2, 2))
        ways = chosen(WAYS, "node", "Greville", "GPTS, penalty", "segments, saddle", "mortar")
        for way in ways if degree <= 4 else chosen(ways, backend="iga"):
            data = way.of(scene)
            yield Run(f"degree {degree}", way, OfScene(data), dense(data))
    for degree in range(_ENOUGH, 9):
        fields = {"degree": degree}
        scene = layers(upper=fields, lower=fields, mu="0.3*abs(sin(pi*x/2))")
        ways = chosen(WAYS, "mortar")
        for way in ways if degree <= 4 else chosen(ways, backend="iga"):
            data = changed(way.of(scene), {"analysis.max_frequency": _FREQUENCY})
            true = exact("blocks", max_frequency=_FREQUENCY, p=1, mu="0.3")
            yield Run(f"degree {degree}, exact", way, OfScene(data), true, tolerance=1e-3)
