"""Modes of bodies damped one by one, from next to nothing to next to critical."""

from collections.abc import Iterator
from typing import Any

from comparisons.stability.parts.case import MESH, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import damped
from comparisons.stability.parts.scenes import (
    Scene,
    body,
    contact,
    layers,
    rectangle,
    scene,
)
from comparisons.stability.parts.ways import WAYS, chosen

_EVERY = 1e3
"""Frequency (Hz) above all modes of these bodies."""
_RATIOS = (1e-12, 1e-6, 1e-2, 0.3, 0.999)
_WITHOUT = "a list to next to critical"
"""The row with modes that are not damped: their decay lies within its error."""


def _layers(ratio: float, max_frequency: float) -> Scene:
    """Layers between rollers, with friction, the modes of both damped up to a frequency."""
    return _with(layers(p=10.0), {"ratio": ratio, "max_frequency": max_frequency})


def _with(data: Scene, modal: dict[str, Any], *bodies: str) -> Scene:
    for name in bodies or data["bodies"]:
        data["bodies"][name]["damping"] = {"modal": modal}
    data["analysis"]["min_growth"] = -3.0
    return data


def _square() -> Scene:
    """A square that contacts alone hold, at a base and at a wall: alone its modes come in pairs."""
    wall = body(rectangle((0.5, 1.0), (1.0, 0.0)), (2, 4), supports=[{"surface": "x_max"}])
    base = body(rectangle((1.0, 1.0), (0.0, -1.0)), (4, 4), supports=[{"surface": "y_min"}])
    return scene(
        {"square": body(rectangle((1.0, 1.0)), (3, 3)), "base": base, "wall": wall},
        below=contact("square.y_min", "base.y_max", P=10.0),
        beside=contact(
            "square.x_max", "wall.x_min", P=10.0, friction_direction_on_a={"vector": [0.0, 1.0]}
        ),
    )


@case("Modal damping, ratios 1e-12 to 0.999", subject="damping and rotation")
def modal_damping() -> Iterator[Run]:
    """One ratio, a list and a table; all modes or some; multiple ones, free bodies."""
    scenes = {f"ζ = {ratio:g}, all modes": _layers(ratio, _EVERY) for ratio in _RATIOS}
    scenes["ζ = 0.01 up to 0.3 Hz"] = _layers(1e-2, 0.3)
    scenes[_WITHOUT] = _with(
        layers(p=10.0), {"ratios": [0.999, 1e-12, 0.0, 0.5, 0.999999]}, "upper"
    )
    table = {"ratios": [0.9, 1e-6, 0.5], "frequencies": [0.2, 0.4, _EVERY]}
    scenes["a table"] = _with(layers(p=10.0), table)
    scenes["a free square"] = _with(_square(), {"ratio": 0.05, "max_frequency": _EVERY}, "square")
    for row, data in scenes.items():
        for way in chosen(WAYS, "GPTS, penalty", "mortar, saddle"):
            made = way.of(data)
            may = (*MESH, "undecided") if row == _WITHOUT else MESH
            yield Run(row, way, OfScene(made), damped(made), warnings=may)
