"""Kinds of elements by their number of nodes, in the order that most programs list them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cea.mesh import Cell
from meshes.mesh_files.content import ElementBlock, Ints, Role, in_order

Floats = NDArray[np.float64]


class Kind(NamedTuple):
    """Cell, order and reference nodes (n, dim), from 0 to 1, of a kind of element."""

    cell: Cell
    order: int
    reference: Floats


_TRIANGLE = [[0, 0], [1, 0], [0, 1]]
_TETRAHEDRON = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
_SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
_CUBE = [[*xy, z] for z in (0, 1) for xy in _SQUARE]

_EDGES = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quadrilateral": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "tetrahedron": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [
        *[(0, 1), (1, 2), (2, 3), (3, 0)],
        *[(4, 5), (5, 6), (6, 7), (7, 4)],
        *[(0, 4), (1, 5), (2, 6), (3, 7)],
    ],
}
"""Edges whose middles follow the corners: around the bottom, around the top, upright ones last."""

_FACES = [(0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)]
"""Faces of a hexahedron of 27 nodes in the order of their middle nodes in VTK, then its centre."""


def _kind(cell: Cell, corners: list[list[int]], *groups: Sequence[tuple[int, ...]]) -> Kind:
    """A kind whose nodes are corners, then the means of groups of corners."""
    at = np.array(corners, dtype=float)
    means = [at[list(group)].mean(axis=0) for groups_of in groups for group in groups_of]
    return Kind(cell, 2 if groups else 1, np.array([*at, *means]))


KINDS: dict[str, Kind] = {
    "triangle3": _kind("triangle", _TRIANGLE),
    "triangle6": _kind("triangle", _TRIANGLE, _EDGES["triangle"]),
    "quadrilateral4": _kind("quadrilateral", _SQUARE),
    "quadrilateral8": _kind("quadrilateral", _SQUARE, _EDGES["quadrilateral"]),
    "quadrilateral9": _kind("quadrilateral", _SQUARE, _EDGES["quadrilateral"], [(0, 1, 2, 3)]),
    "tetrahedron4": _kind("tetrahedron", _TETRAHEDRON),
    "tetrahedron10": _kind("tetrahedron", _TETRAHEDRON, _EDGES["tetrahedron"]),
    "hexahedron8": _kind("hexahedron", _CUBE),
    "hexahedron20": _kind("hexahedron", _CUBE, _EDGES["hexahedron"]),
    "hexahedron27": _kind(
        "hexahedron",
        _CUBE,
        _EDGES["hexahedron"],
        _FACES,
        [tuple(range(8))],
    ),
}
"""Kinds by cell and number of nodes: the order of VTK, Abaqus and Ansys."""

FACES: dict[str, list[tuple[int, ...]]] = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quadrilateral": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "tetrahedron": [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)],
    "hexahedron": [
        *[(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)],
        *[(1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)],
    ],
}
"""Corners of the faces S1, S2, ... of Abaqus."""


def block(
    name: str, kind: str, numbers: Ints, nodes: Ints, *, role: Role = "solid"
) -> ElementBlock:
    """Elements of a kind in :data:`KINDS`, as a file lists their nodes.

    Parameters
    ----------
    name
        What the file calls them.
    kind
        Their kind.
    numbers
        Their numbers, (n,).
    nodes
        Rows of their nodes among the points, (n, n_nodes), in the order of the kind.
    role
        What the file means them for.
    """
    cell, order, reference = KINDS[kind]
    ordered = in_order(cell, order, nodes, reference)
    return ElementBlock(name, cell, order, numbers, ordered, role)
