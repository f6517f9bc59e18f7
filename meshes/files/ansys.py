"""Content of Ansys archives (CDWRITE); run as a program, converts one with mapdl-archive."""

import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cea.arrays import Ints
from cea.errors import InputError, require
from meshes.files.content import (
    ElementBlock,
    FileContent,
    block,
    known_rows,
    rows_of,
    without_nodes,
)
from meshes.files.reading import arrays_of, library

_HEAD = 10
"""Numbers of an element before its nodes: material, type, ..., its number."""
_SOLIDS = {45: 8, 185: 8, 95: 20, 186: 20, 285: 4, 92: 10, 187: 10}
"""Nodes of hexahedra and tetrahedra by the number of their type."""
_MARKS = (154, 170, 173, 174, 175, 177)
"""Types of surface loads and of sides of contacts: they are no part of a body."""
_NODES = re.compile(
    rb"(?im)^[ \t]*NBLOCK,.*\n(?:[ \t]*\(.*\n)?(?:[ \t]*\d.*\n)*"
    rb"(?:[ \t]*(?:N,[^\n]*,)?[ \t]*-1.*\n)?"
)
"""Nodes from NBLOCK to the line that ends them."""
_OF_BRICK = {
    "tetrahedron": [0, 1, 2, 4, 8, 9, 11, 16, 17, 18],
    "pyramid": [0, 1, 2, 3, 4, 8, 9, 10, 11, 16, 17, 18, 19],
    "wedge": [0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 15, 16, 17, 18],
    "hexahedron": list(range(20)),
}
"""Nodes of each cell among those of a degenerate brick."""


def ansys_content(file: Path) -> FileContent:
    """Read nodes, elements and components of an archive.

    Elements of each material and type are sets as well, ``material 1`` and ``type 2``.
    """
    library(file, "mapdl_archive")
    arrays = arrays_of(Path(__file__), file)
    numbers, points = arrays["numbers"].astype(np.int64), arrays["points"].astype(float)
    data, ends = arrays["elements"].astype(np.int64), arrays["ends"]
    starts = np.concatenate([[0], ends[:-1]])
    count = ends - starts - _HEAD
    require(len(count) > 0 and count.min() > 0, "file", str(file), "nodes of every element")
    heads = data[starts[:, None] + np.arange(_HEAD)]
    types = dict(arrays["types"].tolist())
    kinds = [types.get(number, 0) for number in heads[:, 1].tolist()]
    blocks: list[ElementBlock] = []
    for kind, nodes in sorted(set(zip(kinds, count.tolist(), strict=True))):
        rows = np.flatnonzero((np.array(kinds) == kind) & (count == nodes))
        listed = data[starts[rows, None] + _HEAD + np.arange(nodes)]
        blocks += _blocks(kind, heads[rows, 8], listed, numbers)
    ids = np.concatenate([block.numbers for block in blocks])
    sets = _components(arrays, "element", ids)
    for column, word in ((0, "material"), (1, "type")):
        for value in np.unique(heads[:, column]):
            own = heads[heads[:, column] == value, 8]
            sets.setdefault(f"{word} {value}", known_rows(ids, own))
    return FileContent(points, numbers, blocks, sets, _components(arrays, "node", numbers))


def _blocks(kind: int, numbers: Ints, nodes: Ints, known: Ints) -> Iterator[ElementBlock]:
    """Yield the elements of a type, a block for each cell."""
    name, count = f"type {kind}", _SOLIDS.get(kind, 1000)
    if nodes.shape[1] < count:
        yield without_nodes(name, numbers, "mark" if kind in _MARKS else "structural")
        return
    cells = np.full(len(nodes), "tetrahedron")
    if count in (8, 20):
        apex = (nodes[:, 4:5] == nodes[:, 5:8]).all(axis=1)
        triangle, above = nodes[:, 2] == nodes[:, 3], nodes[:, 6] == nodes[:, 7]
        conditions = [apex & triangle, apex, triangle & above]
        cells = np.select(conditions, ["tetrahedron", "pyramid", "wedge"], "hexahedron")
    for cell in np.unique(cells).tolist():
        own = cells == cell
        of_brick = [i for i in _OF_BRICK[cell] if i < count]
        listed = nodes[own][:, of_brick if count in (8, 20) else range(count)]
        lacks = (listed == 0).any(axis=1)
        if lacks.any():
            worst = f"element {int(numbers[own][np.argmax(lacks)])}"
            raise InputError("file", worst, "elements with the middles of all edges")
        rows = rows_of(known, listed, "a node")
        yield block(name, f"{cell}{listed.shape[1]}", numbers[own], rows)


def _components(arrays: Mapping[str, Any], kind: str, numbers: Ints) -> dict[str, Ints]:
    """Rows of the nodes or elements of each component."""
    return {
        name.removeprefix(f"{kind} "): known_rows(numbers, members.astype(np.int64))
        for name, members in arrays.items()
        if name.startswith(f"{kind} ")
    }


def _write_arrays(archive: str, arrays: str) -> None:
    """Read an archive and write its nodes, elements, types and components."""
    from mapdl_archive import Archive

    read = Archive(archive, parse_vtk=False)
    numbers, nodes = read.nnum, np.asarray(read.nodes)
    blocks = _NODES.findall(Path(archive).read_bytes())
    if len(blocks) > 1:  # the library keeps only one of several
        one, each = f"{arrays}.cdb", []
        for block in blocks:
            Path(one).write_bytes(b"/PREP7\n" + block + b"FINISH\n")
            each.append(Archive(one, parse_vtk=False))
        numbers = np.concatenate([part.nnum for part in each])
        nodes = np.concatenate([part.nodes for part in each])
    components = {
        f"{kind} {name}": numbers
        for kind, of_kind in (("node", read.node_components), ("element", read.element_components))
        for name, numbers in of_kind.items()
    }
    elements = list(read.elem)
    np.savez(
        arrays,
        numbers=numbers,
        points=nodes[:, :3],
        elements=np.concatenate(elements),
        ends=np.cumsum([len(element) for element in elements]),
        types=read.ekey,
        **components,
    )


if __name__ == "__main__":
    try:
        _write_arrays(*sys.argv[1:])
    except Exception:  # broken files raise any error, mostly without a useful message
        sys.exit("it is not a blocked archive as written by CDWRITE")
