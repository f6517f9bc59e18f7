"""Values of a map of a damped scene, between the full solves that it rests on."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.mapped import OfMap
from comparisons.stability.parts.references import damped
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import WAYS, chosen

_AXES = {
    "contacts.interface.mu": (0.0, 0.5, 1.0),
    "bodies.upper.damping.alpha": (0.0, 0.25, 0.5),
    "bodies.lower.damping.beta": (0.0, 0.05, 0.1),
}


@case("Maps of friction and damping by a reduced model", subject="damping and rotation")
def damped_maps() -> Iterator[Run]:
    """Between full solves all is as dense solves say, next to no damping and with much of it."""
    for alpha, beta, mu in ((1e-9, 1e-12, 0.83), (3e-3, 1e-3, 0.3), (0.4, 0.07, 0.61)):
        for way in chosen(WAYS, "GPTS, penalty", "mortar, saddle"):
            data = way.of(layers(p=10.0, mu=mu))
            data["bodies"]["upper"]["damping"] = {"alpha": alpha}
            data["bodies"]["lower"]["damping"] = {"beta": beta}
            data["analysis"]["min_growth"] = -3.0
            row = f"α = {alpha:g} 1/s, β = {beta:g} s, μ = {mu:g}"
            yield Run(row, way, OfMap(data, _AXES), damped(data))
