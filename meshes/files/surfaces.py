"""Named faces of a body from sets of a mesh file: of faces, of elements, of nodes."""

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cea.errors import InputError
from cea.mesh import facet_nodes
from meshes.files.content import FileContent, Ints, shown
from meshes.files.facets import Facets, facet_numbers, facets_of
from meshes.files.part import Part

Bools = NDArray[np.bool_]
_KINDS = ("faces", "elements", "nodes")
_SET = re.compile(r"(?:(faces|elements|nodes):)?(.+?)(?::[SP]?([1-6]))?", re.DOTALL)
"""A set as ``kind:name:Sk``: of a kind where several have the name, k-th faces of elements."""


def surface_facets(
    content: FileContent, part: Part, cells: Ints, faces: Mapping[str, Sequence[str]]
) -> dict[str, Ints]:
    """Facets of named surfaces by their nodes, (n, n_facet_nodes) each.

    Parameters
    ----------
    content
        The file.
    part
        The elements of the body.
    cells
        Their nodes, complete, (n_cells, n_nodes).
    faces
        Sets of each surface: one after the other ``NAME``, ``nodes:NAME``, ``elements:NAME``,
        ``faces:NAME`` or, of elements and their k-th faces as Abaqus counts them, ``NAME:Sk``.

    Raises
    ------
    InputError
        When there is no such set, it has no facet of the boundary or some between two elements, or
        its name stands for sets of different faces.
    """
    facets = facets_of(part.cell, part.corners, len(content.points))
    found = {name: _facets(content, part, facets, name, sets) for name, sets in faces.items()}
    sides = facet_nodes(part.cell, part.order)
    return {
        name: np.concatenate([cells[on[:, i]][:, side] for i, side in enumerate(sides)])
        for name, on in found.items()
    }


def check_sets(content: FileContent, faces: Mapping[str, Sequence[str]]) -> None:
    """Refuse surfaces of sets that the file does not have.

    Raises
    ------
    InputError
        Naming faces.
    """
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


def _facets(
    content: FileContent, part: Part, facets: Facets, name: str, sets: Sequence[str]
) -> Bools:
    """Which facets of which cells belong to a surface."""
    on = np.zeros(facets.group.shape, dtype=bool)
    for one in sets:
        on |= _facets_of_set(content, part, facets, f"faces.{name}", one)
    return on


def _facets_of_set(
    content: FileContent, part: Part, facets: Facets, field: str, text: str
) -> Bools:
    """The same of one set."""
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
    inner = any((on & ~facets.free).any() for on in found.values())
    free = {kind: on & facets.free for kind, on in found.items() if (on & facets.free).any()}
    if inner or not free:
        where = "between two elements" if inner else "nowhere on the boundary of this body"
        raise InputError(field, text, f"a set of faces of the boundary: it lies {where}; {known}")
    first = next(iter(free.values()))
    if any((on != first).any() for on in free.values()):
        kinds = " or ".join(f"{kind}:{name}" for kind in free)
        raise InputError(field, text, f"{kinds}: sets of this name have different faces")
    return first


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
    """Facets that elements mark; of solid elements all free ones, or their faces of one number."""
    own = np.isin(part.elements, elements)
    if face is not None:
        numbers = facet_numbers(part.cell)
        if face > len(numbers):
            return np.zeros(facets.group.shape, dtype=bool)
        pairs = np.stack([part.elements[own], np.full(own.sum(), numbers[face - 1])], axis=1)
        return _of_faces(part, facets, pairs)
    marked = np.zeros(facets.group.shape, dtype=bool)
    for block, start in zip(content.blocks, content.starts, strict=False):
        rows = elements[(elements >= start) & (elements < start + len(block))] - start
        if block.dim == part.dim - 1 and len(rows):
            group = facets.find(block.corners[rows])
            marked |= np.isin(facets.group, group[group >= 0])
    return marked if marked.any() else facets.free & own[:, None]


def _of_faces(part: Part, facets: Facets, pairs: Ints) -> Bools:
    """Facets given as elements and numbers of facets, -1 for all that are free."""
    on = np.zeros(facets.group.shape, dtype=bool)
    pairs = pairs[np.isin(pairs[:, 0], part.elements)]
    rows = np.searchsorted(part.elements, pairs[:, 0])
    every = pairs[:, 1] < 0
    on[rows[every]] = facets.free[rows[every]]
    on[rows[~every], pairs[~every, 1]] = True
    return on


def _of_nodes(part: Part, facets: Facets, rows: Ints, n_points: int) -> Bools:
    """Free facets all of whose nodes belong to a set."""
    inside = np.zeros(n_points + 1, dtype=bool)
    inside[rows] = True
    inside[-1] = True  # nodes that elements do not have
    sides = facet_nodes(part.cell, part.order)
    on = [inside[part.nodes[:, side]].all(axis=1) for side in sides]
    return facets.free & np.stack(on, axis=1)
