"""Matrices of a rotating body of joined patches (:mod:`cea.rotation`), by three scalar ones.

With the derivative t_a of function a along the rotation,

    m_ab = int rho N_a N_b,    A_ab = int rho (N_a t_b - t_a N_b),    B_ab = int rho t_a t_b,

A skew, and W v = a x v, the components of Y and Z are

    Y = A (x) 1                 Z = B (x) 1                                 with Coriolis forces
    Y = A (x) 1 - 2 m (x) W     Z = B (x) 1 + A (x) W + m (x) W^T W         without
"""

from typing import Any

import numpy as np
from scipy.sparse import csr_array, kron

from cea.arrays import Floats
from cea.petsc import PETSc
from cea.rotation import Rotation
from iga_cea.assembly import distributed_matrix, gram
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.quadrature import batches


def gyroscopic(
    multipatch: Multipatch, pattern: Pattern, rho: float, rotation: Rotation, comm: Any
) -> Any:
    """Y at 1 rad/s, all dofs.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of this rank.
    rho
        Density (kg/m^3).
    rotation
        The rotation.
    comm
        MPI communicator.

    Returns
    -------
    PETSc.Mat
        AIJ matrix of block size dim (kg), exactly skew in serial.
    """
    mass, transport, _ = _scalar_matrices(multipatch, pattern, rho, rotation, comm.rank)
    spin = rotation.spin(multipatch.dim)
    whole = kron(transport, np.eye(len(spin)), format="csr")
    if not rotation.coriolis:
        whole = whole - 2 * kron(mass, spin, format="csr")
    return _matrix(multipatch, pattern, csr_array(whole), comm)


def convective_stiffness(
    multipatch: Multipatch, pattern: Pattern, rho: float, rotation: Rotation, comm: Any
) -> Any:
    """Z, all dofs: AIJ matrix of block size dim (kg), exactly symmetric in serial.

    Parameters are those of :func:`gyroscopic`.
    """
    mass, transport, square = _scalar_matrices(multipatch, pattern, rho, rotation, comm.rank)
    spin = rotation.spin(multipatch.dim)
    whole = kron(square, np.eye(len(spin)), format="csr")
    if not rotation.coriolis:
        whole = whole + kron(transport, spin, format="csr")
        whole = whole + kron(mass, spin.T @ spin, format="csr")
    return _matrix(multipatch, pattern, csr_array(whole), comm)


def _scalar_matrices(
    multipatch: Multipatch, pattern: Pattern, rho: float, rotation: Rotation, rank: int
) -> tuple[csr_array, csr_array, csr_array]:
    """m, A and B on the local scalar dofs of a rank (kg)."""
    dim = multipatch.dim
    spin, origin = rotation.spin(dim), np.asarray(rotation.origin[:dim])
    points = multipatch.control_points[pattern.dofs]
    mass, transport, square = (np.zeros(len(pattern.columns)) for _ in range(3))
    for batch in batches(multipatch, pattern, rank, components=1):
        root = np.sqrt(rho * batch.measure)[..., None]
        velocity = (batch.values @ points[batch.rows] - origin) @ spin.T
        values: Floats = batch.values * root
        slopes: Floats = (batch.gradients @ velocity[..., None])[..., 0] * root
        moved = values.swapaxes(1, 2) @ slopes
        parts = gram(values), moved - moved.swapaxes(1, 2), gram(slopes)
        for a, row, place in batch.places:
            at = pattern.starts[row][:, None] + place
            for whole, part in zip((mass, transport, square), parts, strict=True):
                whole[at] += part[:, a]
    n = len(pattern.dofs)

    def matrix(data: Floats) -> csr_array:
        return csr_array((data, pattern.columns, pattern.starts), shape=(n, n))

    return matrix(mass), matrix(transport), matrix(square)


def _matrix(multipatch: Multipatch, pattern: Pattern, local: csr_array, comm: Any) -> Any:
    """AIJ matrix of the sums over ranks."""
    local.sort_indices()
    indptr, indices = (part.astype(PETSc.IntType) for part in (local.indptr, local.indices))
    return distributed_matrix(multipatch, pattern, (indptr, indices, local.data), comm)
