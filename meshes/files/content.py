"""Content of a mesh file, the same for every format: nodes, elements, sets of both, faces.

Nodes of elements are in the order in which most programs list them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints
from cea.errors import require
from cea.mesh import Cell, Mesh, facet_nodes, node_order

Role = Literal["solid", "mark", "structural"]


CELLS = {
    **{"line": (1, 2), "triangle": (2, 3), "quadrilateral": (2, 4), "tetrahedron": (3, 4)},
    **{"pyramid": (3, 5), "wedge": (3, 6), "hexahedron": (3, 8)},
}
"""Dimension and number of corners of cells."""
DIVIDED = ("wedge", "pyramid")
"""Cells that a mesh has as tetrahedra alone (:mod:`meshes.files.tetrahedra`)."""


@dataclass(frozen=True, eq=False)
class ElementBlock:
    """Elements of one kind.

    Parameters
    ----------
    kind
        What the file calls them, e.g. C3D20R.
    cell
        Their cell, ``wedge``, ``pyramid`` or ``line``; another word for what makes no body.
    order
        Order of their geometry.
    numbers
        Their numbers in the file, (n,).
    nodes
        Rows of their nodes among the points, (n, n_nodes), corners first; up to order 2 as
        :data:`meshes.files.content.KINDS` lists them.
    reference
        Where these nodes lie in the reference cell, from 0 to 1, (n_nodes, dim).
    role
        ``solid``: what bodies are made of, and where solids of more dimensions are there, marks of
        their faces; ``mark``: of faces alone; ``structural``: shells, beams, springs and the like.
    """

    kind: str
    cell: str
    order: int
    numbers: Ints
    nodes: Ints
    reference: Floats = field(default_factory=lambda: np.empty((0, 0)))
    role: Role = "solid"

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def dim(self) -> int:
        """Dimension of its cells; 0 of what is none."""
        return CELLS.get(self.cell, (0, 0))[0]

    @property
    def corners(self) -> Ints:
        """Corners of each element, (n, n_corners)."""
        return self.nodes[:, : CELLS.get(self.cell, (0, 2))[1]]


def without_nodes(kind: str, numbers: Ints, role: Role) -> ElementBlock:
    """Elements that make no body, of which no nodes are read."""
    return ElementBlock(kind, "other", 1, numbers, np.empty((len(numbers), 0), int), role=role)


class Sets(Mapping[str, Ints]):
    """Sets by name, each worked out when it is asked for."""

    def __init__(self, items: Mapping[str, Any], make: Callable[[Any], Ints]) -> None:
        self._items, self._make = items, make

    def __getitem__(self, name: str) -> Ints:
        return self._make(self._items[name])

    def __contains__(self, name: object) -> bool:
        return name in self._items

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)


@dataclass(frozen=True, eq=False)
class FileContent:
    """What a mesh file holds.

    Parameters
    ----------
    points
        Positions of the nodes in the unit of the file, (n, 3).
    node_numbers
        Numbers of the nodes in the file, (n,).
    blocks
        The elements.
    element_sets
        Elements of each set, counted through the blocks.
    node_sets
        Nodes of each set, as rows of the points.
    face_sets
        Faces of each set: elements, and which of their faces, 0 for S1 as
        :data:`meshes.files.content.FACES` counts them, or -1 for all that are free, (n, 2).
    told
        What the file has that was left out.
    """

    points: Floats
    node_numbers: Ints
    blocks: Sequence[ElementBlock]
    element_sets: Mapping[str, Ints] = field(default_factory=dict)
    node_sets: Mapping[str, Ints] = field(default_factory=dict)
    face_sets: Mapping[str, Ints] = field(default_factory=dict)
    told: Sequence[str] = ()

    @property
    def starts(self) -> Ints:
        """Number of the first element of each block, and of all elements, (blocks + 1,)."""
        return np.concatenate([[0], np.cumsum([len(block) for block in self.blocks])]).astype(int)

    @property
    def dim(self) -> int:
        """Dimension of the elements that bodies are made of."""
        return max((b.dim for b in self.blocks if b.role == "solid" and len(b)), default=0)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all sets."""
        return tuple(dict.fromkeys([*self.face_sets, *self.element_sets, *self.node_sets]))

    def with_others(self, kinds: Sequence[str]) -> "FileContent":
        """The content with a structural element of each kind that was not read."""
        others = [without_nodes(kind, np.zeros(1, dtype=np.int64), "structural") for kind in kinds]
        return replace(self, blocks=[*self.blocks, *others])


