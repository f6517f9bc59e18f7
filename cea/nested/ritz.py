"""Small eigenvalue problems of two bases, which may be dependent."""

import numpy as np
from scipy.linalg import eig, eigh

from cea.arrays import Complexes, Floats

DEPENDENT = 1e-13
"""Singular value of inner products, relative to the largest, that counts as none."""


def ritz(
    works: Floats, masses: Floats, *, symmetric: bool = False
) -> tuple[Complexes, Complexes, Complexes]:
    """Eigenvalues, right and left vectors of a projected problem, whose bases may be dependent."""
    if symmetric:
        sizes, turned = np.linalg.eigh(mean_with_transpose(masses))
        large = sizes > DEPENDENT * sizes.max()
        kept = turned[:, large]
        mu, z = eigh(mean_with_transpose(kept.T @ works @ kept), np.diag(sizes[large]))
        vectors = kept @ z + 0j
        return mu + 0j, vectors, vectors
    u, sizes, vt = np.linalg.svd(masses)
    count = int(np.sum(sizes > DEPENDENT * sizes.max()))
    U, V = u[:, :count], vt[:count].T
    mu, w, z = eig(U.T @ works @ V, np.diag(sizes[:count]), left=True)
    return mu, V @ z + 0j, U @ w + 0j


def quadratic_ritz(
    works: Floats, drags: Floats, masses: Floats
) -> tuple[Complexes, Complexes, Complexes]:
    """Eigenvalues lambda, right and left vectors of lambda^2 masses + lambda drags + works."""
    u, sizes, vt = np.linalg.svd(masses)
    count = int(np.sum(sizes > DEPENDENT * sizes.max()))
    U, V = u[:, :count] / sizes[:count], vt[:count].T
    stiffness, damping = U.T @ works @ V, U.T @ drags @ V
    scale = np.sqrt(np.abs(stiffness).max()) or 1.0
    one, none = np.eye(count), np.zeros((count, count))
    companion = np.block([[none, one], [-stiffness / scale**2, -damping / scale]])
    found, w, z = eig(companion, left=True)
    return scale * found, V @ z[:count] + 0j, U @ w[count:] + 0j


def mean_with_transpose(matrix: Floats) -> Floats:
    """Symmetric part of a matrix that is symmetric but for rounding."""
    return np.asarray(0.5 * (matrix + matrix.T))
