"""Content of files that meshio reads: VTU and XDMF."""

import re
from pathlib import Path

import numpy as np

from cea.errors import InputError, require
from cea.files import regular
from meshes.mesh_files.content import ElementBlock, FileContent, Ints
from meshes.mesh_files.kinds import block

_KINDS = {
    "triangle": "triangle3",
    "triangle6": "triangle6",
    "quad": "quadrilateral4",
    "quad8": "quadrilateral8",
    "quad9": "quadrilateral9",
    "tetra": "tetrahedron4",
    "tetra10": "tetrahedron10",
    "hexahedron": "hexahedron8",
    "hexahedron20": "hexahedron20",
    "hexahedron27": "hexahedron27",
    "VTK_LAGRANGE_TRIANGLE": "triangle{n}",
    "VTK_LAGRANGE_QUADRILATERAL": "quadrilateral{n}",
    "VTK_LAGRANGE_TETRAHEDRON": "tetrahedron{n}",
    "VTK_LAGRANGE_HEXAHEDRON": "hexahedron{n}",
}
"""Our names for meshio's kinds of cells."""
_ELSEWHERE = re.compile(rb"""Format\s*=\s*["'](?:HDF|Binary)["'][^>]*>\s*([^<:]+)""", re.I)
"""Names of files that an XDMF file takes its numbers from."""
_LINES = ("line", "line3")
_MOST = 1000
"""Values of a whole-number field that are taken for sets."""


def meshio_content(file: Path) -> FileContent:
    """Nodes, cells and sets of a file.

    Whole-number fields on cells or on nodes stand for sets: those with the value 3 of the field
    ``part`` are the set ``part 3``; those that are not 0 where it takes only 0 and 1, ``part``.

    Raises
    ------
    InputError
        When meshio is not installed, or cannot read the file.
    """
    try:
        from meshio import vtu, xdmf
    except ImportError:
        allowed = "meshio to read it: python -m pip install 'friction-cea[meshes]'"
        raise InputError("file", str(file), allowed) from None
    for match in _ELSEWHERE.finditer(file.read_bytes()):
        regular(file.parent / match[1].decode("utf-8", "replace").strip())
    try:
        # What chooses among them ends the program where a file cannot be read.
        mesh = (vtu if file.suffix.lower() == ".vtu" else xdmf).read(file)
    except ModuleNotFoundError as error:
        allowed = f"{error.name} to read it: python -m pip install 'friction-cea[meshes]'"
        raise InputError("file", str(file), allowed) from None
    except KeyError as error:
        if not isinstance(error.args[0], int | np.integer):
            raise
        allowed = "cells that meshio knows; where several kinds are in one file, of order 1"
        raise InputError("file", f"cells of type {error.args[0]}", allowed) from None
    points = np.asarray(mesh.points, dtype=float)
    fits = points.ndim == 2 and points.shape[1] in (2, 3) and len(points) > 0
    fits = fits and bool(np.isfinite(points).all())
    require(fits, "file", points.shape, "a mesh with points, of finite coordinates")
    positions = np.zeros((len(points), 3))
    positions[:, : points.shape[1]] = points
    blocks, first = [], 1
    for cells in mesh.cells:
        nodes = np.asarray(cells.data)
        require(nodes.ndim == 2 and nodes.dtype.kind in "iu", "file", cells.type, "rows of nodes")
        inside = not nodes.size or (nodes.min() >= 0 and nodes.max() < len(points))
        require(bool(inside), "file", cells.type, f"nodes from 0 to {len(points) - 1}")
        blocks.append(_block(cells.type, nodes.astype(np.int64), first))
        first += len(nodes)
    of_cells = {name: np.concatenate(values) for name, values in mesh.cell_data.items()}
    sets = _sets(of_cells, first - 1)
    nodes_of = _sets(mesh.point_data, len(points))
    return FileContent(positions, np.arange(1, len(points) + 1), blocks, sets, nodes_of)


def _block(kind: str, nodes: Ints, first: int) -> ElementBlock:
    numbers = first + np.arange(len(nodes), dtype=np.int64)
    if kind in _KINDS:
        return block(kind, _KINDS[kind].format(n=nodes.shape[1]), numbers, nodes)
    cell = "line" if kind in _LINES else kind
    return ElementBlock(kind, cell, 1, numbers, nodes)


def _sets(fields: dict[str, np.ndarray], count: int) -> dict[str, Ints]:
    """Members of the sets that whole-number fields stand for."""
    sets: dict[str, Ints] = {}
    for name, field in fields.items():
        values = np.asarray(field)
        if values.shape != (count,) or values.dtype.kind not in "iub":
            continue
        found = np.unique(values)
        if set(found.tolist()) <= {0, 1}:
            sets[name] = np.flatnonzero(values)
        elif len(found) <= _MOST:
            sets |= {f"{name} {value}": np.flatnonzero(values == value) for value in found}
    return sets
