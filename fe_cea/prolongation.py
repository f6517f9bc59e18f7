"""Prolongation between two Lagrange discretisations of one body: coarse functions at fine nodes.

Nodes are located in the cells of the coarse mesh, and moved into the nearest one where a curved
boundary of the fine mesh lies outside. It is exact where each fine cell lies in a coarse one whose
map it continues, and has at least its degree: the same mesh with a higher degree and the same
geometry, or cells divided whose maps are affine. Between curved meshes it is as good as their
geometries agree, and interpolation between others.
"""

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.errors import InputError
from fe_cea.cell_location import Cells

_ROUNDING = 1e-14
"""Values of functions that are dropped."""
_SAME = 0.5
"""Distance, relative to the size of a cell, within which a body is the same in both meshes."""


def prolongation(coarse: Any, fine: Any, comm: Any, field: str) -> csr_array:
    """Prolongation from one space of a body to another; collective."""
    before, dim = coarse.mesh.geometry.dim, fine.mesh.geometry.dim
    if before != dim:
        raise InputError(field, f"{dim} dimensions", f"{before}, as the coarse body has")
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
