"""Damping from next to nothing to critical, alike and unlike in the bodies."""

from collections.abc import Iterator

from comparisons.stability.parts.case import MESH, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import damped
from comparisons.stability.parts.scenes import Scene, layers
from comparisons.stability.parts.ways import WAYS, chosen

_LOW, _HIGH = 0.05, 0.6
"""Frequencies (Hz) of the given damping ratios: the ends of the modes looked at."""
_LOST = 1e-12
"""A ratio that errors of eigenvalues may hide."""
_RATIOS = (_LOST, 1e-6, 1e-2, 0.3, 1.0)


def _damped(ratio: float, *bodies: str) -> Scene:
    data = layers(p=10.0)
    for name in bodies:
        damping = {"ratios": [ratio, ratio], "frequencies": [_LOW, _HIGH]}
        data["bodies"][name]["damping"] = damping
    data["analysis"]["min_growth"] = -3.0
    return data


@case("Damping ratios 1e-12 to 1", subject="damping and rotation")
def damping() -> Iterator[Run]:
    """Layers between rollers, with friction; damping may call some modes stable, others not."""
    for ratio in _RATIOS:
        for words, bodies in (("both", ("upper", "lower")), ("upper alone", ("upper",))):
            for way in chosen(WAYS, "GPTS, penalty", "mortar, saddle"):
                data = way.of(_damped(ratio, *bodies))
                row = f"ζ = {ratio:g}, {words}"
                may = (*MESH, "undecided") if ratio == _LOST else MESH
                yield Run(row, way, OfScene(data), damped(data), warnings=may)
