"""Windows of stiff contact in systems large enough to be searched with few discs."""

from collections.abc import Iterator
from math import inf

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import exact
from comparisons.stability.parts.scenes import changed, layers
from comparisons.stability.parts.ways import WAYS, chosen

_STIFFNESSES = (1e3, 1e9, inf)
_FRICTIONS = (0.3, 1.5)
_FREQUENCY = 0.42
_DEGREE = {"degree": 3}
_ELEMENTS = {"fe": ((22, 12), (20, 17)), "iga": ((64, 32), (60, 48))}
"""Elements of both layers, for 11,000 unknowns."""


@case("Stiff contact in systems of 11,000 unknowns", subject="contact stiffness")
def stiff_windows() -> Iterator[Run]:
    """Friction is bounded by turned test functions: windows are complete, up to tied sides."""
    for mu in _FRICTIONS:
        for p in _STIFFNESSES:
            true = exact("blocks", max_frequency=_FREQUENCY, p="inf" if p == inf else p, mu=str(mu))
            for way in chosen(WAYS, "mortar, saddle"):
                upper, lower = _ELEMENTS[way.backend]
                data = layers(
                    upper=_DEGREE,
                    lower=_DEGREE,
                    upper_elements=upper,
                    lower_elements=lower,
                    p=p,
                    mu=f"{mu}*abs(sin(pi*x/2))",
                )
                data = changed(way.of(data), {"analysis.max_frequency": _FREQUENCY})
                row = f"mu = {mu:g}, p = {p:.0e} N/m³"
                yield Run(row, way, OfScene(data), true, tolerance=1e-3)
