"""Elements of Abaqus and CalculiX: their names, the order of their nodes, their faces."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cea.mesh import Cell, Floats, Ints, Mesh, matching_nodes, reference_nodes

_TRIANGLE = ((0, 0), (1, 0), (0, 1))
_SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))
_TETRAHEDRON = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
_CUBE = tuple((*corner, z) for z in (0, 1) for corner in _SQUARE)


@dataclass(frozen=True)
class ElementType:
    """An element of a deck.

    Parameters
    ----------
    name
        Its name, as in ``C3D10``.
    corners
        Corners of the reference cell in its order.
    edges
        Ends of the edges that bear a node in the middle, as corners, in its order.
    faces
        Corners of its faces S1, S2, ...
    """

    name: str
    corners: tuple[tuple[int, ...], ...]
    edges: tuple[tuple[int, int], ...]
    faces: tuple[tuple[int, ...], ...]

    @property
    def nodes(self) -> Floats:
        """Nodes of the reference cell in its order, (n_nodes, dim), from 0 to 1."""
        corners = np.array(self.corners, dtype=float)
        middles = [(corners[i] + corners[j]) / 2 for i, j in self.edges]
        return np.vstack([corners, *middles])


_TETRAHEDRON_FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
_CUBE_FACES = (
    *((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)),
    *((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
)
_AROUND_TRIANGLE = ((0, 1), (1, 2), (2, 0))
_AROUND_SQUARE = ((0, 1), (1, 2), (2, 3), (3, 0))

ELEMENTS: Mapping[tuple[Cell, int], ElementType] = {
    ("tetrahedron", 1): ElementType("C3D4", _TETRAHEDRON, (), _TETRAHEDRON_FACES),
    ("tetrahedron", 2): ElementType(
        "C3D10",
        _TETRAHEDRON,
        (*_AROUND_TRIANGLE, (0, 3), (1, 3), (2, 3)),
        _TETRAHEDRON_FACES,
    ),
    ("hexahedron", 1): ElementType("C3D8", _CUBE, (), _CUBE_FACES),
    ("triangle", 1): ElementType("CPE3", _TRIANGLE, (), _AROUND_TRIANGLE),
    ("triangle", 2): ElementType("CPE6", _TRIANGLE, _AROUND_TRIANGLE, _AROUND_TRIANGLE),
    ("quadrilateral", 1): ElementType("CPE4", _SQUARE, (), _AROUND_SQUARE),
}
"""Elements by kind of cell and degree. Squares and cubes of higher degree have a node inside here,
none there: there is no counterpart."""


def element_nodes(mesh: Mesh) -> Ints:
    """Nodes of each cell in the order of its element type, right-handed, (n_cells, n_nodes)."""
    nodes = ELEMENTS[mesh.cell, mesh.order].nodes
    own = reference_nodes(mesh.cell, mesh.order)
    straight = mesh.cells[:, matching_nodes(nodes, own)]
    mirrored = mesh.cells[:, matching_nodes(nodes[:, [1, 0, *range(2, mesh.dim)]], own)]
    first = _first_edges(mesh)
    edges = mesh.points[straight[:, first[1:]]] - mesh.points[straight[:, :1]]
    return np.where(np.linalg.det(edges)[:, None] < 0, mirrored, straight)


def _first_edges(mesh: Mesh) -> Ints:
    """Numbers of the corners (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1) in its element type."""
    wanted = np.vstack([np.zeros(mesh.dim), np.eye(mesh.dim)])
    corners = np.array(ELEMENTS[mesh.cell, mesh.order].corners)
    return np.array([int(np.flatnonzero((corners == w).all(axis=1))[0]) for w in wanted])


def faces_of(mesh: Mesh, elements: Ints, facets: Ints) -> tuple[Ints, Ints]:
    """Elements and faces that facets of a mesh are.

    Parameters
    ----------
    mesh
        The mesh.
    elements
        Nodes of its elements as :func:`element_nodes` gives them.
    facets
        Facets by all their nodes, (n_facets, n_facet_nodes).

    Returns
    -------
    tuple of ndarray
        Numbers of the elements, from 0, rising, and of their faces, from 1, (n_facets,).
    """
    on = np.zeros(len(mesh.points), dtype=bool)
    on[facets] = True
    faces = ELEMENTS[mesh.cell, mesh.order].faces
    corners = facets[:, _facet_corners(mesh, len(faces[0]))]
    candidates, owners, sides = [], [], []
    for side, face in enumerate(faces, start=1):
        nodes = elements[:, face]
        owner = np.flatnonzero(on[nodes].all(axis=1))
        candidates.append(nodes[owner])
        owners.append(owner)
        sides.append(np.full(len(owner), side))
    rows = np.sort(np.concatenate([corners, *candidates]), axis=1)
    _, group = np.unique(rows, axis=0, return_inverse=True)
    wanted = np.isin(group[len(corners) :], group[: len(corners)])
    found, numbers = np.concatenate(owners)[wanted], np.concatenate(sides)[wanted]
    rising = np.lexsort((numbers, found))
    return found[rising], numbers[rising]


def _facet_corners(mesh: Mesh, count: int) -> Ints:
    """Places of the corners among the nodes of a facet, which are in C order of its lattice."""
    n = mesh.order + 1
    if mesh.dim == 2:
        return np.array([0, mesh.order])
    if count == 3:
        return np.array([0, mesh.order, n * (n + 1) // 2 - 1])
    return np.array([0, mesh.order, n * mesh.order, n * n - 1])
