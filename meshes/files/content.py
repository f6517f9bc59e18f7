"""Content of a mesh file, the same for every format: nodes, elements, sets of both, faces."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints, connected
from cea.errors import InputError, require
from cea.mesh import Cell, Mesh, facet_nodes
from meshes.files.elements import CORNERS, FACES, KINDS, full_kind

Role = Literal["solid", "mark", "structural", "keyword"]
_FARTHEST = 1e50
"""Bound of coordinates, so that their squares and cubes do not overflow."""


@dataclass(frozen=True, eq=False)
class ElementBlock:
    """Elements of one kind.

    ``kind`` is their name in the file, e.g. C3D20R; ``cell`` a cell, ``wedge``, ``pyramid``,
    ``line`` or another word for elements that form no body; ``order`` that of the geometry;
    ``numbers`` those in the file, (n,); ``nodes`` rows of the points, (n, n_nodes), corners first,
    up to order 2 as in :data:`KINDS`; ``reference`` nodes of the reference cell, (n_nodes, dim).
    By ``role``, ``solid`` elements form bodies or mark faces of elements of higher dimension,
    ``mark`` ones only mark faces, ``structural`` ones are shells, beams, springs and the like, a
    ``keyword`` one stands for a keyword that changes the body but is not read.
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

    def only(self, rows: NDArray[Any]) -> "ElementBlock":
        """Some of the elements."""
        return replace(self, numbers=self.numbers[rows], nodes=self.nodes[rows])

    @property
    def dim(self) -> int:
        """Dimension of its cells; 0 if they are unknown."""
        return CORNERS[self.cell].shape[1] if self.cell in CORNERS else 0

    @property
    def corners(self) -> Ints:
        """Corners of each element, (n, n_corners)."""
        return self.nodes[:, : len(CORNERS.get(self.cell, "ab"))]

    @property
    def lacks_middles(self) -> bool:
        """Whether elements of second order have no nodes in the middle of faces or cells."""
        return self.order == 2 and len(self.reference) < len(full_kind(self.cell, 2).groups)


def block(
    name: str, kind: str, numbers: Ints, nodes: Ints, *, role: Role = "solid"
) -> ElementBlock:
    """Elements of a kind in :data:`KINDS` whose nodes, (n, n_nodes), are in its order."""
    cell, order, _, reference = KINDS[kind]
    return ElementBlock(name, cell, order, numbers, nodes, reference, role)


def without_nodes(kind: str, numbers: Ints, role: Role) -> ElementBlock:
    """Elements that form no body, without their nodes."""
    return ElementBlock(kind, "other", 1, numbers, np.empty((len(numbers), 0), int), role=role)


class Sets(Mapping[str, Ints]):
    """Sets by name, each resolved on access; names may ignore case."""

    def __init__(
        self, names: Iterable[str], find: Callable[[str], Ints], *, any_case: bool = False
    ) -> None:
        self._find, self.any_case, self._names = find, any_case, dict.fromkeys(names)
        self._keys = {self._key(name) for name in self._names}

    def _key(self, name: str) -> str:
        return name.upper() if self.any_case else name

    def __getitem__(self, name: str) -> Ints:
        return self._find(name)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._key(name) in self._keys

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


