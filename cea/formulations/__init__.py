"""Contact formulations: each a choice of points and weights on side a, one file each."""

from cea.contact import Coupling
from cea.formulations.bonded import Bonded
from cea.formulations.botella import Botella
from cea.formulations.gpts import GaussPointToSurface
from cea.formulations.greville import Greville
from cea.formulations.grid import Grid
from cea.formulations.mortar import Mortar
from cea.formulations.node_to_surface import NodeToSurface
from cea.formulations.segments import Segments

Formulation = (
    NodeToSurface | Greville | Botella | Grid | GaussPointToSurface | Segments | Mortar | Bonded
)


def coupling_of(formulation: Formulation) -> Coupling:
    """What a formulation makes of the gaps at its points."""
    match formulation:
        case Bonded():
            return "bonded"
        case Mortar():
            return "mortar"
        case GaussPointToSurface(lumped=True):
            return "lumped"
        case _:
            return "pointwise"


__all__ = [
    "Bonded",
    "Botella",
    "Formulation",
    "GaussPointToSurface",
    "Greville",
    "Grid",
    "Mortar",
    "NodeToSurface",
    "Segments",
    "coupling_of",
]
