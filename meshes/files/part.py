"""The elements of a mesh file that make a body."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from cea.mesh import Cell
from meshes.files.content import ElementBlock, FileContent, Sets, first_of_near, shown
from meshes.files.elements import DIVIDED, FACES, side_nodes

_SAME = 1e-6
"""Distance below which nodes are one, relative to the shortest edge."""
_FLAT = 1e-9
"""Size of a plane mesh across its plane, relative to its extent."""


@dataclass(frozen=True, eq=False)
class Part:
    """Elements that make a body."""

    blocks: tuple[ElementBlock, ...]
    elements: Ints

    @property
    def is_divided(self) -> bool:
        """Whether its mesh has its elements divided into tetrahedra."""
        cells = {block.cell for block in self.blocks}
        return len(cells) > 1 or not cells.isdisjoint(DIVIDED)

    @property
    def num_cells(self) -> int:
        """Number of cells of its mesh; of elements that are divided, about that of tetrahedra."""
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
        """Nodes that it has in the file, as rows of the points, rising."""
        return np.unique(np.concatenate([block.nodes.ravel() for block in self.blocks]))

    def faces(self) -> Iterator[tuple[slice, int, Ints, Ints]]:
        """Faces of one number of all elements of a kind: rows of these, number, corners, nodes."""
        start = 0
        for block in self.blocks:
            rows = slice(start, start := start + len(block))
            sides = zip(FACES[block.cell], side_nodes(block.cell, block.reference), strict=True)
            for i, (face, side) in enumerate(sides):
                yield rows, i, block.corners[:, face], block.nodes[:, side]

    @property
    def incomplete(self) -> bool:
        """Whether its elements have not all nodes of Lagrange cells, as 20-node hexahedra."""
        return any(block.lacks_middles for block in self.blocks)


_SOLIDS = "triangles, quadrilaterals, tetrahedra, pyramids, wedges or hexahedra"
"""Elements that bodies are made of."""


def part_of(content: FileContent, file: str, name: str | None, marks: Iterable[str] = ()) -> Part:
    """Elements of a set, or all solid ones of a file, checked to be those of a body."""
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
        if block.role == "structural" and not taken[own].all():
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
    """The content with nodes nearer than a distance (unit of the file) made one."""
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


def check_nodes(content: FileContent, part: Part, name: str | None) -> None:
    """Refuse parts that fall apart, nodes in one place, and plane meshes out of their plane."""
    used, x, shortest = part.used, content.points, np.inf
    for block in part.blocks:
        corners = block.corners
        edges = _edges(x, corners)
        twice = (np.diff(np.sort(corners, axis=1), axis=1) == 0).any(axis=1)
        if twice.any() or not edges.min() > 0:
            worst = int(block.numbers[np.argmax(twice) if twice.any() else np.argmin(edges)])
            raise InputError("file", f"element {worst}", "elements whose corners are apart")
        shortest = min(shortest, float(edges.min()))
    pairs = cKDTree(x[used]).query_pairs(_SAME * shortest, output_type="ndarray")
    told = f"{len(pairs)} pairs of nodes lie in one place"
    bodies = _bodies(part, len(x))
    if bodies > 1:
        allowed = f"one body: these elements make {bodies} that share no nodes"
        sets = shown(content.element_sets)
        merge = f"; or give merge_nodes: {told}" if len(pairs) else ""
        raise InputError("part", name, f"{allowed}; choose one of the sets: {sets}{merge}")
    if len(pairs):
        both = content.node_numbers[used[pairs[0]]].tolist()
        allowed = "a distance within which nodes are made one, in the unit of the file"
        raise InputError("merge_nodes", None, f"{allowed}: {told}, as {both}")
    if part.dim == 2:
        across = float(np.abs(x[used, 2]).max())
        flat = across <= _FLAT * float(np.ptp(x[used, :2], axis=0).max())
        require(flat, "file", across, "plane meshes in the plane z = 0")


def _edges(points: Floats, corners: Ints) -> Floats:
    """Least distance of the first corner of each element to the others, (n,)."""
    first = points[corners[:, 0]]
    lengths = [np.linalg.norm(points[other] - first, axis=1) for other in corners.T[1:]]
    return np.stack(lengths).min(axis=0)


def _bodies(part: Part, n_points: int) -> int:
    """Number of groups of cells that share no nodes."""
    n = len(part.elements)
    counts = np.concatenate([np.full(len(b), b.corners.shape[1]) for b in part.blocks])
    rows = np.repeat(np.arange(n), counts)
    columns = n + np.concatenate([block.corners.ravel() for block in part.blocks])
    size = n + n_points
    graph = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(size, size))
    _, group = connected_components(graph, directed=False)
    return len(np.unique(group[:n]))