@dataclass(frozen=True, eq=False)
class FileContent:
    """Content of a mesh file.

    ``points`` are nodes in the unit of the file, (n, 3), ``node_numbers`` their numbers; sets have
    elements, counted through the blocks; nodes, as rows of the points; or faces, (n, 2): elements
    and the index of the face, 0 for S1 in :data:`meshes.files.elements.FACES`, -1 for all free
    ones.
    """

    points: Floats
    node_numbers: Ints
    blocks: Sequence[ElementBlock]
    element_sets: Mapping[str, Ints] = field(default_factory=dict)
    node_sets: Mapping[str, Ints] = field(default_factory=dict)
    face_sets: Mapping[str, Ints] = field(default_factory=dict)

    def __post_init__(self) -> None:
        fits = bool((np.abs(self.points) < _FARTHEST).all())
        require(fits, "file", "nodes", f"finite coordinates, below {_FARTHEST:g}")

    @property
    def starts(self) -> Ints:
        """First element of each block, and number of all elements, (blocks + 1,)."""
        return np.concatenate([[0], np.cumsum([len(block) for block in self.blocks])]).astype(int)

    @property
    def dim(self) -> int:
        """Dimension of the elements that bodies are made of."""
        return max((b.dim for b in self.blocks if b.role == "solid" and len(b)), default=0)

    def sets(self, kind: str) -> Mapping[str, Ints]:
        """Sets of ``faces``, ``elements`` or ``nodes``."""
        return {"faces": self.face_sets, "elements": self.element_sets}.get(kind, self.node_sets)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all sets."""
        return tuple(dict.fromkeys([*self.face_sets, *self.element_sets, *self.node_sets]))

    def by_block(self, elements: Ints) -> Iterator[tuple[ElementBlock, Ints]]:
        """Yield each block with its elements among given ones, as rows of the block."""
        for block, start in zip(self.blocks, self.starts, strict=False):
            yield block, elements[(elements >= start) & (elements < start + len(block))] - start

    def sided(self, elements: Ints, label: str) -> Ints:
        """Elements and their face that a label S1, S2, ... names, -1 without one, (n, 2)."""
        side = int(label[1:]) - 1 if re.fullmatch("S[1-9]", label) else -1
        for block, rows in self.by_block(elements):
            count = len(FACES.get(block.cell, ()))
            fits = not label or 0 <= side < count or not len(rows)
            require(fits, "file", label, f"faces S1 to S{count} of {block.kind}")
        return np.stack([elements, np.full(len(elements), side)], axis=1)


def without_copies(content: FileContent) -> FileContent:
    """The content without repeated elements, which files list once more for another set."""
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
        block.only(own)
        for block, own in zip(content.blocks, np.split(kept, content.starts[1:-1]), strict=True)
    ]
    sets = {name: np.unique(number[members]) for name, members in content.element_sets.items()}
    return replace(content, blocks=blocks, element_sets=sets)


def node_marks(n_points: int) -> NDArray[np.uint64]:
    """A random number for each node: sums identify facets without sorting their corners."""
    return np.random.default_rng(0).integers(2**63, size=n_points, dtype=np.uint64)


def rows_of(numbers: Ints, wanted: Ints, what: str) -> Ints:
    """Rows of wanted numbers, of any shape; refuse unknown numbers and repeated ones."""
    rows = _rows(numbers, wanted)
    rising = np.sort(numbers)
    for wrong, allowed in (
        (rising[1:][np.diff(rising) == 0], f"a number of {what} that occurs once"),
        (wanted[rows < 0], f"a number of {what} that the file has: it is used, but not defined"),
    ):
        if wrong.size:
            raise InputError("file", int(wrong[0]), allowed)
    return rows


def known_rows(numbers: Ints, wanted: Ints) -> Ints:
    """Rows of the wanted numbers that exist, (n,); sets may name others."""
    rows = _rows(numbers, wanted)
    return rows[rows >= 0]


def _rows(numbers: Ints, wanted: Ints) -> Ints:
    """Rows of wanted numbers, -1 for unknown ones."""
    if not len(numbers):
        return np.full(wanted.shape, -1, dtype=np.int64)
    order = np.argsort(numbers, kind="stable")
    place = np.minimum(np.searchsorted(numbers, wanted, sorter=order), len(numbers) - 1)
    return np.where(numbers[order[place]] == wanted, order[place], -1).astype(np.int64)


def shown(names: Iterable[str], limit: int = 20) -> str:
    """Names for a message, at most ``limit``."""
    known = list(names)
    more = f" and {len(known) - limit} more" if len(known) > limit else ""
    return ", ".join(known[:limit]) + more if known else "none"


def first_of_near(points: Floats, distance: float) -> Ints:
    """For each point, the first point that a chain of steps below a distance joins to it."""
    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    group = connected(pairs, len(points))
    return np.unique(group, return_index=True)[1][group].astype(np.int64)


def named_sides(mesh: Mesh) -> dict[str, NDArray[np.bool_]]:
    """Whether each facet of each cell belongs to each named surface, (n_cells, n_facets)."""
    marks = node_marks(len(mesh.points))
    of_cell = [mesh.cells[:, local] for local in facet_nodes(mesh.cell, mesh.order)]
    sums = np.stack([marks[nodes].sum(axis=1) for nodes in of_cell], axis=1)
    return {
        name: np.isin(sums, marks[facets].sum(axis=1)) for name, facets in mesh.surfaces.items()
    }


def facets_on(cell: Cell, order: int, cells: Ints, on: NDArray[np.bool_]) -> Ints:
    """Facets of cells where ``on``, (n_cells, n_facets), is true."""
    facets = enumerate(facet_nodes(cell, order))
    return np.concatenate([cells[on[:, i]][:, local] for i, local in facets])
