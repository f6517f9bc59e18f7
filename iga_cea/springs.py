"""Elastic foundations of NURBS surfaces."""

from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, kron

from cea.petsc import PETSc
from cea.supports.boundary import Spring
from iga_cea.surface import NurbsSurface


def foundation(surface: NurbsSurface, spring: Spring, points: int, owned: slice, comm: Any) -> Any:
    """Matrix of a spring, all dofs: int k_c N_a N_b on the diagonal of components.

    Parameters
    ----------
    surface
        Its surface.
    spring
        The spring.
    points
        Gauss points of a span along each parameter.
    owned
        Full dofs of this rank.
    comm
        MPI communicator.

    Returns
    -------
    PETSc.Mat
        AIJ matrix (N/m), symmetric.
    """
    at = surface.gauss_points(points)
    scaled = diags_array(np.sqrt(at.weight)) @ surface.trace(at.at)
    scalar = csr_array(scaled.T @ scaled)
    whole = csr_array(kron(scalar, diags_array(np.asarray(spring.stiffness)), format="csr"))
    rows = whole[owned]
    columns = whole.shape[0]
    local: Any = (rows.shape[0], columns)
    csr: Any = (
        rows.indptr.astype(PETSc.IntType),
        rows.indices.astype(PETSc.IntType),
        rows.data,
    )
    return PETSc.Mat().createAIJ(size=(local, local), csr=csr, comm=comm)
