"""Scenes as people have them: what must be right without a word."""

from collections.abc import Iterator
from typing import Any

from comparisons.stability.parts.case import NONE, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import (
    Scene,
    body,
    in_units,
    layers,
    pad,
    rectangle,
    scene,
    sprag,
)
from comparisons.stability.parts.ways import ALONE, WAYS, chosen

_STEEL = {"E": 2.1e11, "nu": 0.3, "rho": 7800.0}
_LINING = {"E": 8e9, "nu": 0.3, "rho": 2500.0}


def _fine(**fields: Any) -> Scene:
    return layers(upper_elements=(8, 3), lower_elements=(7, 4), **fields)


_BRAKE = _fine(upper=_LINING, lower=_STEEL, p=1e11)

_SCENES = {
    "layers": _fine(),
    "layers without friction": _fine(mu=0.0),
    "layers, friction 0.7": _fine(mu=0.7),
    "steel on lining, SI": _BRAKE,
    "steel on lining, mm-t-s": in_units(_BRAKE, metre=1e3, kilogram=1e-3),
    "pad": pad(),
    "sprag below its limit": sprag(60.0, 0.3),
    "sprag beyond its limit": sprag(60.0, 0.9),
}
_LOWEST = 3
"""Modes that meshes of so few elements resolve."""


@case("Everyday scenes: accurate, and free of warnings", subject="friction and spectra")
def everyday() -> Iterator[Run]:
    """Steel, lining, moderate friction, meshes that resolve the modes looked at."""
    for name, data in _SCENES.items():
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "GPTS, full", "mortar"):
            own = way.of(data)
            yield Run(name, way, OfScene(own), dense(own), lowest=_LOWEST, warnings=NONE)
    block = scene({"block": body(rectangle((2.0, 1.0)), (4, 3))})
    for way in ALONE:
        own = way.of(block)
        yield Run("free block", way, OfScene(own), dense(own), lowest=5, warnings=NONE)
