"""The elements of a mesh file that form a body, and its checked mesh."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints, chunks, connected
from cea.errors import InputError, require
from cea.mesh import SIMPLICES, Cell, Mesh, facet_nodes, lattice, node_order, reference_nodes
from meshes.files.content import (
    ElementBlock,
    FileContent,
    Sets,
    facets_on,
    first_of_near,
    node_marks,
    shown,
)
from meshes.files.elements import DIVIDED, FACES, facet_sides, full_kind, side_nodes
from meshes.files.tetrahedra import completed, tetrahedra

_SAME = 1e-6
"""Distance of nodes, relative to the shortest edge, below which they coincide."""
_FLAT = 1e-9
"""Thickness of a mesh, relative to its extent, below which it is plane."""
_INWARD = 0.775
"""Relative distance from the middle towards each node at which Jacobians are checked."""
_LEAST = 1e-10
"""Smallest Jacobian of an element, relative to its largest, below which it is flat."""


@dataclass(frozen=True, eq=False)
class Part:
    """Elements that form a body."""

    blocks: tuple[ElementBlock, ...]
    elements: Ints

    @property
    def is_divided(self) -> bool:
        """Whether its mesh divides its elements into tetrahedra."""
        cells = {block.cell for block in self.blocks}
        return len(cells) > 1 or not cells.isdisjoint(DIVIDED)

    @property
    def num_cells(self) -> int:
        """Number of cells of its mesh; an estimate if elements are divided into tetrahedra."""
        return len(self.elements) * (5 if self.is_divided else 1)

    @property
    def cell(self) -> Cell:
        """Cells of its mesh."""
        return "tetrahedron" if self.is_divided else self.blocks[0].cell  # type: ignore[return-value]

    @property
    def order(self) -> int:
        """Order of their geometry."""
        return self.blocks[0].order

    @property
    def dim(self) -> int:
        """Dimension of its cells."""
        return self.blocks[0].dim

    @cached_property
    def numbers(self) -> Ints:
        """Numbers of its elements in the file, (n,)."""
        return np.concatenate([block.numbers for block in self.blocks])

    @cached_property
    def used(self) -> Ints:
        """Nodes of its elements, as rows of the points, rising."""
        return np.unique(np.concatenate([block.nodes.ravel() for block in self.blocks]))

    def faces(self) -> Iterator[tuple[slice, int, Ints, Ints]]:
        """Yield rows of elements, number, corners and nodes of the faces of a kind and number."""
        start = 0
        for block in self.blocks:
            rows = slice(start, start := start + len(block))
            sides = zip(FACES[block.cell], side_nodes(block.cell, block.reference), strict=True)
            for i, (face, side) in enumerate(sides):
                yield rows, i, block.corners[:, face], block.nodes[:, side]

    @property
    def incomplete(self) -> bool:
        """Whether its elements lack nodes of Lagrange cells, as 20-node hexahedra do."""
        return any(block.lacks_middles for block in self.blocks)


_SOLIDS = "triangles, quadrilaterals, tetrahedra, pyramids, wedges or hexahedra"
"""Elements that bodies are made of."""


def part_of(content: FileContent, file: str, name: str | None, marks: Iterable[str] = ()) -> Part:
    """Elements of a set, or all solid ones of a file; refuse those that cannot form a body."""
    starts, dim = content.starts, content.dim
    chosen = np.ones(starts[-1], dtype=bool)
    if name is not None:
        known = shown(content.element_sets)
        require(name in content.element_sets, "part", name, f"a set of elements: {known}")
        chosen[:] = False
        chosen[content.element_sets[name]] = True
    taken = np.zeros(starts[-1], dtype=bool)
    for mark in marks:
        taken[content.element_sets.get(mark, np.empty(0, dtype=int))] = True
    solid, elements, others = list[ElementBlock](), list[Ints](), set[str]()
    for block, start, end in zip(content.blocks, starts, starts[1:], strict=False):
        own = start + np.flatnonzero(chosen[start:end])
        is_keyword = block.role == "keyword" and len(own) > 0
        if is_keyword or (block.role == "structural" and not taken[own].all()):
            others.add(block.kind)
        if block.role == "solid" and len(own) and block.dim in (0, dim):
            solid.append(block.only(own - start))
            elements.append(own)
    sets = f"sets of elements: {shown(content.element_sets)}"
    if others:
        allowed = f"a set of solid elements alone, here are {shown(sorted(others))} too; {sets}"
        raise InputError("part", name, allowed)
    if strange := sorted({b.kind for b in solid if b.dim == 0}):
        where = f" in the part {name}" if name else ""
        told = f"{file}: {shown(strange)}{where}"
        raise InputError("file", told, f"solid elements that are {_SOLIDS}")
    cells, orders = {b.cell for b in solid}, {b.order for b in solid}
    alike = len(cells) == len(orders) == 1 and dim > 1 and cells.isdisjoint(DIVIDED)
    if not alike and (dim < 3 or orders not in ({1}, {2})):
        allowed = (
            f"solid elements, {_SOLIDS}, of one kind; or of several in space, all of order 1 or "
            f"all of order 2; in {file} are: {shown(sorted({b.kind for b in solid}))}; {sets}"
        )
        raise InputError("part", name, allowed)
    return Part(tuple(solid), np.concatenate(elements))


def merged(content: FileContent, distance: float) -> FileContent:
    """The content with nodes nearer than a distance (unit of the file) merged."""
    cells = [block.corners for block in content.blocks if block.dim > 1 and len(block)]
    shortest = min((float(_edges(content.points, c).min()) for c in cells), default=np.inf)
    allowed = f"less than half the shortest edge of an element, {shortest:g}"
    require(distance < shortest / 2, "merge_nodes", distance, allowed)
    number = first_of_near(content.points, distance)
    blocks = [replace(block, nodes=number[block.nodes]) for block in content.blocks]
    sets = content.node_sets
    any_case = isinstance(sets, Sets) and sets.any_case
    moved = Sets(sets, lambda name: np.unique(number[sets[name]]), any_case=any_case)
    return replace(content, blocks=blocks, node_sets=moved)


def body_mesh(
    content: FileContent, own: Part, faces: Mapping[str, NDArray[np.bool_]], name: str | None = None
) -> Mesh:
    """Checked mesh of a part of a file, in its unit; faces of elements give its surfaces."""
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
    numbers = own.numbers[elements]
    are_corners = (reference_nodes(own.cell, own.order) % 1 == 0).all(axis=1)
    corners = cells[:, are_corners]
    _check_nodes(content, own, points, corners, numbers, name)
    check_elements(own.cell, own.order, points, cells, numbers)
    marks = node_marks(len(points))
    wrong = _middles_apart(own.cell, cells, marks) if own.order == 2 else None
    if wrong is None and own.cell == "tetrahedron":
        wrong = _crossing(corners, marks)
    if wrong is not None:
        allowed = "elements whose edges and faces match those of their neighbours"
        raise InputError("file", f"element {int(numbers[wrong])}", allowed)
    surfaces = {
        surface: facets_on(own.cell, own.order, cells, on[elements[:, None], sides] & (sides >= 0))
        for surface, on in faces.items()
    }
    return Mesh(own.cell, own.order, points, cells, surfaces).without_loose_points()


def _check_nodes(
    content: FileContent, part: Part, points: Floats, corners: Ints, numbers: Ints, name: str | None
) -> None:
    """Refuse a part that is not connected, has coincident nodes, or in the plane is not flat.

    ``corners`` are those of each cell of its mesh, ``numbers`` those of the elements of cells.
    """
    x, used = content.points, part.used
    if part.dim == 2:
        across = float(np.abs(x[used, 2]).max())
        flat = across <= _FLAT * float(np.ptp(x[used, :2], axis=0).max())
        require(flat, "file", across, "plane meshes in the plane z = 0")
    edges = _edges(points, corners)
    twice = (np.diff(np.sort(corners, axis=1), axis=1) == 0).any(axis=1)
    if (together := twice | ~(edges > 0)).any():
        worst = int(numbers[np.argmax(together)])
        raise InputError("file", f"element {worst}", "elements whose corners are apart")
    pairs = cKDTree(x[used]).query_pairs(_SAME * edges.min(), output_type="ndarray")
    told = f"{len(pairs)} pairs of nodes lie in one place"
    bodies = _bodies(corners, len(points))
    if bodies > 1:
        allowed = f"one body: these elements make {bodies} that share no nodes"
        sets = shown(content.element_sets)
        merge = f"; or give merge_nodes: {told}" if len(pairs) else ""
        raise InputError("part", name, f"{allowed}; choose one of the sets: {sets}{merge}")
    if len(pairs):
        both = content.node_numbers[used[pairs[0]]].tolist()
        allowed = "a distance within which nodes are merged, in the unit of the file"
        raise InputError("merge_nodes", None, f"{allowed}: {told}, as {both}")


def _edges(points: Floats, corners: Ints) -> Floats:
    """Least distance of the first corner of each element to the others, (n,)."""
    first = points[corners[:, 0]]
    lengths = [np.linalg.norm(points[other] - first, axis=1) for other in corners.T[1:]]
    return np.stack(lengths).min(axis=0)


def _bodies(corners: Ints, n_points: int) -> int:
    """Number of groups of cells that share no nodes."""
    n = len(corners)
    cells = np.repeat(np.arange(n), corners.shape[1])
    group = connected(np.column_stack([cells, n + corners.ravel()]), n + n_points)
    return len(np.unique(group[:n]))


def check_elements(cell: Cell, order: int, points: Floats, cells: Ints, numbers: Ints) -> None:
    """Refuse elements whose Jacobian is not positive; in the plane, not of the common sign."""
    slopes = _slopes(cell, order)
    least, most = np.empty(len(cells)), np.empty(len(cells))
    for rows in chunks(len(cells), 8 * slopes.size):
        x = points[cells[rows]]
        jacobians = np.linalg.det(np.einsum("qnj,cni->cqij", slopes, x, optimize=True))
        least[rows], most[rows] = jacobians.min(axis=1), jacobians.max(axis=1)
    if points.shape[1] == 2 and (most < 0).sum() > len(cells) / 2:  # mesh seen from behind
        least, most = -most, -least
    inverted = ~(least > _LEAST * most)
    if inverted.any():
        first = int(numbers[np.argmax(inverted)])
        allowed = "elements whose Jacobian is positive: these are inverted, flat, or list their "
        value = f"{inverted.sum()} of {len(cells)} elements, the first {first}"
        raise InputError("file", value, f"{allowed}nodes in another order than the format has")


def _slopes(cell: Cell, order: int) -> Floats:
    """Gradients of shape functions at points inside the reference cell, (points, nodes, dim)."""
    nodes = reference_nodes(cell, order)
    inside = np.vstack([nodes.mean(axis=0), nodes + (1 - _INWARD) * (nodes.mean(axis=0) - nodes)])
    powers = lattice(nodes.shape[1], order, cell in SIMPLICES)
    values = np.prod(nodes[:, None] ** powers, axis=2)
    slopes = []
    for axis in np.eye(nodes.shape[1], dtype=int):
        lowered = np.maximum(powers - axis, 0)
        slopes.append((powers @ axis) * np.prod(inside[:, None] ** lowered, axis=2))
    return np.einsum("dqp,pn->qnd", slopes, np.linalg.inv(values))


def _middles_apart(cell: Cell, cells: Ints, marks: NDArray[np.uint64]) -> int | None:
    """First cell with an edge whose middle node is not that of its neighbours, or not its own."""
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
    """First tetrahedron at a free quadrilateral that is cut along both diagonals."""
    sides = facet_nodes("tetrahedron", 1)
    triangles = np.concatenate([corners[:, side] for side in sides])
    owners = np.tile(np.arange(len(corners)), len(sides))
    sums = marks[triangles].sum(axis=1, dtype=np.uint64)
    _, same, times = np.unique(sums, return_inverse=True, return_counts=True)
    free = times[same] == 1
    triangles, owners, sums = triangles[free], owners[free], sums[free]
    edges = ([0, 1], [1, 2], [2, 0])
    ends = np.concatenate([marks[triangles[:, edge]].sum(axis=1) for edge in edges])
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
