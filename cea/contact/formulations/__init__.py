"""Contact formulations: each a choice of points and weights on side a, one file each."""

from cea.contact.formulations.bonded import Bonded
from cea.contact.formulations.botella import Botella
from cea.contact.formulations.gpts import GaussPointToSurface
from cea.contact.formulations.greville import Greville
from cea.contact.formulations.grid import Grid
from cea.contact.formulations.mortar import Mortar
from cea.contact.formulations.node_to_surface import NodeToSurface
from cea.contact.formulations.segments import Segments
from cea.contact.operators import Coupling

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
