"""Kinds of elements by their number of nodes, in the order that most programs list them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.mesh import Cell, Mesh, facet_nodes, node_order
from meshes.files.content import ElementBlock, Role

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


def lacks_middles(block: ElementBlock) -> bool:
    """Whether elements of second order have no nodes in the middle of faces or cells."""
    return block.order == 2 and len(block.reference) < len(full_kind(block.cell, 2).groups)


def side_nodes(block: ElementBlock) -> list[Ints]:
    """Nodes on each face S1, S2, ... among those of the elements."""
    found = []
    for face in FACES[block.cell]:
        at = block.reference[list(face)]
        normal = np.linalg.svd(at[1:] - at[0])[2][-1]
        found.append(np.flatnonzero(np.abs((block.reference - at[0]) @ normal) < _SAME))
    return found


def facet_sides(cell: Cell) -> Ints:
    """Face, 0 for S1, that each facet is as :func:`cea.mesh.facet_nodes` counts them."""
    corners = node_order(cell, 1, full_kind(cell, 1).reference)
    sides = [set(face) for face in FACES[cell]]
    facets = facet_nodes(cell, 1)
    return np.array([sides.index({*corners[f].tolist()}) for f in facets], dtype=np.int64)


def block(
    name: str, kind: str, numbers: Ints, nodes: Ints, *, role: Role = "solid"
) -> ElementBlock:
    """Elements of a kind in :data:`KINDS` whose nodes, (n, n_nodes), are in its order."""
    cell, order, _, reference = KINDS[kind]
    return ElementBlock(name, cell, order, numbers, nodes, reference, role)


def named_sides(mesh: Mesh) -> dict[str, NDArray[np.bool_]]:
    """Which facets of which cells have each name, (n_cells, n_facets)."""
    of_cell = facet_nodes(mesh.cell, mesh.order)
    found = {name: np.zeros((len(mesh.cells), len(of_cell)), dtype=bool) for name in mesh.surfaces}
    for side, local in enumerate(of_cell):
        nodes = np.sort(mesh.cells[:, local], axis=1)
        for name, facets in mesh.surfaces.items():
            found[name][np.isin(_keys(nodes), _keys(np.sort(facets, axis=1))), side] = True
    return found


def _keys(rows: Ints) -> NDArray[np.void]:
    """Rows as single values, equal for equal rows, (n,)."""
    return np.ascontiguousarray(rows).view([("", rows.dtype)] * rows.shape[1]).ravel()