def without_copies(content: FileContent) -> FileContent:
    """The content with elements that are there again, for another set, made one with the first."""
    marks = node_marks(len(content.points))
    cells = {cell: i for i, cell in enumerate(sorted({block.cell for block in content.blocks}))}
    keys = np.concatenate(
        [np.empty(0, dtype=np.uint64)]
        + [
            marks[b.nodes].sum(axis=1, dtype=np.uint64) + np.uint64(cells[b.cell])
            for b in content.blocks
        ]
    )
    _, first, same = np.unique(keys, return_index=True, return_inverse=True)
    if len(first) == len(keys):
        return content
    kept = np.zeros(len(keys), dtype=bool)
    kept[first] = True
    number = (np.cumsum(kept) - 1)[first][same]
    blocks = [
        replace(block, numbers=block.numbers[own], nodes=block.nodes[own])
        for block, own in zip(content.blocks, np.split(kept, content.starts[1:-1]), strict=True)
    ]
    sets = {name: np.unique(number[members]) for name, members in content.element_sets.items()}
    return replace(content, blocks=blocks, element_sets=sets)


def node_marks(n_points: int) -> NDArray[np.uint64]:
    """A random number for each node: sums tell apart facets without sorting their corners."""
    return np.random.default_rng(0).integers(2**63, size=n_points, dtype=np.uint64)


def rows_of(numbers: Ints, wanted: Ints, what: str) -> Ints:
    """Rows of wanted numbers among numbers in any order, of any shape."""
    order = np.argsort(numbers, kind="stable")
    rising = numbers[order]
    twice = np.flatnonzero(np.diff(rising) == 0)
    if len(twice):
        require(False, "file", int(rising[twice[0]]), f"numbers of {what} that are there once")
    place = np.minimum(np.searchsorted(rising, wanted), max(len(rising) - 1, 0))
    known = rising[place] == wanted if len(rising) else np.zeros(wanted.shape, dtype=bool)
    if not known.all():
        first = int(wanted[~known].flat[0])
        require(False, "file", first, f"a number of {what} that the file has: it is used")
    return order[place].astype(np.int64)


def known_rows(numbers: Ints, wanted: Ints) -> Ints:
    """Rows of those wanted numbers that are there, (n,); sets may name what a file left out."""
    if not len(numbers):
        return np.empty(0, dtype=np.int64)
    order = np.argsort(numbers, kind="stable")
    place = np.minimum(np.searchsorted(numbers[order], wanted), len(numbers) - 1)
    return order[place[numbers[order][place] == wanted]].astype(np.int64)


def shown(names: Iterable[str], limit: int = 20) -> str:
    """Names for a message, not more than fit."""
    known = list(names)
    more = f" and {len(known) - limit} more" if len(known) > limit else ""
    return ", ".join(known[:limit]) + more if known else "none"


def first_of_near(points: Floats, distance: float) -> Ints:
    """Number of the first of the points that a chain of steps below a distance joins to each."""
    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    size = len(points)
    links = coo_array((np.ones(len(pairs), dtype=bool), tuple(pairs.T)), shape=(size, size))
    _, group = connected_components(links, directed=False)
    return np.unique(group, return_index=True)[1][group].astype(np.int64)


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
