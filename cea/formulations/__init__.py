"""Contact formulations: each a choice of points and weights on side a, one file each."""

from cea.formulations.gpts import GaussPointToSurface
from cea.formulations.greville import Greville
from cea.formulations.grid import Grid
from cea.formulations.node_to_surface import NodeToSurface

Formulation = NodeToSurface | Greville | Grid | GaussPointToSurface

__all__ = ["Formulation", "GaussPointToSurface", "Greville", "Grid", "NodeToSurface"]
