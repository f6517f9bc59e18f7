"""Friction from none to more than any pad has, and friction that oscillates."""

from collections.abc import Iterator

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS, chosen

_FRICTIONS: dict[str, float | str] = {
    "μ = 0": 0.0,
    "μ = 1e-12": 1e-12,
    "μ = 0.3": 0.3,
    "μ = 1": 1.0,
    "μ = 5": 5.0,
    "μ oscillates": "0.5*abs(sin(40*pi*x))",
}


@case("Friction 0, 1e-12, 0.3, 1, 5, oscillating", subject="friction and spectra")
def friction() -> Iterator[Run]:
    """Layers between rollers, where friction couples waves along the contact."""
    for name, mu in _FRICTIONS.items():
        for way in WAYS:
            data = way.of(layers(mu=mu, p=10.0))
            yield Run(name, way, OfScene(data), dense(data))
    for way in chosen(WAYS, "GPTS, penalty", "mortar, saddle"):
        data = way.of(layers(mu="0.5*sin(5*pi*x)"))
        yield Run("μ changes sign", way, OfScene(data), None, REFUSED, names="mu")
