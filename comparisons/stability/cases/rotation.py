"""A ring that rotates, from next to no rate to one at which waves run backwards."""

from collections.abc import Iterator

from comparisons.stability.parts.case import MESH, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import damped
from comparisons.stability.parts.scenes import Scene, body, scene
from comparisons.stability.parts.ways import ALONE

_RATES = (1e-9, 1e-3, 0.1, 1.0, 5.0)
"""Rates (rad/s); the lowest mode of the ring at rest has 0.6 rad/s and two waves."""


def _ring(rate: float, *, coriolis: bool, convective: bool) -> Scene:
    rotation = {"rate": rate, "coriolis": coriolis, "convective_stiffness": convective}
    geometry = {"shape": "ring", "inner_radius": 0.5, "outer_radius": 1.0}
    held = [{"surface": "inner"}]
    part = body(geometry, (2, 12), supports=held, rotation=rotation)
    return scene({"ring": part})


@case("A rotating ring, held at its inner rim", subject="damping and rotation")
def rotation() -> Iterator[Run]:
    """Without convective stiffness no rate can make a mode grow; with it, high ones do."""
    for rate in _RATES:
        for coriolis in (True, False):
            for convective in (False, True):
                words = "with" if coriolis else "no"
                stiffness = ", convective stiffness" if convective else ""
                for way in ALONE:
                    data = way.of(_ring(rate, coriolis=coriolis, convective=convective))
                    row = f"Ω = {rate:g}, {words} Coriolis forces{stiffness}"
                    may = (*MESH, "centrifugal-stresses")
                    yield Run(row, way, OfScene(data), damped(data), warnings=may)
