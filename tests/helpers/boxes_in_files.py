"""Two bent boxes in mesh files of every format, and bodies read of them."""

import numpy as np
import pytest

from cea.mesh import Mesh
from meshes.breaks import breaks_of
from meshes.mesh_file import MeshFile
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box

NEEDED = {".cdb": "mapdl_archive", ".xdmf": "h5py", ".vtu": "meshio"}


def file_of(folder, name):
    """A file to write, where what reads its format is there."""
    file = folder / name
    if file.suffix in NEEDED:
        pytest.importorskip(NEEDED[file.suffix])
    return file


def bent(points):
    """A quadratic map: 20-node hexahedra hold it exactly, in any order of nodes but theirs not."""
    x, y, z = points.T
    return np.stack([x + 0.1 * y * z, 1 + y + 0.08 * x * x - 0.05 * z, z + 0.06 * x * y], axis=1)


def two_boxes(cell, order, elements=(2, 1, 3)):
    """Bent meshes of two boxes that do not touch."""
    shapes = {"left": Box((1.0, 0.5, 1.5)), "right": Box((1.0, 0.5, 1.5), (2.0, 0.25, 0.0))}
    meshes = {}
    for name, shape in shapes.items():
        flat = shape_mesh(shape, cell, order, breaks=breaks_of(shape, elements))
        meshes[name] = Mesh(cell, order, bent(flat.points), flat.cells, flat.surfaces)
    return meshes


def made(data, **changes):
    return MeshFile(**{**data, **changes})


def by_place(points):
    """Rows in the order of their coordinates."""
    return points[np.lexsort(np.round(points, 9).T)]
