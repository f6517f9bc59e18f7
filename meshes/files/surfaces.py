"""Named faces of a body from sets of a mesh file: of faces, of elements, of nodes."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Ints
from cea.errors import InputError
from meshes.files.content import FileContent, node_marks, shown
from meshes.files.elements import FACES, side_nodes
from meshes.files.part import Part

Bools = NDArray[np.bool_]
_KINDS = ("faces", "elements", "nodes")
_SET = re.compile(r"(?:(faces|elements|nodes):)?(.+?)(?::[SP]?([1-6]))?", re.DOTALL)
"""A set as ``kind:name:Sk``: of a kind where several have the name, k-th faces of elements."""


@dataclass(frozen=True, eq=False)
class Facets:
    """Faces of the elements of a body, matched by their corners; those of two are inner ones."""

    keys: NDArray[np.uint64]
    group: Ints
    free: Bools
    marks: NDArray[np.uint64]

    def find(self, corners: Ints) -> Bools:
        """Which faces of elements are given by their corners in any order."""
        wanted = np.isin(self.keys, self.marks[corners].sum(axis=1, dtype=np.uint64))
        return (self.group >= 0) & wanted[self.group]


@lru_cache(4)
def facets_of(part: Part, n_points: int) -> Facets:
    """Faces of the elements of a body, as :data:`meshes.files.elements.FACES` counts them."""
    marks = node_marks(n_points)
    most = max(len(FACES[block.cell]) for block in part.blocks)
    sums = np.zeros((len(part.elements), most), dtype=np.uint64)
    there = np.zeros(sums.shape, dtype=bool)
    start = 0
    for block in part.blocks:
        corners = block.corners
        for i, face in enumerate(FACES[block.cell]):
            rows = slice(start, start + len(block))
            sums[rows, i] = marks[corners[:, face]].sum(axis=1, dtype=np.uint64)
            there[rows, i] = True
        start += len(block)
    keys, place, times = np.unique(sums[there], return_inverse=True, return_counts=True)
    group, free = np.full(sums.shape, -1, dtype=np.int64), np.zeros(sums.shape, dtype=bool)
    group[there], free[there] = place, times[place] == 1
    return Facets(keys, group, free, marks)


def surface_faces(
    content: FileContent, part: Part, faces: Mapping[str, Sequence[str]]
) -> dict[str, tuple[Bools, int]]:
    """Faces of elements that named surfaces have, and how many nodes of sets are left out."""
    facets = facets_of(part, len(content.points)) if faces else None
    found = {}
    for surface, sets in faces.items():
        assert facets is not None
        on, nodes = np.zeros(facets.group.shape, dtype=bool), [np.empty(0, dtype=np.int64)]
        for text in sets:
            of_set, of_nodes = _of_set(content, part, facets, f"faces.{surface}", text)
            on |= of_set
            nodes.append(of_nodes)
        wanted = np.intersect1d(np.concatenate(nodes), part.used)
        found[surface] = on, len(np.setdiff1d(wanted, _nodes_on(part, on)))
    return found


def _nodes_on(part: Part, on: Bools) -> Ints:
    """Nodes on faces of elements."""
    nodes, start = [np.empty(0, dtype=np.int64)], 0
    for block in part.blocks:
        for i, side in enumerate(side_nodes(block.cell, block.reference)):
            nodes.append(block.nodes[on[start : start + len(block), i]][:, side].ravel())
        start += len(block)
    return np.unique(np.concatenate(nodes))


def check_sets(content: FileContent, faces: Mapping[str, Sequence[str]]) -> None:
    """Refuse surfaces of sets that the file does not have."""
    kinds = {"faces": content.face_sets, "elements": content.element_sets}
    kinds["nodes"] = content.node_sets
    for surface, sets in faces.items():
        for text in sets:
            known = any(
                name in content.names if kind is None else name in kinds[kind]
                for kind, name, _ in _meanings(text)
            )
            if not known:
                allowed = f"one of the sets of the file: {shown(content.names)}"
                raise InputError("faces", {surface: text}, allowed)


def marks_of(content: FileContent, faces: Mapping[str, Sequence[str]]) -> list[str]:
    """Sets of elements among those of surfaces."""
    names = [name for sets in faces.values() for one in sets for _, name, _ in _meanings(one)]
    return [name for name in names if name in content.element_sets]


def _of_set(
    content: FileContent, part: Part, facets: Facets, field: str, text: str
) -> tuple[Bools, Ints]:
    """Faces of a set, and its nodes where it is one of nodes."""
    known = f"sets of the file: {shown(content.names)}"
    found: dict[str, Bools] = {}
    for kind, name, face in _meanings(text):
        for each in _KINDS if kind is None else (kind,):
            if (on := _on(content, part, facets, each, name, face)) is not None:
                found[each] = on
        if found:
            break
    else:
        raise InputError(field, text, f"one of the {known}")
    if "faces" in found:  # a surface is what was asked for
        found = {"faces": found["faces"]}
    inner = any((on & ~facets.free).any() for on in found.values())
    free = {kind: on & facets.free for kind, on in found.items() if (on & facets.free).any()}
    if inner or not free:
        where = "between two elements" if inner else "nowhere on the boundary of this body"
        raise InputError(field, text, f"a set of faces of the boundary: it lies {where}; {known}")
    first = next(iter(free.values()))
    if any((on != first).any() for on in free.values()):
        kinds = " or ".join(f"{kind}:{name}" for kind in free)
        raise InputError(field, text, f"{kinds}: sets of this name have different faces")
    rows = content.node_sets[name] if list(found) == ["nodes"] else np.empty(0, dtype=np.int64)
    return first, rows


def _meanings(text: str) -> Iterator[tuple[str | None, str, int | None]]:
    """Kind, name and face that a set may mean: first all of it as a name."""
    yield None, text, None
    if (match := _SET.fullmatch(text)) is not None:
        kind, name, face = match.groups()
        yield kind, name, None if face is None else int(face)


def _on(
    content: FileContent, part: Part, facets: Facets, kind: str, name: str, face: int | None
) -> Bools | None:
    """Facets of a set of one kind; None where there is no such set."""
    if kind == "elements" and name in content.element_sets:
        return _of_elements(content, part, facets, content.element_sets[name], face)
    if face is not None:
        return None
    if kind == "faces" and name in content.face_sets:
        return _of_faces(part, facets, content.face_sets[name])
    if kind == "nodes" and name in content.node_sets:
        return _of_nodes(part, facets, content.node_sets[name], len(content.points))
    return None


def _of_elements(
    content: FileContent, part: Part, facets: Facets, elements: Ints, face: int | None
) -> Bools:
    """Faces that elements mark; of solid elements all free ones, or their faces of one number."""
    if face is not None:
        return _of_faces(part, facets, np.stack([elements, np.full(len(elements), face - 1)], 1))
    marked = np.zeros(facets.group.shape, dtype=bool)
    for block, start in zip(content.blocks, content.starts, strict=False):
        rows = elements[(elements >= start) & (elements < start + len(block))] - start
        if block.dim == part.dim - 1 and len(rows):
            marked |= facets.find(block.corners[rows])
    return marked if marked.any() else facets.free & np.isin(part.elements, elements)[:, None]


def _of_faces(part: Part, facets: Facets, pairs: Ints) -> Bools:
    """Faces given as elements and numbers of faces, -1 for all that are free."""
    most = facets.group.shape[1]
    every = np.isin(part.elements, pairs[pairs[:, 1] < 0, 0])
    single = pairs[(pairs[:, 1] >= 0) & (pairs[:, 1] < most)]
    codes = part.elements[:, None] * most + np.arange(most)
    on = np.isin(codes, single[:, 0] * most + single[:, 1]) & (facets.group >= 0)
    return on | (facets.free & every[:, None])


def _of_nodes(part: Part, facets: Facets, rows: Ints, n_points: int) -> Bools:
    """Free faces all of whose nodes belong to a set."""
    inside = np.zeros(n_points, dtype=bool)
    inside[rows] = True
    on, start = np.zeros(facets.group.shape, dtype=bool), 0
    for block in part.blocks:
        for i, side in enumerate(side_nodes(block.cell, block.reference)):
            on[start : start + len(block), i] = inside[block.nodes[:, side]].all(axis=1)
        start += len(block)
    return facets.free & on
