"""Stiffness and mass of joined patches by Gauss quadrature, a chunk of elements at a time.

With the physical gradients of an element scaled by the square root of weight and Jacobian, one
product H = G^T G holds every integral

    H[a, i, b, j] = int dN_a/dx_i dN_b/dx_j,

and isotropic elasticity is K[a, i, b, j] = lambda H[a, i, b, j] + mu H[a, j, b, i]
+ mu delta_ij sum_k H[a, k, b, k] (Hughes, The Finite Element Method, sec. 2.7). The product of a
matrix with its own transpose is exactly symmetric, and so is all that follows.
"""

from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.petsc import PETSc
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.quadrature import batches


def stiffness(
    multipatch: Multipatch, pattern: Pattern, lame: tuple[float, float], comm: Any
) -> Any:
    """Elastic stiffness, all dofs.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of this rank.
    lame
        Lame parameters (N/m^2).
    comm
        MPI communicator.

    Returns
    -------
    PETSc.Mat
        AIJ matrix of block size dim (N/m), exactly symmetric in serial.
    """
    dim = multipatch.dim
    indptr, indices = pattern.block_rows(dim)
    data = np.zeros(len(indices))
    triples = data.reshape(-1, dim)

    for batch in batches(multipatch, pattern, comm.rank, components=dim):
        scaled = batch.gradients * np.sqrt(batch.measure)[..., None, None]
        H = gram(scaled.reshape(*scaled.shape[:2], -1))
        shape = (len(H), *scaled.shape[2:], *scaled.shape[2:])
        K = _elasticity(H.reshape(shape), *lame)
        for a, row, place in batch.places:
            start, count = dim * pattern.starts[row], pattern.counts[row]
            for i in range(dim):
                triples[(start + i * count)[:, None] + place] += K[:, a, i]
    return distributed_matrix(multipatch, pattern, (indptr, indices, data), comm)


def mass(multipatch: Multipatch, pattern: Pattern, rho: float, comm: Any) -> Any:
    """Consistent mass, all dofs.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of this rank.
    rho
        Density (kg/m^3).
    comm
        MPI communicator.

    Returns
    -------
    PETSc.Mat
        AIJ matrix of block size dim (kg), exactly symmetric in serial.
    """
    data = np.zeros(len(pattern.columns))

    for batch in batches(multipatch, pattern, comm.rank, components=1):
        M = gram(batch.values * np.sqrt(rho * batch.measure)[..., None])
        for a, row, place in batch.places:
            data[pattern.starts[row][:, None] + place] += M[:, a]
    return distributed_matrix(multipatch, pattern, pattern.expanded(data, multipatch.dim), comm)


def gram(a: Floats) -> Floats:
    """Products A^T A of stacked matrices, exactly symmetric (BLAS syrk)."""
    return a.swapaxes(1, 2) @ a


def _elasticity(H: Floats, lam: float, mu: float) -> Floats:
    K = lam * H
    K += mu * H.transpose(0, 1, 4, 3, 2)
    trace = mu * np.einsum("eakbk->eab", H)
    for i in range(H.shape[2]):
        K[:, :, i, :, i] += trace
    return K


def distributed_matrix(multipatch: Multipatch, pattern: Pattern, csr: Any, comm: Any) -> Any:
    """AIJ matrix of block size dim from what each rank adds to it.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of this rank.
    csr
        Row starts, columns and values on the local full dofs of this rank.
    comm
        MPI communicator.
    """
    dim = multipatch.dim
    local = dim * len(pattern.dofs)
    part = PETSc.Mat().createAIJWithArrays(
        size=(local, local), bsize=dim, csr=csr, comm=PETSc.COMM_SELF
    )
    if comm.size == 1:
        return part
    owned = dim * int(np.diff(multipatch.dof_ranges)[comm.rank])
    sizes = ((owned, dim * multipatch.num_scalar_dofs),) * 2
    dofs: Any = pattern.dofs.astype(PETSc.IntType)
    numbering = PETSc.LGMap().create(dofs, bsize=dim, comm=comm)
    whole = PETSc.Mat().createIS(sizes, bsize=dim, lgmapr=numbering, lgmapc=numbering, comm=comm)
    whole.setISLocalMat(part)
    whole.assemble()
    return whole.convert(PETSc.Mat.Type.AIJ)
