"""Shapes a scene can name: those of :mod:`meshes.simple_shapes`, others, and files.

Both builders divide a shape by breaks (:mod:`meshes.breaks`).
"""

from meshes.crowned import Crowned as Crowned
from meshes.mesh_file import MeshFile as MeshFile
from meshes.patches import NurbsFile as NurbsFile
from meshes.patches import Patches as Patches
from meshes.simple_shapes import Annulus as Annulus
from meshes.simple_shapes import Box as Box
from meshes.simple_shapes import Disc as Disc
from meshes.simple_shapes import Hub as Hub
from meshes.simple_shapes import Rectangle as Rectangle
from meshes.simple_shapes import Ring as Ring
from meshes.simple_shapes import RingSector as RingSector
from meshes.simple_shapes import Sector as Sector
from meshes.simple_shapes import round_surfaces as round_surfaces
from meshes.ventilated_disc import VentilatedDisc as VentilatedDisc

Simple = Box | Annulus | Sector | Hub | Disc | VentilatedDisc | Rectangle | Ring | RingSector
Shape = Simple | Crowned | Patches | MeshFile | NurbsFile
