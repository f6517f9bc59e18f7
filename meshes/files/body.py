"""The mesh of a body from the content of a mesh file: its nodes, elements and faces are checked."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.mesh import (
    DIMENSION,
    SIMPLICES,
    Cell,
    Mesh,
    facet_nodes,
    lattice,
    node_order,
    reference_nodes,
)
from meshes.files.content import FileContent, node_marks
from meshes.files.elements import facet_sides, full_kind
from meshes.files.part import Part, check_nodes
from meshes.files.surfaces import surface_faces
from meshes.files.tetrahedra import completed, tetrahedra


def body_mesh(
    content: FileContent, own: Part, faces: Mapping[str, Sequence[str]], name: str | None = None
) -> Mesh:
    """Mesh of a part of a file, in its unit."""
    check_nodes(content, own, name)
    points = content.points[:, : own.dim]
    if own.is_divided:
        points, cells, elements, sides = tetrahedra(points, own.blocks)
    else:
        points, blocks = completed(points, own.blocks)
        cells = np.concatenate(
            [b.nodes[:, node_order(own.cell, own.order, b.reference)] for b in blocks]
        )
        elements = np.arange(len(cells))
        sides = np.tile(facet_sides(own.cell), (len(cells), 1))
    check_elements(own.cell, own.order, points, cells, own.numbers[elements])
    check_matching(own.cell, own.order, cells, own.numbers[elements])
    facets = facet_nodes(own.cell, own.order)
    surfaces = {}
    for surface, (on, _) in surface_faces(content, own, faces).items():
        chosen = on[elements[:, None], sides] & (sides >= 0)
        surfaces[surface] = np.concatenate(
            [cells[chosen[:, i]][:, facet] for i, facet in enumerate(facets)]
        )
    return Mesh(own.cell, own.order, points, cells, surfaces).without_loose_points()


_INWARD = 0.775
"""Where Jacobians are looked at: so far from the middle towards each node, as Gauss points lie."""
_FLAT = 1e-10
"""Smallest Jacobian of an element, relative to its largest, that is not called flat."""
_AT_ONCE = 20_000
"""Elements whose Jacobians are in memory together."""


def check_elements(cell: Cell, order: int, points: Floats, cells: Ints, numbers: Ints) -> None:
    """Refuse elements whose Jacobian is not positive; in the plane, does not keep its sign."""
    dim, slopes = DIMENSION[cell], _slopes(cell, order)
    least, most = np.empty(len(cells)), np.empty(len(cells))
    for start in range(0, len(cells), _AT_ONCE):
        rows = slice(start, start + _AT_ONCE)
        x = points[cells[rows]]
        jacobians = np.linalg.det(np.einsum("qnj,cni->cqij", slopes, x, optimize=True))
        least[rows], most[rows] = jacobians.min(axis=1), jacobians.max(axis=1)
    if dim == 2 and (most < 0).sum() > len(cells) / 2:  # seen from behind
        least, most = -most, -least
    inverted = ~(least > _FLAT * most)
    if inverted.any():
        first = int(numbers[np.argmax(inverted)])
        allowed = "elements whose Jacobian is positive: these are inverted, flat, or list their "
        value = f"{inverted.sum()} of {len(cells)} elements, the first {first}"
        raise InputError("file", value, f"{allowed}nodes in another order than the format has")


def check_matching(cell: Cell, order: int, cells: Ints, numbers: Ints) -> None:
    """Refuse cells whose edges or faces do not match those of their neighbours.

    Two cells may have one edge with two nodes in its middle, or two edges with one; in simplices
    in space, the triangles on both sides of a square may be cut along different diagonals.
    """
    marks = node_marks(int(cells.max()) + 1)
    wrong = _middles_apart(cell, cells, marks) if order == 2 else None
    if wrong is None and cell == "tetrahedron":
        are_corners = (reference_nodes(cell, order) % 1 == 0).all(axis=1)
        wrong = _crossing(cells[:, are_corners], marks)
    if wrong is not None:
        allowed = "elements whose edges and faces match those of their neighbours"
        raise InputError("file", f"element {int(numbers[wrong])}", allowed)


def _middles_apart(cell: Cell, cells: Ints, marks: NDArray[np.uint64]) -> int | None:
    """First cell with an edge whose middle is not that of the same edge of others alone."""
    kind = full_kind(cell, 2)
    place = np.argsort(node_order(cell, 2, kind.reference))
    found = [place[[*group, i]] for i, group in enumerate(kind.groups) if len(group) == 2]
    ends = np.stack([marks[cells[:, a]] + marks[cells[:, b]] for a, b, _ in found], axis=1).ravel()
    middles = cells[:, [column for *_, column in found]].ravel()
    for keys, values in ((ends, middles), (middles, ends)):
        _, first, same = np.unique(keys, return_index=True, return_inverse=True)
        apart = values != values[first][same]
        if apart.any():
            return int(np.argmax(apart)) // len(found)
    return None


def _crossing(corners: Ints, marks: NDArray[np.uint64]) -> int | None:
    """First tetrahedron at a free square that is cut along two diagonals."""
    sides = facet_nodes("tetrahedron", 1)
    triangles = np.concatenate([corners[:, side] for side in sides])
    owners = np.tile(np.arange(len(corners)), len(sides))
    sums = marks[triangles].sum(axis=1, dtype=np.uint64)
    _, same, times = np.unique(sums, return_inverse=True, return_counts=True)
    free = times[same] == 1
    triangles, owners, sums = triangles[free], owners[free], sums[free]
    ends = np.concatenate(
        [marks[triangles[:, [a, b]]].sum(axis=1) for a, b in ((0, 1), (1, 2), (2, 0))]
    )
    order = np.argsort(ends, kind="stable")
    rows = np.tile(np.arange(len(triangles)), 3)[order]
    pair = np.flatnonzero(np.diff(ends[order]) == 0)
    first, second, edge = rows[pair], rows[pair + 1], ends[order[pair]]
    squares = sums[first] + sums[second] - edge  # the marks of all four corners
    order = np.argsort(squares, kind="stable")
    again = np.flatnonzero(np.diff(squares[order]) == 0)
    a, b = order[again], order[again + 1]
    crosses = edge[a] + edge[b] == squares[a]  # edges without a common corner
    apart = [owners[x[a]] != owners[y[b]] for x in (first, second) for y in (first, second)]
    wrong = np.flatnonzero(crosses & np.all(apart, axis=0))
    return int(owners[first[a[wrong[0]]]]) if len(wrong) else None


def _slopes(cell: Cell, order: int) -> Floats:
    """Slopes of the shape functions at points inside the reference cell, (points, nodes, dim)."""
    nodes = reference_nodes(cell, order)
    inside = np.vstack([nodes.mean(axis=0), nodes + (1 - _INWARD) * (nodes.mean(axis=0) - nodes)])
    powers = lattice(nodes.shape[1], order, cell in SIMPLICES)
    values = np.prod(nodes[:, None] ** powers, axis=2)
    slopes = []
    for axis in np.eye(nodes.shape[1], dtype=int):
        lowered = np.maximum(powers - axis, 0)
        slopes.append((powers @ axis) * np.prod(inside[:, None] ** lowered, axis=2))
    return np.einsum("dqp,pn->qnd", slopes, np.linalg.inv(values))
