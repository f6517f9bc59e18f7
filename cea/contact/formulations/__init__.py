"""Contact formulations: each a choice of points and weights on side a, one file each.

A new one is a file with a class that :func:`register` lets scenes name, and its line here.
"""

from cea.contact.formulations.base import Formulation, register, registered
from cea.contact.formulations.bonded import Bonded
from cea.contact.formulations.botella import Botella
from cea.contact.formulations.gpts import GaussPointToSurface
from cea.contact.formulations.greville import Greville
from cea.contact.formulations.grid import Grid
from cea.contact.formulations.mortar import Mortar
from cea.contact.formulations.node_to_surface import NodeToSurface
from cea.contact.formulations.segments import Segments

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
    "register",
    "registered",
]
