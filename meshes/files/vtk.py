"""Content of VTU files, which meshio reads, and of XDMF files, as dolfinx and meshio write them."""

import re
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from cea.files import regular
from meshes.files.content import KINDS, ElementBlock, FileContent, block, without_copies

_CELLS = {
    **{"triangle": "triangle", "tri": "triangle", "quadrilateral": "quadrilateral"},
    **{"quad": "quadrilateral", "tetrahedron": "tetrahedron", "tetra": "tetrahedron"},
    **{"tet": "tetrahedron", "hexahedron": "hexahedron", "hex": "hexahedron"},
    **{"wedge": "wedge", "pyramid": "pyramid"},
}
"""Cells by the first word of their names."""
_MIXED = {
    **{1: ("vertex", 1), 2: ("line", 2), 4: ("triangle", 3), 5: ("quadrilateral", 4)},
    **{6: ("tetrahedron", 4), 7: ("pyramid", 5), 8: ("wedge", 6), 9: ("hexahedron", 8)},
    **{34: ("line", 3), 35: ("quadrilateral", 9), 36: ("triangle", 6), 37: ("quadrilateral", 8)},
    **{38: ("tetrahedron", 10), 39: ("pyramid", 13), 40: ("wedge", 15), 41: ("wedge", 18)},
    **{48: ("hexahedron", 20), 50: ("hexahedron", 27)},
}
"""Cell and number of nodes by the numbers of XDMF in topologies of several kinds."""
_MOST = 1000
"""Values of a whole-number field that are taken for sets."""
_NAME = re.compile(r"(?:VTK_LAGRANGE_|Bi)?([A-Za-z]+)_?\d*")

Fields = dict[str, np.ndarray]


def vtu_content(file: Path) -> FileContent:
    """Nodes, cells and sets of a VTU file.

    Whole-number fields on cells or on nodes stand for sets: those with the value 3 of the field
    ``part`` are the set ``part 3``; those that are not 0 where it takes only 0 and 1, ``part`` too.
    """
    try:
        from meshio import vtu
    except ImportError:
        raise _needs(file, "meshio") from None
    try:
        # What chooses among formats ends the program where a file cannot be read.
        mesh = vtu.read(file)
    except KeyError as error:
        if not isinstance(error.args[0], int | np.integer) and error.args[0] not in _UNREAD:
            raise
        raise InputError(
            "file", f"cells of type {error.args[0]}", "cells that meshio knows"
        ) from None
    points = _positions(mesh.points)
    blocks, first = [], 1
    for cells in mesh.cells:
        nodes = np.asarray(cells.data)
        blocks.append(_block(cells.type, nodes, first, points))
        first += len(nodes)
    of_cells = {name: np.concatenate(values) for name, values in mesh.cell_data.items()}
    return FileContent(
        points,
        np.arange(1, len(points) + 1),
        blocks,
        _sets(of_cells, first - 1),
        _sets(mesh.point_data, len(points)),
    )


_UNREAD = ("wedge15", "wedge18", "pyramid13", "pyramid14")
"""Cells that meshio has names for alone."""


def xdmf_content(file: Path) -> FileContent:
    """Nodes, cells and sets of an XDMF file; fields are sets as in VTU files.

    All grids are read on the points of the first: tags that dolfinx writes are fields on grids of
    their own, whose cells are those of the mesh, or mark its faces.
    """
    root = ElementTree.parse(file).getroot()
    geometry = next(root.iter("Geometry"))
    points = _positions(_item(file, geometry))
    blocks: list[ElementBlock] = []
    sets: dict[str, Ints] = {}
    of_nodes: dict[str, Ints] = {}
    count = 0
    for grid in root.iter("Grid"):
        topology = grid.find("Topology")
        if topology is None:
            continue
        own = [_block(*cells, count + 1, points) for cells in _topology(file, topology)]
        n = sum(map(len, own))
        for center, found, size in (("Cell", sets, n), ("Node", of_nodes, len(points))):
            fields = {
                each.get("Name", ""): _item(file, each).ravel()
                for each in grid.iter("Attribute")
                if each.get("Center", "Node") == center
            }
            for name, members in _sets(fields, size).items():
                found[name] = members + (count if center == "Cell" else 0)
        blocks += own
        count += n
    return without_copies(
        FileContent(points, np.arange(1, len(points) + 1), blocks, sets, of_nodes)
    )


