"""The contact patch test: a uniform pressure, whatever the contact stiffness."""

from collections.abc import Iterator
from math import inf

import numpy as np

from comparisons.stability.parts.case import MESH_AND_PENALTY, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.scenes import Scene, body, changed, contact, rectangle, scene
from comparisons.stability.parts.ways import MORTAR, PENALTY, WAYS, chosen

_PRESSURE, _E = 1000.0, 1e5
_TOLERANCE = 1e-5
_ROUNDING = 100 * np.finfo(float).eps / _E
"""What rounding of a hundred dofs costs a penalty for each N/m of P."""


def _pressed(P: float) -> Scene:
    """Two blocks of equal width on each other, a uniform pressure on top."""
    held = [{"surface": "y_min", "components": ["y"]}, {"surface": "x_min", "components": ["x"]}]
    data = scene(
        {
            "upper": body(
                rectangle((9.0, 4.5)),
                (3, 1),
                E=_E,
                nu=0.0,
                supports=[{"surface": "x_min", "components": ["x"]}],
            ),
            "lower": body(rectangle((9.0, 4.5), (0.0, -4.5)), (5, 1), E=_E, nu=0.0, supports=held),
        },
        contact=contact("upper.y_min", "lower.y_max", P=P, mu=0.0),
    )
    loads = [{"surface": "upper.y_max", "pressure": _PRESSURE}]
    return changed(data, {"analysis": {"kind": "static", "samples": 9}, "loads": loads})


@case("Contact patch test at P from 1e-4 to 1e16 and infinite", subject="contact stiffness")
def patch_test() -> Iterator[Run]:
    """Exact integration passes at any P: the upper block nearly floats, or a penalty drowns it."""
    true = formula([-_PRESSURE])
    for P in (1e-4, 1.0, 1e3, 1e6, 1e10, 1e14, 1e16):
        for way in chosen(WAYS, "segments", "mortar"):
            lost = _ROUNDING * P if way in PENALTY else 0.0
            yield Run(
                f"P = {P:.0e} N/m",
                way,
                OfScene(way.of(_pressed(P))),
                true,
                tolerance=max(_TOLERANCE, lost),
                warnings=(*MESH_AND_PENALTY, "large-displacement"),
            )
    for way in chosen(MORTAR, "mortar, saddle"):
        yield Run("P infinite", way, OfScene(way.of(_pressed(inf))), true, tolerance=_TOLERANCE)
