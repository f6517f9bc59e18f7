"""The elements of a mesh file that make a body."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cea.errors import InputError, require
from cea.mesh import DIMENSION, Cell
from meshes.files.content import FileContent, Floats, Ints, corner_places, shown

_SAME = 1e-6
"""Distance below which nodes are one, relative to the shortest edge."""
_FLAT = 1e-9
"""Size of a plane mesh across its plane, relative to its extent."""


@dataclass(frozen=True, eq=False)
class Part:
    """Elements of one kind that make a body.

    Parameters
    ----------
    cell, order
        Their kind.
    elements
        Which they are, counted through the blocks of the file, rising, (n,).
    numbers
        Their numbers in the file, (n,).
    nodes
        Their nodes in the order of :class:`cea.mesh.Mesh`, -1 where they have none,
        (n, n_nodes).
    """

    cell: Cell
    order: int
    elements: Ints
    numbers: Ints
    nodes: Ints

    @property
    def dim(self) -> int:
        """Dimension of its cells."""
        return DIMENSION[self.cell]

    @property
    def corners(self) -> Ints:
        """Corners of its cells, (n, n_corners)."""
        return self.nodes[:, corner_places(self.cell, self.order)]

    @property
    def incomplete(self) -> bool:
        """Whether its elements have not all nodes of Lagrange cells, as 20-node hexahedra."""
        return bool((self.nodes < 0).any())


_SOLIDS = "triangles, quadrilaterals, tetrahedra or hexahedra"
"""Elements that bodies are made of."""


def part_of(content: FileContent, file: str, name: str | None, marks: Iterable[str] = ()) -> Part:
    """Elements of a set, or all solid ones of a file, checked to be of one kind.

    Parameters
    ----------
    content
        The file.
    file
        Its name, for messages.
    name
        The set; None for all.
    marks
        Sets of elements that the body takes as marks of its faces.

    Raises
    ------
    InputError
        When there is no such set, it has no solid elements, wedges or pyramids, or solid elements
        of several kinds, or has shells, beams and the like, whose stiffness would be lost.
    """
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
    of_block = [chosen[a:b] for a, b in pairwise(starts)]
    free = [(chosen & ~taken)[a:b] for a, b in pairwise(starts)]
    blocks = list(zip(content.blocks, of_block, free, starts, strict=False))

    others = {b.kind for b, _, left, _ in blocks if b.role == "structural" and left.any()}
    if others:
        allowed = f"a set of solid elements alone, here are {shown(sorted(others))} too"
        raise InputError("part", name, f"{allowed}; sets: {shown(content.element_sets)}")
    solid = [
        (b, own, start)
        for b, own, _, start in blocks
        if b.role == "solid" and own.any() and b.dim in (0, dim)
    ]
    cells = {(b.cell, b.order) for b, _, _ in solid}
    kinds = shown(sorted({b.kind for b, _, _ in solid}))
    strange = shown(sorted({b.kind for b, _, _ in solid if b.dim == 0}))
    if strange != "none" and not any(b.dim == 3 for b, _, _ in solid):
        where = f" in the part {name}" if name else ""
        allowed = f"solid elements that are {_SOLIDS}"
        raise InputError("file", f"{file}: {strange}{where}", allowed)
    if len(cells) != 1 or dim < 2 or any(b.dim == 0 for b, _, _ in solid):
        allowed = f"solid elements of one kind, {_SOLIDS}; in {file} are: {kinds}"
        sets = shown(content.element_sets)
        raise InputError("part", name, f"{allowed}; sets of elements: {sets}")
    ((cell, order),) = cells
    return Part(
        cell,  # type: ignore[arg-type]  # one of a dimension
        order,
        np.concatenate([start + np.flatnonzero(own) for _, own, start in solid]),
        np.concatenate([b.numbers[own] for b, own, _ in solid]),
        np.concatenate([b.nodes[own] for b, own, _ in solid]),
    )


def merged(content: FileContent, distance: float) -> FileContent:
    """The content with nodes nearer than a distance (unit of the file) made one.

    Raises
    ------
    InputError
        When the distance is not small beside the edges of elements.
    """
    cells = [block.corners for block in content.blocks if block.dim > 1 and len(block)]
    shortest = min((float(_edges(content.points, c).min()) for c in cells), default=np.inf)
    allowed = f"less than half the shortest edge of an element, {shortest:g}"
    require(distance < shortest / 2, "merge_nodes", distance, allowed)
    pairs = cKDTree(content.points).query_pairs(distance, output_type="ndarray")
    n = len(content.points)
    links = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(n, n))
    _, group = connected_components(links, directed=False)
    first = np.full(group.max() + 1, n, dtype=np.int64)
    np.minimum.at(first, group, np.arange(n))
    number = np.append(first[group], -1)  # the last one stands for nodes that are not there
    blocks = [replace(block, nodes=number[block.nodes]) for block in content.blocks]
    sets = {name: np.unique(number[rows]) for name, rows in content.node_sets.items()}
    return replace(content, blocks=blocks, node_sets=sets)


def check_nodes(content: FileContent, part: Part, name: str | None) -> None:
    """Refuse parts that fall apart, nodes in one place, and plane meshes out of their plane.

    Raises
    ------
    InputError
        Naming part, or merge_nodes.
    """
    used = np.unique(part.nodes[part.nodes >= 0])
    x, corners = content.points, part.corners
    edges = _edges(x, corners)
    twice = (np.diff(np.sort(corners, axis=1), axis=1) == 0).any(axis=1)
    if twice.any() or not edges.min() > 0:
        worst = int(part.numbers[np.argmax(twice) if twice.any() else np.argmin(edges)])
        raise InputError("file", f"element {worst}", "elements whose corners are apart")
    pairs = cKDTree(x[used]).query_pairs(_SAME * edges.min(), output_type="ndarray")
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
    n, per_cell = part.corners.shape
    rows = np.repeat(np.arange(n), per_cell)
    columns = n + part.corners.ravel()
    size = n + n_points
    graph = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(size, size))
    _, group = connected_components(graph, directed=False)
    return len(np.unique(group[:n]))
