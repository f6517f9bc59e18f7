"""Types of elements, one table for every format: nodes of the reference cell, edges and faces.

Nodes are in the order of VTK, Abaqus and Ansys: corners, middles of edges, middles of faces and of
the cell. Readers convert the elements of a file to this table.
"""

from typing import NamedTuple

import numpy as np

from cea.arrays import Floats, Ints
from cea.mesh import Cell, facet_nodes, node_order

_SAME = 1e-6
"""Distance from a face of the reference cell below which a node lies on it."""
DIVIDED = ("wedge", "pyramid")
"""Cells that are always divided into tetrahedra (:mod:`meshes.files.tetrahedra`)."""


class Kind(NamedTuple):
    """Cell, order, corners whose mean is each node, nodes of the reference cell from 0 to 1."""

    cell: str
    order: int
    groups: tuple[tuple[int, ...], ...]
    reference: Floats


_SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
_TRIANGLE = [[0, 0], [1, 0], [0, 1]]
CORNERS: dict[str, Floats] = {
    "line": np.array([[0.0], [1.0]]),
    "triangle": np.array(_TRIANGLE, dtype=float),
    "quadrilateral": np.array(_SQUARE, dtype=float),
    "tetrahedron": np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    "pyramid": np.array([*([x, y, 0] for x, y in _SQUARE), [0.5, 0.5, 1]]),
    "wedge": np.array([[x, y, z] for z in (0.0, 1.0) for x, y in _TRIANGLE]),
    "hexahedron": np.array([[x, y, z] for z in (0.0, 1.0) for x, y in _SQUARE]),
}
"""Corners of the reference cells."""


def _groups(text: str) -> list[tuple[int, ...]]:
    return [tuple(map(int, group)) for group in text.split()]


_EDGES = {
    "triangle": _groups("01 12 20"),
    "quadrilateral": _groups("01 12 23 30"),
    "tetrahedron": _groups("01 12 20 03 13 23"),
    "pyramid": _groups("01 12 23 30 04 14 24 34"),
    "wedge": _groups("01 12 20 34 45 53 03 14 25"),
    "hexahedron": _groups("01 12 23 30 45 56 67 74 04 15 26 37"),
}
"""Corners of the edges whose middles follow the corners."""
_MIDDLES = {
    "quadrilateral": _groups("0123"),
    "pyramid": _groups("0123"),
    "wedge": _groups("0143 1254 2035"),
    "hexahedron": _groups("0374 1265 0154 3267 0123 4567 01234567"),
}
"""Corners of faces, and of the cell, whose middles follow those of the edges."""
FACES = {
    "triangle": _groups("01 12 20"),
    "quadrilateral": _groups("01 12 23 30"),
    "tetrahedron": _groups("012 031 132 230"),
    "pyramid": _groups("0123 041 142 243 340"),
    "wedge": _groups("012 354 0341 1452 2530"),
    "hexahedron": _groups("0123 4765 0451 1562 2673 3740"),
}
"""Corners of the faces S1, S2, ... of Abaqus, counted anticlockwise as seen from inside."""


def _kind(cell: str, order: int, middles: list[tuple[int, ...]]) -> Kind:
    """A kind whose nodes are corners, then the means of groups of corners."""
    corners = CORNERS[cell]
    groups = (*((corner,) for corner in range(len(corners))), *middles)
    return Kind(cell, order, groups, np.array([corners[list(g)].mean(axis=0) for g in groups]))


KINDS: dict[str, Kind] = {
    f"{kind.cell}{len(kind.groups)}": kind
    for cell, edges in _EDGES.items()
    for kind in (
        _kind(cell, 1, []),
        _kind(cell, 2, edges),
        _kind(cell, 2, edges + _MIDDLES.get(cell, [])),
    )
}
"""Kinds by cell and number of nodes, as hexahedron20."""


def full_kind(cell: str, order: int) -> Kind:
    """The kind of a cell with all nodes of its order, 1 or 2."""
    fitting = [kind for kind in KINDS.values() if (kind.cell, kind.order) == (cell, order)]
    return max(fitting, key=lambda kind: len(kind.groups))


def side_nodes(cell: str, reference: Floats) -> list[Ints]:
    """Nodes on each face S1, S2, ... of a cell among its reference nodes."""
    found = []
    for face in FACES[cell]:
        at = CORNERS[cell][list(face)]
        normal = np.linalg.svd(at[1:] - at[0])[2][-1]
        found.append(np.flatnonzero(np.abs((reference - at[0]) @ normal) < _SAME))
    return found


def facet_sides(cell: Cell) -> Ints:
    """Face, 0 for S1, of each facet in the order of :func:`cea.mesh.facet_nodes`."""
    corners = node_order(cell, 1, CORNERS[cell])
    sides = [set(face) for face in FACES[cell]]
    facets = facet_nodes(cell, 1)
    return np.array([sides.index({*corners[f].tolist()}) for f in facets], dtype=np.int64)
