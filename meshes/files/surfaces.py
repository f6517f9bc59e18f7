"""Named faces of a body from sets of a mesh file: of faces, of elements, of nodes."""

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Ints
from cea.errors import InputError, require
from meshes.files.content import FileContent, node_marks, shown
from meshes.files.part import Part

Bools = NDArray[np.bool_]
_KINDS = ("faces", "elements", "nodes")
"""Kinds of sets; ``kind:name`` is the set of a kind where several have the name."""


class Faces:
    """Faces of the elements of a body, numbered as in :data:`meshes.files.elements.FACES`.

    They are matched by their corners: ``free`` marks those of one element, (n_elements, n_faces).
    """

    def __init__(self, content: FileContent, part: Part) -> None:
        self.content, self.part = content, part
        self._marks = node_marks(len(content.points))
        most = max(i for _, i, _, _ in part.faces()) + 1
        sums = np.zeros((len(part.elements), most), dtype=np.uint64)
        self._there = np.zeros(sums.shape, dtype=bool)
        for rows, i, corners, _ in part.faces():
            sums[rows, i] = self._marks[corners].sum(axis=1, dtype=np.uint64)
            self._there[rows, i] = True
        _, same, times = np.unique(sums, return_inverse=True, return_counts=True)
        self.free = self._there & (times[same].reshape(sums.shape) == 1)
        self._sums = sums

    def of_set(self, text: str, field: str) -> tuple[Bools, Ints]:
        """Faces of a set, and its nodes if it is a set of nodes."""
        kinds, name = _meaning(self.content, text, field, text)
        kinds = ["faces"] if "faces" in kinds else kinds  # sets of faces take precedence
        found = {each: self._on(each, name) for each in kinds}
        inner = any((on & ~self.free).any() for on in found.values())
        free = {kind: on & self.free for kind, on in found.items() if (on & self.free).any()}
        if inner or not free:
            where = "between two elements" if inner else "nowhere on the boundary of this body"
            known = f"sets of the file: {shown(self.content.names)}"
            allowed = f"a set of faces of the boundary: it lies {where}; {known}"
            raise InputError(field, text, allowed)
        first = next(iter(free.values()))
        if any((on != first).any() for on in free.values()):
            several = " or ".join(f"{kind}:{name}" for kind in free)
            raise InputError(field, text, f"{several}: sets of this name have different faces")
        of_nodes = list(found) == ["nodes"]
        return first, self.content.node_sets[name] if of_nodes else np.empty(0, dtype=np.int64)

    def nodes_on(self, on: Bools) -> Ints:
        """Nodes on faces of elements."""
        nodes = [nodes[on[rows, i]].ravel() for rows, i, _, nodes in self.part.faces()]
        return np.unique(np.concatenate(nodes))

    def _on(self, kind: str, name: str) -> Bools:
        """Faces of a set of one kind."""
        if kind == "elements":
            return self._of_elements(self.content.element_sets[name])
        if kind == "faces":
            return self._of_faces(self.content.face_sets[name])
        if kind == "sides":
            elements, _, label = name.rpartition(":")
            return self._of_faces(self.content.sided(self.content.element_sets[elements], label))
        inside = np.zeros(len(self.content.points), dtype=bool)
        inside[self.content.node_sets[name]] = True
        on = np.zeros(self.free.shape, dtype=bool)
        for rows, i, _, nodes in self.part.faces():
            on[rows, i] = inside[nodes].all(axis=1)
        return self.free & on

    def _of_elements(self, elements: Ints) -> Bools:
        """Faces that elements mark, or else all free faces of the elements."""
        marked = np.zeros(self.free.shape, dtype=bool)
        for block, rows in self.content.by_block(elements):
            if block.dim == self.part.dim - 1 and len(rows):
                wanted = self._marks[block.corners[rows]].sum(axis=1, dtype=np.uint64)
                marked |= self._there & np.isin(self._sums, wanted)
        if marked.any():
            return marked
        return self.free & np.isin(self.part.elements, elements)[:, None]

    def _of_faces(self, pairs: Ints) -> Bools:
        """Faces given as elements and numbers of faces, -1 for all free ones."""
        most, elements = self.free.shape[1], self.part.elements
        every = np.isin(elements, pairs[pairs[:, 1] < 0, 0])
        single = pairs[(pairs[:, 1] >= 0) & (pairs[:, 1] < most)]
        codes = elements[:, None] * most + np.arange(most)
        on = np.isin(codes, single[:, 0] * most + single[:, 1]) & self._there
        return on | (self.free & every[:, None])


faces_of = lru_cache(4)(Faces)
"""Faces of a part, cached for the bodies of a scene."""


def surface_faces(
    content: FileContent, part: Part, sets_of: Mapping[str, Sequence[str]]
) -> dict[str, tuple[Bools, int]]:
    """Faces of elements on each surface, and the number of nodes of its sets on none.

    Surfaces with common faces are refused.
    """
    found = {}
    for surface, sets in sets_of.items():
        faces = faces_of(content, part)
        on, nodes = zip(*(faces.of_set(text, f"faces.{surface}") for text in sets), strict=True)
        every = np.logical_or.reduce(on)
        wanted = np.intersect1d(np.concatenate(nodes), part.used)
        found[surface] = every, len(np.setdiff1d(wanted, faces.nodes_on(every)))
    for one, other in combinations(found, 2):
        common = found[one][0] & found[other][0]
        if common.any():
            both = {name: list(sets_of[name]) for name in (one, other)}
            first = int(part.numbers[np.argmax(common.any(axis=1))])
            told = f"{common.sum()} faces are on both, the first of element {first}"
            raise InputError("file", both, f"sets of surfaces without common faces: {told}")
    return found


def marking_sets(content: FileContent, faces: Mapping[str, Sequence[str]]) -> list[str]:
    """Sets of elements among the sets of surfaces; refuse unknown sets."""
    names = [
        _meaning(content, text, "faces", {surface: text})[1]
        for surface, sets in faces.items()
        for text in sets
    ]
    return [name for name in names if name in content.element_sets]


def _meaning(
    content: FileContent, text: str, field: str, value: object
) -> tuple[Sequence[str], str]:
    """Kinds and name of the sets that a text names; the whole text is tried first as a name.

    ``SET:S3`` are the third faces, as Abaqus counts them, of the elements of a set.
    """
    kind, _, rest = text.partition(":")
    for kinds, name in ((_KINDS, text), ((kind,) if kind in _KINDS else (), rest)):
        there = [each for each in kinds if name in content.sets(each)]
        if there:
            return there, name
    elements, _, label = text.rpartition(":")
    is_side = elements in content.element_sets and re.fullmatch("S[1-6]", label)
    known = f"one of the sets of the file: {shown(content.names)}"
    require(bool(is_side), field, value, known)
    return ["sides"], text
