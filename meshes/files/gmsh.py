"""Content of gmsh files; run as a program, reads one with gmsh and writes it as arrays."""

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cea.arrays import Ints
from cea.errors import require
from cea.mesh import SIMPLICES, lattice, matching_nodes
from meshes.files.content import ElementBlock, FileContent, known_rows, rows_of, without_copies
from meshes.files.elements import DIVIDED, full_kind
from meshes.files.reading import arrays_of

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
"""Names of unnamed groups by dimension, before their number."""
_FROM = {
    "quadrilateral": [-1, -1],
    "hexahedron": [-1, -1, -1],
    "pyramid": [-1, -1, 0],
    "wedge": [0, 0, -1],
}
"""Lower ends of gmsh's reference cells that do not begin at 0; all end at 1."""


def gmsh_content(file: Path) -> FileContent:
    """Nodes, elements and physical groups of a file."""
    with file.open("rb") as stream:
        require(stream.read(11) == b"$MeshFormat", "file", str(file), "a .msh file of gmsh")
    return content_of(arrays_of(Path(__file__), file))


def content_of(arrays: Mapping[str, Any]) -> FileContent:
    """Nodes, elements and physical groups of the arrays of a model."""
    kinds, groups = json.loads(arrays["what"].item())
    nodes = arrays["tags"]
    require(len(nodes) > 0, "file", "no nodes", "a mesh")
    blocks: list[ElementBlock] = []
    for i, (name, dim, order, local) in enumerate(kinds):
        rows = rows_of(nodes, arrays[f"nodes {i}"], "a node")
        blocks.append(_block(name, dim, order, local, arrays[f"numbers {i}"], rows))
    numbers = np.concatenate([np.empty(0, dtype=np.int64), *(block.numbers for block in blocks)])
    sets: dict[str, Ints] = {}  # groups of one name are joined
    for i, name in enumerate(groups):
        members = known_rows(numbers, arrays[f"group {i}"])
        sets[name] = np.concatenate([sets.get(name, members[:0]), members])
    points = arrays["positions"].reshape(-1, 3)
    return without_copies(FileContent(points, nodes, blocks, sets))


def _block(
    name: str, dim: int, order: int, local: Sequence[float], ids: Ints, rows: Ints
) -> ElementBlock:
    """Elements of one kind."""
    cell = _CELLS.get(name.split()[0])
    full = order < 3 or len(lattice(dim, order, cell in SIMPLICES)) == rows.shape[1]
    if cell is None or not full or (order > 2 and cell in DIVIDED):
        return ElementBlock(name, "line" if dim == 1 else name, order, ids, rows)
    reference = np.reshape(local, (rows.shape[1], -1))[:, :dim]
    low = np.array(_FROM.get(cell, [0] * dim))
    reference = (reference - low) / (1 - low)
    if order < 3:  # incomplete ones lack the middles of faces and cells, listed last
        listed = full_kind(cell, order).reference[: len(reference)]
        place = matching_nodes(listed, reference)
        rows, reference = rows[:, place], listed
    return ElementBlock(name, cell, order, ids, rows, reference)


def arrays_of_model(model: Any) -> dict[str, Any]:
    """Nodes, elements of each kind and physical groups of a gmsh model."""
    tags, positions, _ = model.mesh.getNodes()
    found: dict[str, Any] = {"tags": tags.astype(np.int64), "positions": positions}
    kinds: list[list[object]] = []
    for kind in model.mesh.getElementTypes():
        name, dim, order, per_element, local, _ = model.mesh.getElementProperties(kind)
        if dim:
            numbers, nodes = model.mesh.getElementsByType(kind)
            found[f"numbers {len(kinds)}"] = numbers.astype(np.int64)
            found[f"nodes {len(kinds)}"] = nodes.astype(np.int64).reshape(-1, per_element)
            kinds.append([name, dim, order, np.asarray(local).tolist()])
    groups: list[str] = []
    for dim, tag in model.getPhysicalGroups():
        members = [np.empty(0, dtype=np.int64)]
        for entity in model.getEntitiesForPhysicalGroup(dim, tag) if dim else ():
            members += [each.astype(np.int64) for each in model.mesh.getElements(dim, entity)[1]]
        if len(members) > 1:
            found[f"group {len(groups)}"] = np.concatenate(members)
            groups.append(model.getPhysicalName(dim, tag) or f"{_WORDS[dim]} {tag}")
    return found | {"what": np.array(json.dumps([kinds, groups]))}


def _write_arrays(mesh: str, arrays: str) -> None:
    """Read a mesh and write its arrays."""
    import gmsh

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.merge(mesh)
    np.savez(arrays, **arrays_of_model(gmsh.model))


if __name__ == "__main__":
    try:
        _write_arrays(*sys.argv[1:])
    except Exception as error:  # gmsh raises its own errors
        sys.exit(str(error))
