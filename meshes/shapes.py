"""Shapes a scene can name.

Each shape has directions with physical coordinates, (x, y, z) or (r, theta, z) in space, (x, y) or
(r, theta) in plane strain, lengths in metres and angles in degrees. Both builders divide a shape
by breaks (:mod:`meshes.breaks`).
"""

from meshes.crowned import Crowned
from meshes.mesh_file import MeshFile
from meshes.nurbs_file import NurbsFile
from meshes.patches import Patches
from meshes.plane_shapes import Rectangle, Ring, RingSector
from meshes.solid_shapes import Annulus, Box, Disc, Hub, Sector
from meshes.ventilated_disc import VentilatedDisc

Shape = (
    Box
    | Annulus
    | Sector
    | Hub
    | Disc
    | VentilatedDisc
    | Rectangle
    | Ring
    | RingSector
    | Crowned
    | Patches
    | MeshFile
    | NurbsFile
)

__all__ = [
    "Annulus",
    "Box",
    "Crowned",
    "Disc",
    "Hub",
    "MeshFile",
    "NurbsFile",
    "Patches",
    "Rectangle",
    "Ring",
    "RingSector",
    "Sector",
    "Shape",
    "VentilatedDisc",
]
