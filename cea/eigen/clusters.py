"""Errors of eigenvalues that rounding cannot tell apart: those of their cluster.

Vectors of copies that rounding has parted may be nearly parallel, and condition numbers of single
eigenvalues then say nothing. With the invariant subspace of the cluster, whose block is B and whose
spectral projector is P, a backward error e moves every member by no more than about

    norm(P) e + norm(B - mean of the cluster)

(Stewart & Sun, Matrix Perturbation Theory, ch. V). Where the block is far from a multiple of one,
as at a coalescence, that is no better than the condition numbers.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, schur, solve_sylvester
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from cea.arrays import Complexes, Floats

_ILL = 1e1
"""Condition number from which a cluster is looked at."""


def cluster_bounds(
    projected: Floats, kappa: Complexes, errors: Floats, conditions: Floats
) -> Floats:
    """Bounds on the errors of eigenvalues (1/s^2), shape (n,); infinite where there is no cluster.

    Parameters
    ----------
    projected
        M^-1 K on an invariant subspace (1/s^2), shape (k, k).
    kappa
        Some of its eigenvalues, shape (n,).
    errors, conditions
        Their backward errors (1/s^2) and condition numbers, shape (n,).
    """
    bounds = np.full(len(kappa), np.inf)
    every = np.linalg.eigvals(projected).astype(complex)
    for members in clusters(kappa, errors * conditions):
        if conditions[members].max() < _ILL:
            continue
        reach = (errors[members] * conditions[members]).max()
        chosen = np.abs(every[:, None] - kappa[members]).min(axis=1) <= reach
        if chosen.sum() != len(members):
            continue
        block, projector = _block(projected, every[chosen], every[~chosen])
        mean = np.trace(block) / len(block)
        spread = float(np.linalg.norm(block - mean * np.eye(len(block)), 2))
        bounds[members] = projector * errors[members].max() + spread
    return bounds


def clusters(kappa: Complexes, reach: Floats) -> Iterator[NDArray[np.int64]]:
    """Numbers of eigenvalues whose errors overlap, two or more together."""
    near = np.abs(kappa[:, None] - kappa) <= np.add.outer(reach, reach)
    count, label = connected_components(csr_array(near), directed=False)
    for each in range(count):
        members = np.flatnonzero(label == each)
        if len(members) > 1:
            yield members


def _block(
    projected: Floats, inside: Complexes, outside: Complexes
) -> tuple[NDArray[np.complex128], float]:
    """Block of a cluster in an orthonormal basis, and the norm of its spectral projector."""

    def belongs(value: complex) -> bool:
        near = np.abs(inside - value).min()
        return bool(not len(outside) or near < np.abs(outside - value).min())

    try:
        form, _, size = schur(projected.astype(complex), output="complex", sort=belongs)
    except LinAlgError:
        return np.diag(inside), np.inf
    if size != len(inside):
        return np.diag(inside), np.inf
    block = form[:size, :size]
    if size == len(form):
        return block, 1.0
    coupling = solve_sylvester(block, -form[size:, size:], form[:size, size:])
    return block, float(np.sqrt(1 + np.linalg.norm(coupling, 2) ** 2))