def _topology(file: Path, topology: ElementTree.Element) -> list[tuple[str, Ints]]:
    """Kinds of cells and their nodes; of several kinds, in the order in which they follow."""
    kind = topology.get("TopologyType", topology.get("Type", ""))
    nodes = _item(file, topology)
    require(nodes.dtype.kind in "iu", "file", kind, "whole numbers of nodes")
    offset = int(topology.get("BaseOffset", 0))
    if kind.lower() != "mixed":
        return [(kind, nodes - offset)]
    data, at = nodes.ravel().tolist(), 0
    rows: list[tuple[str, list[int]]] = []
    while at < len(data):
        require(data[at] in _MIXED, "file", data[at], f"types of cells, of {sorted(_MIXED)}")
        name, size = _MIXED[data[at]]
        at += 2 if name in ("vertex", "line") and data[at] < 3 else 1  # these tell their size
        rows.append((name, data[at : at + size]))
        at += size
    kinds = [(name, len(row)) for name, row in rows]
    ends = [i for i, (a, b) in enumerate(pairwise([("", 0), *kinds])) if a != b] + [len(rows)]
    return [
        (kinds[a][0], np.array([row for _, row in rows[a:b]], dtype=np.int64) - offset)
        for a, b in pairwise(ends)
    ]


def _item(file: Path, parent: ElementTree.Element) -> np.ndarray:
    """Numbers of the data of an element."""
    item = parent.find("DataItem")
    require(item is not None, "file", parent.tag, "a DataItem in it")
    assert item is not None
    form, text = item.get("Format", "XML"), (item.text or "").strip()
    shape = [int(n) for n in item.get("Dimensions", "-1").split()]
    if form == "HDF":
        try:
            import h5py
        except ImportError:
            raise _needs(file, "h5py") from None
        name, _, place = text.partition(":")
        with h5py.File(regular(file.parent / name), "r") as store:
            return np.asarray(store[place]).reshape(shape)
    kind = item.get("NumberType", item.get("DataType", "Float"))
    if form == "Binary":
        order = {"Little": "<", "Big": ">"}.get(item.get("Endian", ""), "=")
        letter = {"Int": "i", "UInt": "u", "Float": "f"}.get(kind, "")
        dtype = np.dtype(f"{order}{letter}{item.get('Precision', 4)}")
        return np.fromfile(regular(file.parent / text), dtype).reshape(shape)
    require(form == "XML", "file", f"a DataItem of format {form}", "XML, HDF or Binary")
    whole = kind in ("Int", "UInt", "Char", "UChar")
    return np.array(text.split(), dtype=np.int64 if whole else np.float64).reshape(shape)


def _needs(file: Path, library: str) -> InputError:
    allowed = f"{library} to read it: python -m pip install 'friction-cea[meshes]'"
    return InputError("file", str(file), allowed)


def _positions(points: np.ndarray) -> Floats:
    """Points in space."""
    given = np.asarray(points, dtype=float)
    fits = given.ndim == 2 and given.shape[1] in (2, 3) and len(given) > 0
    require(fits, "file", given.shape, "a mesh with points")
    positions = np.zeros((len(given), 3))
    positions[:, : given.shape[1]] = given
    return positions


def _block(kind: str, nodes: np.ndarray, first: int, points: Floats) -> ElementBlock:
    require(nodes.ndim == 2 and nodes.dtype.kind in "iu", "file", kind, "rows of nodes")
    inside = not nodes.size or (nodes.min() >= 0 and nodes.max() < len(points))
    require(bool(inside), "file", kind, f"nodes from 0 to {len(points) - 1}")
    nodes, numbers = nodes.astype(np.int64), first + np.arange(len(nodes), dtype=np.int64)
    match = _NAME.fullmatch(kind)
    cell = _CELLS.get(match[1].lower(), "") if match else ""
    known = f"{cell}{nodes.shape[1]}"
    if known not in KINDS:
        is_line = kind.lower().startswith(("line", "polyline", "edge", "interval"))
        return ElementBlock(kind, "line" if is_line else kind, 1, numbers, nodes)
    if known == "wedge6":  # programs begin with either triangle
        x = points[nodes]
        turn = np.linalg.det(x[:, 1:4] - x[:, :1]) < 0
        nodes[turn] = nodes[turn][:, [3, 4, 5, 0, 1, 2]]
    return block(kind, known, numbers, nodes)


def _sets(fields: Mapping[str, np.ndarray], count: int) -> dict[str, Ints]:
    """Members of the sets that whole-number fields stand for."""
    sets: dict[str, Ints] = {}
    for name, field in fields.items():
        values = np.asarray(field)
        if values.shape != (count,) or values.dtype.kind not in "iub":
            continue
        found = np.unique(values)
        if set(found.tolist()) <= {0, 1}:
            sets[name] = np.flatnonzero(values)
        if len(found) <= _MOST:
            sets |= {f"{name} {value}": np.flatnonzero(values == value) for value in found}
    return sets
