"""Meshes of the shapes: structured between breaks, or unstructured of a given size."""

from collections.abc import Sequence
from dataclasses import replace

from cea.mesh import SIMPLICES, Cell, Mesh
from meshes.breaks import Breaks
from meshes.crowned import Crowned
from meshes.edge_layers import Edge
from meshes.placement import IN_PLACE, Placement
from meshes.shapes import Shape
from meshes.structured import divided, structured_mesh


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
    """Mesh a shape; its surfaces (curves in the plane) are named as in ``shape.surfaces``.

    Hexahedra and quadrilaterals lie between ``breaks`` (m, degrees), with ``layers`` of cells
    towards ``edges``; each is divided into six tetrahedra or two triangles, or the mesh is
    unstructured of target edge length ``size`` (m): gmsh must not be in use then. Curved cells are
    polynomials through the Gauss-Lobatto points of the circles (:mod:`meshes.structured`). Crowned
    faces pass through all nodes, and are exact on straight bases from order 2.
    """
    base = shape.base if isinstance(shape, Crowned) else shape
    if size is not None:
        from meshes.unstructured import outline_mesh  # brings in gmsh

        mesh = outline_mesh(base, order, size)
    else:
        mesh = structured_mesh(base, breaks or (), order, edges, layers)
        mesh = divided(mesh) if cell in SIMPLICES else mesh
    points = shape.crown(mesh.points) if isinstance(shape, Crowned) else mesh.points
    return replace(mesh, points=placement.apply(points))
