"""Stiffness and mass of joined patches.

With the gradients grad N_a = sum_k D_k N_a grad xi_k, isotropic elasticity

    K[a i, b j] = int lambda d_i N_a d_j N_b + mu d_j N_a d_i N_b + mu delta_ij grad N_a . grad N_b

(Hughes, The Finite Element Method, sec. 2.7) has the coefficients

    C_km[ij] = lambda E[ij] + mu E[ji] + mu delta_ij tr E,    E = |J| grad xi_k (x) grad xi_m.
"""

from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from iga_cea.entries import entries
from iga_cea.metric import VALUE, Metric
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.separation import Coefficients
from iga_cea.storage import Kept, block_matrix, component_matrix
from iga_cea.sum_factorisation import Form


def stiffness(
    multipatch: Multipatch,
    pattern: Pattern,
    lame: tuple[float, float],
    comm: Any,
    kept: Kept | None = None,
) -> Any:
    """Elastic stiffness.

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
    kept
        Unknowns that stay; None of all.

    Returns
    -------
    PETSc.Mat
        AIJ matrix (N/m), exactly symmetric; of block size dim where all unknowns stay.

    Raises
    ------
    InputError
        When a patch is folded.
    """
    lam, mu = lame
    dim = multipatch.dim

    def coefficients(metric: Metric) -> Coefficients:
        found: Coefficients = {}
        for k, m in combinations_with_replacement(sorted(metric.gradients), 2):
            scaled = metric.gradients[k] * metric.measure
            E = scaled[:, None] * metric.gradients[m]
            C = lam * E + mu * E.swapaxes(0, 1)
            trace = mu * np.trace(E)
            for i in range(dim):
                C[i, i] += trace
            found[k, m] = C.reshape(dim * dim, *trace.shape)
            found[m, k] = C.swapaxes(0, 1).reshape(dim * dim, *trace.shape)
        return found

    data = entries(multipatch, pattern, Form(dim, coefficients), comm)
    return block_matrix(pattern, data, dim, kept, comm)


def mass(
    multipatch: Multipatch, pattern: Pattern, rho: float, comm: Any, kept: Kept | None = None
) -> Any:
    """Consistent mass.

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
    kept
        Unknowns that stay; None of all.

    Returns
    -------
    PETSc.Mat
        AIJ matrix (kg), exactly symmetric; of block size dim where all unknowns stay.

    Raises
    ------
    InputError
        When a patch is folded.
    """

    def coefficients(metric: Metric) -> Coefficients:
        return {(VALUE, VALUE): rho * metric.measure[None]}

    data = entries(multipatch, pattern, Form(1, coefficients), comm)
    return component_matrix(pattern, data, multipatch.dim, kept, comm)
