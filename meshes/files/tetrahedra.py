"""Hexahedra, wedges, pyramids and tetrahedra of one body divided into tetrahedra.

An element is divided from its corner of the lowest number: tetrahedra join it to triangles of the
faces that it does not lie on, and those are divided from their own lowest corner. The diagonal of a
face depends on the numbers of its corners alone, so that neighbours match (Dompierre, Labbe, Vallet
and Camarero, How to subdivide pyramids, prisms and hexahedra into tetrahedra, 1999).

Elements of second order keep the middles of their edges. The middle of the diagonal of a face is
that of the face, the middle of the diagonal of a hexahedron its centre: where an element has no
node there, its own (serendipity) shape functions put one.
"""

from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cea.errors import InputError, require
from cea.mesh import facet_nodes, lattice, reference_nodes
from meshes.files.content import ElementBlock, Floats, Ints, node_marks
from meshes.files.kinds import FACES, KINDS, full_kind, full_order, in_order


class Tetrahedra(NamedTuple):
    """Elements divided into tetrahedra."""

    points: Floats
    cells: Ints
    elements: Ints
    sides: Ints


def tetrahedra(points: Floats, blocks: Sequence[ElementBlock]) -> Tetrahedra:
    """Divide solid elements of a body into tetrahedra that match across faces."""
    orders = sorted({block.order for block in blocks})
    kinds = ", ".join(sorted({block.kind for block in blocks}))
    allowed = "elements that are all of order 1 or all of order 2, where a body has several kinds"
    require(orders in ([1], [2]), "file", kinds, allowed)
    points, nodes = completed(points, blocks)
    starts = np.cumsum([0, *map(len, blocks)])
    parts = [
        _divided(block.cell, orders[0], own, int(start))
        for block, own, start in zip(blocks, nodes, starts, strict=False)
    ]
    return Tetrahedra(points, *(np.concatenate(part) for part in zip(*parts, strict=True)))


def completed(points: Floats, blocks: Sequence[ElementBlock]) -> tuple[Floats, list[Ints]]:
    """Points, and nodes of each block, with the middles of faces and cells that were lacking.

    The shape functions of elements that have no such nodes lie in the space of those that do, so
    that the geometry is what it was where these put them.
    """
    nodes, marks = [block.nodes.copy() for block in blocks], node_marks(len(points))
    columns: list[tuple[int, int]] = []
    keys: list[NDArray[np.uint64]] = []
    at: list[Floats] = []
    for i, block in enumerate(blocks):
        if not (nodes[i] < 0).any():
            continue
        _check_edges(block)
        kind, place = full_kind(block.cell, 2), full_order(block.cell, 2)
        for group, column in zip(kind.groups, place, strict=True):
            if len(group) < 4:
                continue
            edges = [k for k, two in enumerate(kind.groups) if len(two) == 2 and {*two} <= {*group}]
            weight = 0.5 if len(group) == 4 else 0.25  # of a face, of a hexahedron
            corners, middles = block.nodes[:, place[list(group)]], block.nodes[:, place[edges]]
            columns.append((i, column))
            keys.append(marks[corners].sum(axis=1, dtype=np.uint64))
            at.append(weight * points[middles].sum(axis=1) - 0.25 * points[corners].sum(axis=1))
    if not columns:
        return points, nodes
    _, first, same = np.unique(np.concatenate(keys), return_index=True, return_inverse=True)
    number = np.full(len(first), -1, dtype=np.int64)
    given = np.concatenate([nodes[i][:, column] for i, column in columns])
    np.maximum.at(number, same, given)  # a neighbour may have the node
    new = number < 0
    number[new] = len(points) + np.arange(new.sum())
    ends = np.cumsum([len(each) for each in keys])[:-1]
    for (i, column), numbers in zip(columns, np.split(number[same], ends), strict=True):
        nodes[i][:, column] = numbers
    return np.concatenate([points, np.concatenate(at)[first[new]]]), nodes


def _check_edges(block: ElementBlock) -> None:
    """Refuse elements that lack other nodes than the middles of faces and cells."""
    lacks = (block.nodes < 0).any(axis=1)
    if block.order == 2:
        groups, place = full_kind(block.cell, 2).groups, full_order(block.cell, 2)
        needed = place[[len(group) < 4 for group in groups]]
        lacks = (block.nodes[:, needed] < 0).any(axis=1)
    if lacks.any():
        worst = int(block.numbers[np.argmax(lacks)])
        raise InputError("file", f"element {worst}", "elements with the middles of all edges")


def _divided(cell: str, order: int, nodes: Ints, start: int) -> tuple[Ints, Ints, Ints]:
    """Tetrahedra of elements of one kind, the element of each, the faces of their facets."""
    place = full_order(cell, order)
    elements, local = _pieces(cell, nodes[:, place])
    local = in_order("tetrahedron", 1, local, KINDS["tetrahedron4"].reference)
    middle, ends = place[_middles(cell, order)], _ends(order)
    cells = nodes[elements[:, None], middle[local[:, ends[:, 0]], local[:, ends[:, 1]]]]
    on = np.array([[c in face for face in FACES[cell]] for c in range(local.max() + 1)])
    sides = np.full((len(cells), 4), -1, dtype=np.int64)
    for facet, corners in enumerate(facet_nodes("tetrahedron", 1)):
        faces = on[local[:, corners]].all(axis=1)
        sides[:, facet] = np.where(faces.any(axis=1), faces.argmax(axis=1), -1)
    return cells, start + elements, sides


def _pieces(cell: str, nodes: Ints) -> tuple[Ints, Ints]:
    """Tetrahedra by the corners of their element, with positive volume, and the element of each."""
    corners = nodes[:, : len(full_kind(cell, 1).groups)]
    lowest = corners.argmin(axis=1)
    rows, pieces = [], []
    for face in FACES[cell]:
        around = np.array(face)
        own = np.flatnonzero((lowest[:, None] != around).all(axis=1))
        first = corners[own][:, around].argmin(axis=1)
        turned = around[(first[:, None] + np.arange(len(around))) % len(around)]
        for k in range(1, len(around) - 1):
            rows.append(own)
            pieces.append(np.column_stack([turned[:, [0, k, k + 1]], lowest[own]]))
    elements = np.concatenate(rows)
    order = np.argsort(elements, kind="stable")
    return elements[order], np.concatenate(pieces)[order]


def _middles(cell: str, order: int) -> Ints:
    """Node of :func:`full_kind` in the middle of each two corners, (n_corners, n_corners)."""
    kind = full_kind(cell, order)
    corners = kind.reference[: len(full_kind(cell, 1).groups)]
    means = (corners[:, None] + corners) / 2
    apart = np.linalg.norm(means[:, :, None] - kind.reference, axis=3)
    return apart.argmin(axis=2).astype(np.int64)


def _ends(order: int) -> Ints:
    """Two corners in whose middle each node of a tetrahedron is, the same at corners, (n, 2)."""
    corners = reference_nodes("tetrahedron", 1).astype(np.int64)
    pairs = list(combinations_with_replacement(range(4), 2))
    middles = [(corners[a] + corners[b]).tolist() for a, b in pairs]
    wanted = lattice(3, order, simplex=True) * (2 // order)
    return np.array([pairs[middles.index(node)] for node in wanted.tolist()], dtype=np.int64)
