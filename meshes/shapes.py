"""Shapes a scene can name: those of :mod:`meshes.simple_shapes`, others, and files.

Both builders divide a shape by breaks (:mod:`meshes.breaks`).
"""

from meshes.crowned import Crowned
from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile, Patches
from meshes.simple_shapes import (
    Annulus,
    Box,
    Disc,
    Hub,
    Rectangle,
    Ring,
    RingSector,
    Sector,
    round_surfaces,
)
from meshes.ventilated_disc import VentilatedDisc

Simple = Box | Annulus | Sector | Hub | Disc | VentilatedDisc | Rectangle | Ring | RingSector
Shape = Simple | Crowned | Patches | MeshFile | NurbsFile

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
    "round_surfaces",
]
