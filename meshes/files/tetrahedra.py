"""Division of hexahedra, wedges, pyramids and tetrahedra of one body into tetrahedra.

An element is divided from its corner of the lowest number: tetrahedra join it to triangles of the
faces that it does not lie on, and those are divided from their own lowest corner. The diagonal of a
face depends on the numbers of its corners alone, so that neighbours match (Dompierre, Labbe, Vallet
and Camarero, How to subdivide pyramids, prisms and hexahedra into tetrahedra, 1999).

Elements of second order keep the middles of their edges. The middle of the diagonal of a face is
that of the face, the middle of the diagonal of a hexahedron its centre: where an element has no
node there, its own (serendipity) shape functions put one.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cea.arrays import Floats, Ints
from cea.mesh import facet_nodes, node_order
from meshes.files.content import ElementBlock, node_marks
from meshes.files.elements import CORNERS, FACES, full_kind


def tetrahedra(points: Floats, blocks: Sequence[ElementBlock]) -> tuple[Floats, Ints, Ints, Ints]:
    """Divide solid elements of a body, all of order 1 or all of order 2, into tetrahedra.

    Return points (n, 3), added ones last; nodes of the tetrahedra in the order of
    :class:`cea.mesh.Mesh`; the element of each, rising, (m,); the face of that element, 0 for its
    S1, on which each facet lies, -1 inside, (m, 4).
    """
    points, full = completed(points, blocks)
    starts = np.cumsum([0, *map(len, blocks)])
    parts = [_divided(block, int(start)) for block, start in zip(full, starts, strict=False)]
    cells, elements, sides = (np.concatenate(part) for part in zip(*parts, strict=True))
    return points, cells, elements, sides


def completed(
    points: Floats, blocks: Sequence[ElementBlock]
) -> tuple[Floats, Sequence[ElementBlock]]:
    """Points and elements, with the middles of faces and cells that elements lack.

    Serendipity shape functions lie in the space of the complete ones, so that nodes that they place
    leave the geometry unchanged. Nodes that a neighbour has are used.
    """
    if not any(block.lacks_middles for block in blocks):
        return points, blocks
    marks = node_marks(len(points))
    nodes, keys, at, columns = [], [], [], []
    for block in blocks:
        groups = full_kind(block.cell, 2).groups
        own = np.full((len(block), len(groups)), -1, dtype=np.int64)
        own[:, : block.nodes.shape[1]] = block.nodes
        nodes.append(own)
        for column, group in enumerate(groups):
            if len(group) >= 4:
                edges = [k for k, two in enumerate(groups) if len(two) == 2 and {*two} <= {*group}]
                weight = 0.5 if len(group) == 4 else 0.25  # of a face, of a hexahedron
                corners, middles = own[:, list(group)], own[:, edges]
                keys.append(marks[corners].sum(axis=1, dtype=np.uint64))
                at.append(weight * points[middles].sum(axis=1) - points[corners].sum(axis=1) / 4)
                columns.append((own, column))
    _, first, same = np.unique(np.concatenate(keys), return_index=True, return_inverse=True)
    number = np.full(len(first), -1, dtype=np.int64)
    np.maximum.at(number, same, np.concatenate([own[:, column] for own, column in columns]))
    new = number < 0
    number[new] = len(points) + np.arange(new.sum())
    ends = np.cumsum([len(each) for each in keys])[:-1]
    for (own, column), numbers in zip(columns, np.split(number[same], ends), strict=True):
        own[:, column] = numbers
    full = [
        replace(block, nodes=own, reference=full_kind(block.cell, 2).reference)
        for block, own in zip(blocks, nodes, strict=True)
    ]
    return np.concatenate([points, np.concatenate(at)[first[new]]]), full


def _divided(block: ElementBlock, start: int) -> tuple[Ints, Ints, Ints]:
    """Tetrahedra of elements of one kind, the element of each, the faces of their facets."""
    elements, local = _pieces(block)
    kind = full_kind("tetrahedron", block.order)
    middle = _middles(block.cell, block.order)
    nodes = [middle[local[:, group[0]], local[:, group[-1]]] for group in kind.groups]
    order = node_order("tetrahedron", block.order, kind.reference)
    cells = block.nodes[elements[:, None], np.stack(nodes, axis=1)[:, order]]
    local = local[:, node_order("tetrahedron", 1, CORNERS["tetrahedron"])]
    on = np.array([[c in face for face in FACES[block.cell]] for c in range(local.max() + 1)])
    sides = np.full((len(cells), 4), -1, dtype=np.int64)
    for facet, corners in enumerate(facet_nodes("tetrahedron", 1)):
        faces = on[local[:, corners]].all(axis=1)
        sides[:, facet] = np.where(faces.any(axis=1), faces.argmax(axis=1), -1)
    return cells, start + elements, sides


def _pieces(block: ElementBlock) -> tuple[Ints, Ints]:
    """Element of each tetrahedron, and its corners among those of the element, right-handed."""
    corners = block.corners
    lowest = corners.argmin(axis=1)
    rows, pieces = [], []
    for face in FACES[block.cell]:
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
    """Node of :func:`full_kind` midway between each two corners, (n_corners, n_corners)."""
    kind = full_kind(cell, order)
    corners = CORNERS[cell]
    means = (corners[:, None] + corners) / 2
    apart = np.linalg.norm(means[:, :, None] - kind.reference, axis=3)
    return apart.argmin(axis=2).astype(np.int64)
