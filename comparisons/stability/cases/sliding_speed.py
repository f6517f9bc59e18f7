"""Contacts that slide slowly, fast, and whose friction falls or rises with the speed."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import damped
from comparisons.stability.parts.scenes import Scene, body, contact, scene
from comparisons.stability.parts.ways import WAYS, chosen

_SLIDING: dict[str, Scene] = {
    "v = 1e6": {"speed": 1e6},
    "v = 1": {"speed": 1.0},
    "v = 1e-6": {"speed": 1e-6},
    "v varies": {"speed": "0.01 + hypot(x, y)"},
    "μ' = -1e-9": {"speed": 1.0, "mu_slope": -1e-9},
    "μ' = -1": {"speed": 1.0, "mu_slope": -1.0},
    "μ' = 1": {"speed": 1.0, "mu_slope": 1.0},
    "μ' changes sign": {"speed": 1.0, "mu_slope": "x - 0.8"},
}


def _boxes(sliding: Scene) -> Scene:
    def box(size: list[float], origin: list[float], E: float, held: str) -> Scene:
        geometry = {"shape": "box", "size": size, "origin": origin}
        return body(geometry, (2, 2, 1), E=E, supports=[{"surface": held}])

    return scene(
        {
            "upper": box([1.0, 0.8, 0.5], [0.3, 0.1, 0.0], 0.5, "z_max"),
            "lower": box([2.0, 1.0, 1.0], [0.0, 0.0, -1.0], 1.0, "z_min"),
        },
        contact=contact(
            "upper.z_min",
            "lower.z_max",
            p=2.0,
            friction_direction_on_a={"vector": [1.0, 0.0, 0.0]},
            sliding={"pressure": 0.05} | sliding,
        ),
    )


@case("Sliding speeds 1e-6 to 1e6, slopes of friction", subject="damping and rotation")
def sliding_speed() -> Iterator[Run]:
    """Slow sliding holds the sides together across it; friction that falls makes modes grow."""
    for words, sliding in _SLIDING.items():
        for way in chosen(WAYS, "GPTS, penalty", "mortar, saddle"):
            data = way.of(_boxes(sliding))
            yield Run(words, way, OfScene(data), damped(data))
