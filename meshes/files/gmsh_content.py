"""Content of files of gmsh."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from cea.errors import require
from meshes.files.apart import arrays_of
from meshes.files.content import (
    DIVIDED,
    ElementBlock,
    FileContent,
    Ints,
    rows_of,
    without_copies,
)
from meshes.files.kinds import in_order

_CELLS = {
    "Triangle": "triangle",
    "Quadrilateral": "quadrilateral",
    "Tetrahedron": "tetrahedron",
    "Pyramid": "pyramid",
    "Prism": "wedge",
    "Hexahedron": "hexahedron",
}
"""Cells by the first word of gmsh's names."""
_WORDS = {1: "curve", 2: "surface", 3: "volume"}
"""What groups without a name are called, before their number."""
_FROM = {
    "quadrilateral": [-1, -1],
    "hexahedron": [-1] * 3,
    "pyramid": [-1, -1, 0],
    "wedge": [0, 0, -1],
}
"""Where gmsh's reference cells begin that are not those from 0 to 1; all end at 1."""

Places = Mapping[tuple[int, int], Sequence[Ints]]
"""Elements of each entity, given by its dimension and number."""


def gmsh_content(file: Path) -> FileContent:
    """Nodes, elements and physical groups of a file."""
    arrays = arrays_of("gmsh_program", file)
    what, numbers = json.loads(arrays["what"].item()), arrays["tags"]
    require(len(numbers) > 0, "file", "no nodes", "a mesh")
    points = arrays["positions"].reshape(-1, 3)
    blocks: list[ElementBlock] = []
    places: dict[tuple[int, int], list[Ints]] = {}
    count = 0
    for i, (dim, entity, kind) in enumerate(what["blocks"]):
        if dim:
            name, order, per_element, local = what["kinds"][str(kind)]
            ids, nodes = arrays[f"numbers {i}"], arrays[f"nodes {i}"].reshape(-1, per_element)
            rows = rows_of(numbers, nodes, "a node")
            blocks.append(_block(name, dim, order, local, ids, rows))
            places.setdefault((dim, entity), []).append(np.arange(count, count + len(ids)))
            count += len(ids)
    sets = _groups(what["groups"], places)
    return without_copies(FileContent(points, numbers, blocks, sets))


def _block(
    name: str, dim: int, order: int, local: Sequence[float], ids: Ints, rows: Ints
) -> ElementBlock:
    """Elements of one kind in one entity."""
    cell = _CELLS.get(name.split()[0])
    if cell is None or (cell in DIVIDED and order > 2):
        return ElementBlock(name, "line" if dim == 1 else name, order, ids, rows)
    reference = np.reshape(local, (rows.shape[1], -1))[:, :dim]
    low = np.array(_FROM.get(cell, [0] * dim))
    reference = (reference - low) / (1 - low)
    return ElementBlock(name, cell, order, ids, in_order(cell, order, rows, reference))


def _groups(
    groups: Sequence[tuple[int, int, str, Sequence[int]]], places: Places
) -> dict[str, Ints]:
    """Elements of each physical group; groups of one name together."""
    sets: dict[str, list[Ints]] = {}
    for dim, tag, name, entities in groups:
        if dim:
            members = sets.setdefault(name or f"{_WORDS[dim]} {tag}", [])
            for entity in entities:
                members += places.get((dim, entity), ())
    return {name: np.concatenate(parts) for name, parts in sets.items() if parts}
