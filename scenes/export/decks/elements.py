"""Elements of Abaqus and CalculiX: their names, the order of their nodes, their faces."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cea.mesh import Cell, Ints, Mesh, matching_nodes, reference_nodes
from meshes.files.content import named_sides
from meshes.files.elements import facet_sides, full_kind

ELEMENTS: Mapping[tuple[Cell, int], str] = {
    ("tetrahedron", 1): "C3D4",
    ("tetrahedron", 2): "C3D10",
    ("hexahedron", 1): "C3D8",
    ("triangle", 1): "CPE3",
    ("triangle", 2): "CPE6",
    ("quadrilateral", 1): "CPE4",
}
"""Elements by kind of cell and degree. Squares and cubes of higher degree have a node inside here,
none there: there is no counterpart."""


def element_nodes(mesh: Mesh) -> Ints:
    """Nodes of each cell in the order of its element type, right-handed, (n_cells, n_nodes)."""
    nodes = full_kind(mesh.cell, mesh.order).reference
    own = reference_nodes(mesh.cell, mesh.order)
    straight = mesh.cells[:, matching_nodes(nodes, own)]
    mirrored = mesh.cells[:, matching_nodes(nodes[:, [1, 0, *range(2, mesh.dim)]], own)]
    return np.where(_is_mirrored(mesh)[:, None], mirrored, straight)


def _is_mirrored(mesh: Mesh) -> NDArray[np.bool_]:
    """Whether the first two axes of a cell change places in its element, (n_cells,)."""
    first = np.vstack([np.zeros(mesh.dim), np.eye(mesh.dim)])
    apart = np.abs(first[:, None] - reference_nodes(mesh.cell, mesh.order)).max(axis=2)
    x = mesh.points[mesh.cells[:, apart.argmin(axis=1)]]
    return np.linalg.det(x[:, 1:] - x[:, :1]) < 0


def faces_of(mesh: Mesh, surface: str) -> tuple[Ints, Ints]:
    """Elements, from 0, rising, and their faces, from 1, that a surface has, (n_facets,)."""
    elements, facets = np.nonzero(named_sides(mesh)[surface])
    sides = facet_sides(mesh.cell)
    swapped = sides[[1, 0, *range(2, len(sides))] if mesh.is_simplex else _swapped(len(sides))]
    faces = np.where(_is_mirrored(mesh)[elements], swapped[facets], sides[facets]) + 1
    rising = np.lexsort((faces, elements))
    return elements[rising], faces[rising]


def _swapped(count: int) -> list[int]:
    """Facets of boxes, both of the first axis and both of the second changing places."""
    return [2, 3, 0, 1, *range(4, count)]
