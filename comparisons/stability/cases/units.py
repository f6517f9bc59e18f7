"""The same scene in other units of length and mass."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import benign
from comparisons.stability.parts.scenes import in_units, layers
from comparisons.stability.parts.ways import WAYS

_UNITS = {
    "m, kg, s": (1.0, 1.0),
    "mm, t, s": (1e3, 1e-3),
    "µm, kg, s": (1e6, 1.0),
    "µm, ng, s": (1e6, 1e12),
    "km, kg, s": (1e-3, 1.0),
}
"""One metre and one kilogram in each."""
_STEEL = {"E": 2.1e11, "nu": 0.3, "rho": 7800.0}
_LINING = {"E": 8e9, "nu": 0.3, "rho": 2500.0}


@case("Units m-kg-s, mm-t-s, micrometres, kilometres", subject="materials and units")
def units() -> Iterator[Run]:
    """Eigenvalues (1/s) do not know units of length and mass."""
    scene = layers(upper=_LINING, lower=_STEEL, p=1e12)
    for name, (metre, kilogram) in _UNITS.items():
        for way in WAYS:
            data = way.of(in_units(scene, metre=metre, kilogram=kilogram))
            yield Run(name, way, OfScene(data), benign(way.of(scene)))
