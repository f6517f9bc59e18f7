"""Prolongation between two Lagrange discretisations of one body: coarse functions at fine nodes.

Nodes are located in the cells of the coarse mesh, and moved into the nearest one where a curved
boundary of the fine mesh lies outside. It is exact where each fine cell lies in a coarse one whose
map it continues, and has at least its degree: the same mesh with a higher degree and the same
geometry, or cells divided whose maps are affine. Between curved meshes it is as good as their
geometries agree, and interpolation between others; the defect tells.
"""

import basix
import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.errors import InputError
from cea.nested.prolongation import Prolongation, on_free_dofs, varied_coefficients
from fe_cea.body import FEBody
from fe_cea.cell_location import Cells, own_cells
from fe_cea.facets import geometry_element

_ROUNDING = 1e-14
"""Values of functions that are dropped."""
_SAME = 0.5
"""Distance, relative to the size of a cell, within which a body is the same in both meshes."""
_SAMPLES = np.array([[0.31, 0.22, 0.13], [0.17, 0.53, 0.24]])
"""Reference coordinates, of boxes and simplices alike, at which a prolongation is tried."""


def prolongation(coarse: FEBody, fine: FEBody) -> Prolongation:
    """Prolongation from one discretisation of a body to another; collective.

    Parameters
    ----------
    coarse, fine
        The body in both discretisations, on the same ranks.

    Raises
    ------
    InputError
        When the meshes are not those of one body.
    """
    field = f"bodies.{fine.name}.mesh"
    if coarse.dim != fine.dim:
        raise InputError(field, f"{fine.dim} dimensions", f"{coarse.dim}, as the coarse body has")
    cells = Cells.of(coarse.space)
    first, last = fine.space.dofmap.index_map.local_range
    nodes = fine.space.tabulate_dof_coordinates()[: last - first, : fine.dim]
    scalar, miss = _evaluated(cells, np.ascontiguousarray(nodes), coarse.num_scalar_dofs)
    worst = max(fine.comm.allgather(miss))
    if worst > _SAME:
        allowed = f"the body of the coarse mesh, nodes within {_SAME:g} cells of it"
        raise InputError(field, f"{worst:.3g} cells apart", allowed)
    defect = _defect(cells, scalar, fine)
    return on_free_dofs(scalar, max(miss, defect), coarse, fine, fine.constraints)


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


def _defect(cells: Cells, scalar: csr_array, fine: FEBody) -> float:
    """Largest difference of a coarse function and its prolongation inside the cells of a rank."""
    coefficients = varied_coefficients(scalar.shape[1])
    everywhere = np.concatenate(fine.comm.allgather(scalar @ coefficients))
    space = fine.space
    nodes, dofs = own_cells(space)
    table = geometry_element(space.mesh).tabulate(0, _SAMPLES[:, : fine.dim])[0, :, :, 0]
    x = np.einsum("pk,cki->cpi", table, nodes).reshape(-1, fine.dim)
    trial: basix.finite_element.FiniteElement = space.ufl_element().basix_element
    values = trial.tabulate(0, _SAMPLES[:, : fine.dim])[0, :, :, 0]
    found = (everywhere[dofs] @ values.T).ravel()
    wanted = _evaluated(cells, x, scalar.shape[1])[0] @ coefficients
    return float(np.abs(found - wanted).max(initial=0.0))
