"""The geometric stiffness of a prestress, from next to none to buckling and beyond."""

from collections.abc import Iterator
from functools import partial

from comparisons.stability.parts.case import ACCURATE, HONEST, Run, case
from comparisons.stability.parts.pressed_layers import ALLOWED, UNIFORM_WAYS, pressed_layers
from comparisons.stability.parts.prestressed import (
    Layer,
    buckling_pressure,
    prestressed_eigenvalues,
)
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import Reference

_UPPER = Layer(0.1, 0.25, 0.35, 0.5, (5, 2))
_LOWER = Layer(1.0, 0.3, 1.0, 1.0, (5, 3))
"""Those of :func:`comparisons.stability.parts.scenes.layers`."""
_P = 1.0


@case("A prestress from 1e-9 of the buckling load to twice as much", subject="load")
def prestress() -> Iterator[Run]:
    """Layers between rollers have uniform stresses: the reference knows them by a formula."""
    limit = buckling_pressure(_UPPER, _LOWER, _P)
    for part in (1e-9, 0.5, 0.99, 1 - 1e-6, 1 - 1e-10, 1 + 1e-6, 1.01, 2.0):
        pressure = part * limit
        truth = Reference("formula", partial(prestressed_eigenvalues, _UPPER, _LOWER, _P, pressure))
        expected = ACCURATE if abs(part - 1) > 1e-3 else HONEST
        for way in UNIFORM_WAYS:
            data = pressed_layers(way, pressure, degree=1, c_n=_P)
            data["analysis"] |= {"geometric_stiffness": True}
            row = f"{part:.10g} of the buckling load"
            yield Run(row, way, OfScene(data), truth, expected, warnings=ALLOWED)
