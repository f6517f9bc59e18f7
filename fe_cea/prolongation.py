"""Prolongation between two Lagrange discretisations of a body: coarse functions at fine nodes.

Fine nodes are located in the cells of the coarse mesh; nodes outside it, at curved boundaries, are
moved to the nearest cell. Prolongation is exact if each fine cell lies in a coarse cell, has at
least its degree and the restriction of its map: for higher degree on the same mesh and geometry,
or for divided affine cells. Otherwise it interpolates, and between curved meshes is as accurate as
their geometries agree.
"""

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.errors import InputError
from fe_cea.cell_location import Cells

_ROUNDING = 1e-14
"""Function values below which entries are dropped."""
_SAME = 0.5
"""Distance, relative to the cell size, above which the meshes are of different bodies."""


def prolongation(coarse: Any, fine: Any, comm: Any, field: str) -> csr_array:
    """Return the prolongation from one space of a body to another; collective."""
    before, dim = coarse.mesh.geometry.dim, fine.mesh.geometry.dim
    if before != dim:
        raise InputError(field, f"{dim} dimensions", f"{before}, the dimension of the coarse body")
    cells = Cells.of(coarse)
    first, last = fine.dofmap.index_map.local_range
    nodes = fine.tabulate_dof_coordinates()[: last - first, :dim]
    cell, xi, miss = cells.locate(np.ascontiguousarray(nodes))
    worst = max(comm.allgather(float(miss.max(initial=0.0))))
    if worst > _SAME:
        allowed = f"the body of the coarse mesh, nodes within {_SAME:g} cells of it"
        raise InputError(field, f"{worst:.3g} cells apart", allowed)
    values = cells.values(xi)
    values[np.abs(values) < _ROUNDING] = 0.0
    columns = cells.dofs[cell]
    starts = np.arange(0, values.size + 1, values.shape[1])
    shape = len(nodes), coarse.dofmap.index_map.size_global
    matrix = csr_array((values.ravel(), columns.ravel(), starts), shape=shape)
    matrix.eliminate_zeros()
    return matrix
