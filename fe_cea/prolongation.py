"""Prolongation between two Lagrange discretisations of one body: coarse functions at fine nodes.

Nodes are located in the cells of the coarse mesh, and moved into the nearest one where a curved
boundary of the fine mesh lies outside. It is exact where each fine cell lies in a coarse one whose
map it continues, and has at least its degree: the same mesh with a higher degree and the same
geometry, or cells divided whose maps are affine. Between curved meshes it is as good as their
geometries agree, and interpolation between others; the defect tells.
"""

from typing import Any

import basix
import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.errors import InputError
from cea.nested.prolongation import varied_coefficients
from fe_cea.cell_location import Cells, own_cells
from fe_cea.facets import geometry_element

_ROUNDING = 1e-14
"""Values of functions that are dropped."""
_SAME = 0.5
"""Distance, relative to the size of a cell, within which a body is the same in both meshes."""
_SAMPLES = np.array([[0.31, 0.22, 0.13], [0.17, 0.53, 0.24]])
"""Reference coordinates, of boxes and simplices alike, at which a prolongation is tried."""


def prolongation(coarse: Any, fine: Any, comm: Any, field: str) -> tuple[csr_array, float]:
    """Prolongation from one space of a body to another; collective."""
    before, dim = coarse.mesh.geometry.dim, fine.mesh.geometry.dim
    if before != dim:
        raise InputError(field, f"{dim} dimensions", f"{before}, as the coarse body has")
    cells = Cells.of(coarse)
    first, last = fine.dofmap.index_map.local_range
    nodes = fine.tabulate_dof_coordinates()[: last - first, :dim]
    count = coarse.dofmap.index_map.size_global
    scalar, miss = _evaluated(cells, np.ascontiguousarray(nodes), count)
    worst = max(comm.allgather(miss))
    if worst > _SAME:
        allowed = f"the body of the coarse mesh, nodes within {_SAME:g} cells of it"
        raise InputError(field, f"{worst:.3g} cells apart", allowed)
    return scalar, max(miss, _defect(cells, scalar, fine, comm))


def _evaluated(cells: Cells, x: Floats, count: int) -> tuple[csr_array, float]:
    """Values of all coarse functions at points, and the largest distance of one from its cell."""
    cell, xi, miss = cells.locate(x)
    values = cells.values(xi)
    values[np.abs(values) < _ROUNDING] = 0.0
    columns = cells.dofs[cell]
    starts = np.arange(0, values.size + 1, values.shape[1])
    matrix = csr_array((values.ravel(), columns.ravel(), starts), shape=(len(x), count))
    matrix.eliminate_zeros()
    return matrix, float(miss.max(initial=0.0))


def _defect(cells: Cells, scalar: csr_array, space: Any, comm: Any) -> float:
    """Largest difference of a coarse function and its prolongation inside the cells of a rank."""
    coefficients = varied_coefficients(scalar.shape[1])
    everywhere = np.concatenate(comm.allgather(scalar @ coefficients))
    dim = space.mesh.geometry.dim
    nodes, dofs = own_cells(space)
    table = geometry_element(space.mesh).tabulate(0, _SAMPLES[:, :dim])[0, :, :, 0]
    x = np.einsum("pk,cki->cpi", table, nodes).reshape(-1, dim)
    trial: basix.finite_element.FiniteElement = space.ufl_element().basix_element
    values = trial.tabulate(0, _SAMPLES[:, :dim])[0, :, :, 0]
    found = (everywhere[dofs] @ values.T).ravel()
    wanted = _evaluated(cells, x, scalar.shape[1])[0] @ coefficients
    return float(np.abs(found - wanted).max(initial=0.0))
