"""Content of VTU and XDMF files, which meshio reads.

Integer fields on cells or on nodes define sets: value 3 of the field ``part`` is the set
``part 3``; if a field has only the values 0 and 1, the ones are also the set ``part``.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from cea.files import regular
from meshes.files.content import ElementBlock, FileContent, block, without_copies
from meshes.files.elements import KINDS
from meshes.files.reading import library

_CELLS = {"quad": "quadrilateral", "tetra": "tetrahedron"}
"""Cells that meshio calls by other names than :data:`meshes.files.elements.KINDS`."""
_MOST = 1000
"""Largest number of values of an integer field that define sets."""
_UNREAD = ("wedge15", "wedge18", "pyramid13", "pyramid14")
"""Cells that meshio names but does not read."""


def vtu_content(file: Path) -> FileContent:
    """Nodes, cells and sets of a VTU file."""
    vtu = library(file, "meshio.vtu")
    try:
        # The function that chooses among formats ends the program if a file cannot be read.
        return _content([vtu.read(file)])
    except KeyError as error:
        if not isinstance(error.args[0], int | np.integer) and error.args[0] not in _UNREAD:
            raise
        told = f"cells of type {error.args[0]}"
        raise InputError("file", told, "cells that meshio knows") from None


def xdmf_content(file: Path) -> FileContent:
    """Nodes, cells and sets of an XDMF file, as dolfinx and meshio write them.

    All grids are read on the points of the first: dolfinx writes tags as fields on separate grids,
    whose cells are those of the mesh, or mark its faces.
    """
    library(file, "h5py")
    reader = library(file, "meshio.xdmf.main").XdmfReader
    root = ElementTree.parse(file).getroot()
    for item in root.iter("DataItem"):
        if item.get("Format", "XML").upper() != "XML":  # a reader would wait for a pipe
            regular(file.parent / (item.text or "").strip().partition(":")[0])
    geometry = next(root.iter("Geometry"))
    meshes = []
    for grid in root.iter("Grid"):
        topology = grid.find("Topology")
        if topology is not None:  # one grid at a time, as meshio reads
            topology.attrib = {k: v.replace("PolyLine", "Polyline") for k, v in topology.items()}
            whole = ElementTree.Element("Xdmf")
            alone = ElementTree.SubElement(ElementTree.SubElement(whole, "Domain"), "Grid")
            alone.extend([geometry, topology, *grid.findall("Attribute")])
            meshes.append(reader(file).read_xdmf3(whole))
    return without_copies(_content(meshes))


def _content(meshes: Sequence[Any]) -> FileContent:
    """Content of meshes of meshio on the same points."""
    given = np.asarray(meshes[0].points, dtype=float)
    fits = given.ndim == 2 and given.shape[1] in (2, 3) and len(given) > 0
    require(fits, "file", given.shape, "a mesh with points")
    points = np.pad(given, ((0, 0), (0, 3 - given.shape[1])))
    blocks: list[ElementBlock] = []
    sets: dict[str, Ints] = {}
    of_nodes: dict[str, Ints] = {}
    count = 0
    for mesh in meshes:
        first = count
        for cells in mesh.cells:
            blocks.append(_block(cells.type, np.asarray(cells.data), count + 1, points))
            count += len(cells.data)
        of_cells = {name: np.concatenate(values) for name, values in mesh.cell_data.items()}
        found = _sets(of_cells, count - first)
        sets |= {name: first + members for name, members in found.items()}
        of_nodes |= _sets(mesh.point_data, len(points))
    return FileContent(points, np.arange(1, len(points) + 1), blocks, sets, of_nodes)


def _block(kind: str, nodes: Ints, first: int, points: Floats) -> ElementBlock:
    require(nodes.ndim == 2 and nodes.dtype.kind in "iu", "file", kind, "rows of nodes")
    inside = not nodes.size or (nodes.min() >= 0 and nodes.max() < len(points))
    require(bool(inside), "file", kind, f"nodes from 0 to {len(points) - 1}")
    nodes, numbers = nodes.astype(np.int64), first + np.arange(len(nodes), dtype=np.int64)
    name = kind.removeprefix("VTK_LAGRANGE_").lower().rstrip("0123456789")
    known = f"{_CELLS.get(name, name)}{nodes.shape[1]}"
    if known not in KINDS:
        return ElementBlock(kind, "line" if name == "line" else kind, 1, numbers, nodes)
    if known == "wedge6":  # programs begin with either triangle
        x = points[nodes]
        turn = np.linalg.det(x[:, 1:4] - x[:, :1]) < 0
        nodes[turn] = nodes[turn][:, [3, 4, 5, 0, 1, 2]]
    return block(kind, known, numbers, nodes)


def _sets(fields: Mapping[str, np.ndarray], count: int) -> dict[str, Ints]:
    """Members of the sets that integer fields define."""
    sets: dict[str, Ints] = {}
    for name, field in fields.items():
        values = np.asarray(field).ravel()
        if values.shape != (count,) or values.dtype.kind not in "iub":
            continue
        found = np.unique(values)
        if set(found.tolist()) <= {0, 1}:
            sets[name] = np.flatnonzero(values)
        if len(found) <= _MOST:
            sets |= {f"{name} {value}": np.flatnonzero(values == value) for value in found}
    return sets
