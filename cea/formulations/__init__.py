"""Contact formulations: each a choice of points and weights on side a, one file each."""

from cea.formulations.gpts import GaussPointToSurface
from cea.formulations.greville import Greville
from cea.formulations.grid import Grid
from cea.formulations.mortar import Mortar
from cea.formulations.node_to_surface import NodeToSurface
from cea.formulations.segments import Segments

Formulation = NodeToSurface | Greville | Grid | GaussPointToSurface | Segments | Mortar

__all__ = [
    "Formulation",
    "GaussPointToSurface",
    "Greville",
    "Grid",
    "Mortar",
    "NodeToSurface",
    "Segments",
]
