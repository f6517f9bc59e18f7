"""Kinds of elements by their number of nodes, in the order that most programs list them."""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from cea.errors import require
from cea.mesh import DIMENSION, SIMPLICES, Cell, facet_nodes, lattice
from meshes.files.content import ElementBlock, Floats, Ints, Role

_SAME = 1e-6
"""Reference nodes nearer than this are one."""


class Kind(NamedTuple):
    """Cell, order and nodes of a kind of element.

    Parameters
    ----------
    cell
        A :data:`cea.mesh.Cell`, ``wedge`` or ``pyramid``.
    order
        Order of its geometry.
    groups
        Corners whose mean each node is; of a corner itself.
    reference
        Nodes of the reference cell, (n, dim), from 0 to 1.
    """

    cell: str
    order: int
    groups: tuple[tuple[int, ...], ...]
    reference: Floats


_CORNERS: dict[str, list[list[float]]] = {
    "triangle": [[0, 0], [1, 0], [0, 1]],
    "quadrilateral": [[0, 0], [1, 0], [1, 1], [0, 1]],
    "tetrahedron": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "pyramid": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]],
    "wedge": [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (0, 1))],
    "hexahedron": [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))],
}
_EDGES: dict[str, list[tuple[int, ...]]] = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quadrilateral": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "tetrahedron": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "pyramid": [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)],
    "wedge": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    "hexahedron": [
        *[(0, 1), (1, 2), (2, 3), (3, 0)],
        *[(4, 5), (5, 6), (6, 7), (7, 4)],
        *[(0, 4), (1, 5), (2, 6), (3, 7)],
    ],
}
"""Edges whose middles follow the corners: around the bottom, around the top, upright ones last."""
_MIDDLES: dict[str, list[tuple[int, ...]]] = {
    "quadrilateral": [(0, 1, 2, 3)],
    "pyramid": [(0, 1, 2, 3)],
    "wedge": [(0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    "hexahedron": [
        *[(0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)],
        tuple(range(8)),
    ],
}
"""Faces, and then all corners, whose middles follow those of the edges in VTK."""


def _kind(cell: str, *middles: Sequence[tuple[int, ...]]) -> Kind:
    """A kind whose nodes are corners, then the means of groups of corners."""
    at = np.array(_CORNERS[cell], dtype=float)
    groups = [*((corner,) for corner in range(len(at))), *(group for of in middles for group in of)]
    reference = np.array([at[list(group)].mean(axis=0) for group in groups])
    return Kind(cell, 2 if middles else 1, tuple(groups), reference)


def _kinds() -> dict[str, Kind]:
    """Kinds of all cells: linear, with middles of edges, with all middles."""
    made = [
        kind
        for cell in _CORNERS
        for kind in (
            _kind(cell),
            _kind(cell, _EDGES[cell]),
            _kind(cell, _EDGES[cell], _MIDDLES.get(cell, ())),
        )
    ]
    return {f"{kind.cell}{len(kind.groups)}": kind for kind in made}


KINDS: dict[str, Kind] = _kinds()
"""Kinds by cell and number of nodes, as hexahedron20: the order of VTK, Abaqus and Ansys."""

FACES: dict[str, list[tuple[int, ...]]] = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quadrilateral": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "tetrahedron": [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)],
    "pyramid": [(0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)],
    "wedge": [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)],
    "hexahedron": [
        *[(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)],
        *[(1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)],
    ],
}
"""Corners of the faces S1, S2, ... of Abaqus, counted anticlockwise as seen from inside."""


def full_kind(cell: str, order: int) -> Kind:
    """The kind of a cell with all nodes of its order, 1 or 2."""
    fitting = [kind for kind in KINDS.values() if (kind.cell, kind.order) == (cell, order)]
    return max(fitting, key=lambda kind: len(kind.groups))


def wanted_nodes(cell: str, order: int) -> Floats:
    """Reference nodes in the order in which :class:`ElementBlock` has them, (n, dim)."""
    for known, dim in DIMENSION.items():
        if cell == known:
            return lattice(dim, order, cell in SIMPLICES) / order
    return full_kind(cell, order).reference


@cache
def full_order(cell: str, order: int) -> Ints:
    """Place of each node of :func:`full_kind` among those of :class:`ElementBlock`, (n,)."""
    apart = full_kind(cell, order).reference[:, None] - wanted_nodes(cell, order)
    return np.linalg.norm(apart, axis=2).argmin(axis=1)


@cache
def side_nodes(cell: str, order: int) -> tuple[Ints, ...]:
    """Nodes on each face S1, S2, ... among those of :class:`ElementBlock`."""
    nodes, found = wanted_nodes(cell, order), []
    for face in FACES[cell]:
        at = np.array(_CORNERS[cell], dtype=float)[list(face)]
        normal = np.linalg.svd(at[1:] - at[0])[2][-1]
        found.append(np.flatnonzero(np.abs((nodes - at[0]) @ normal) < _SAME))
    return tuple(found)


@cache
def facet_sides(cell: Cell, order: int) -> Ints:
    """Face, 0 for S1, that each facet is as :func:`cea.mesh.facet_nodes` counts them."""
    sides = [set(side.tolist()) for side in side_nodes(cell, order)]
    return np.array([sides.index({*f.tolist()}) for f in facet_nodes(cell, order)], dtype=np.int64)


def in_order(cell: str, order: int, nodes: Ints, reference: Floats) -> Ints:
    """Nodes of elements in the order of :class:`ElementBlock`, -1 where they have none."""
    wanted = wanted_nodes(cell, order)
    apart = np.linalg.norm(wanted[:, None] - reference, axis=2)
    found, nearest = apart.min(axis=1) < _SAME, apart.argmin(axis=1)
    require(
        len(np.unique(nearest[found])) == len(reference),
        "file",
        f"{cell} of {len(reference)} nodes",
        f"nodes of a Lagrange cell of order {order}, or of one without some of them",
    )
    ordered = np.full((len(nodes), len(wanted)), -1, dtype=np.int64)
    ordered[:, found] = nodes[:, nearest[found]]
    return ordered


def block(
    name: str, kind: str, numbers: Ints, nodes: Ints, *, role: Role = "solid"
) -> ElementBlock:
    """Elements of a kind in :data:`KINDS`, as a file lists their nodes."""
    cell, order, _, reference = KINDS[kind]
    ordered = in_order(cell, order, nodes, reference)
    return ElementBlock(name, cell, order, numbers, ordered, role)
