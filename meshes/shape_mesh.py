"""Meshes of the shapes: structured between breaks, or unstructured of a given size."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cea.errors import require
from cea.mesh import DIMENSION, MAX_ORDER, SIMPLICES, Cell, Mesh
from meshes.breaks import Breaks, check_breaks
from meshes.crowned import Crowned
from meshes.edge_layers import Edge
from meshes.patches import Patches
from meshes.placement import IN_PLACE, Placement
from meshes.shapes import Shape
from meshes.structured import divided, structured_mesh
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc


def shape_mesh(
    shape: Shape,
    cell: Cell,
    order: int,
    *,
    breaks: Breaks | None = None,
    size: float | None = None,
    placement: Placement = IN_PLACE,
    edges: Sequence[Edge] = (),
    layers: int = 0,
) -> Mesh:
    """Mesh a shape; its surfaces (curves in the plane) bear the names ``shape.surfaces``.

    Hexahedra and quadrilaterals lie between ``breaks`` (m, degrees), with ``layers`` of cells
    towards ``edges``; tetrahedra and triangles are these divided into six or two, or unstructured
    of a target edge length ``size`` (m), for which gmsh must not be in use. Curved cells are
    polynomials through the Gauss-Lobatto points of the circles (:mod:`meshes.structured`). Crowned
    faces pass through all nodes, and are exact on straight bases from order 2.
    """
    if isinstance(shape, Crowned):
        flat = shape_mesh(
            shape.base, cell, order, breaks=breaks, size=size, edges=edges, layers=layers
        )
        return replace(flat, points=placement.apply(shape.crown(flat.points)))
    _check(shape, cell, order, breaks, size)
    if size is not None:
        from meshes.unstructured import outline_mesh  # brings in gmsh

        mesh = outline_mesh(shape, order, size)
        return replace(mesh, points=placement.apply(mesh.points))
    boxes = structured_mesh(shape, breaks or (), order, placement, edges=edges, layers=layers)
    return divided(boxes) if cell in SIMPLICES else boxes


def _check(shape: Shape, cell: Cell, order: int, breaks: Breaks | None, size: float | None) -> None:
    require(not isinstance(shape, Patches), "shape", shape.shape, "a shape that can be meshed")
    fitting = [name for name, dim in DIMENSION.items() if dim == len(shape.directions)]
    require(cell in fitting, "cell", cell, f"{' or '.join(fitting)} for shape = {shape.shape!r}")
    ventilated = isinstance(shape, VentilatedDisc)
    if ventilated:
        require(cell == "tetrahedron", "cell", cell, f"tetrahedron for shape = {shape.shape!r}")
        require(breaks is None, "breaks", breaks, f"None for shape = {shape.shape!r}: size instead")
    highest = MAX_CURVED if ventilated else MAX_ORDER
    require(1 <= order <= highest, "order", order, f"1 to {highest}")
    if cell in SIMPLICES and breaks is None:
        allowed = "a positive length (m), or breaks of a structured mesh"
        require(size is not None and 0 < size < np.inf, "size", size, allowed)
    else:
        require(size is None, "size", size, f"None: a {cell} mesh of breaks follows them")
        check_breaks(shape, breaks or ())
