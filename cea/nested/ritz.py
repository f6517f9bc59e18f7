"""Approximate eigenvalues with their vectors, and small problems projected on bases of them.

Bases may be dependent: singular values of their inner products that are rounding are left out.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, eigh

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import DEGENERATE, assign

DEPENDENT = 1e-13
"""Singular value of inner products, relative to the largest, that is rounding."""


@dataclass(frozen=True)
class Approximation:
    """Approximate lambda (1/s) with vectors x and y, y^H (lambda^2 M + lambda D + K) = 0."""

    eigenvalues: Complexes
    right: Complexes
    left: Complexes


def one_of_each_pair(eigenvalues: Complexes) -> Ints:
    """Modes without those that decay as others, conjugate in lambda^2, grow."""
    decaying = np.flatnonzero((eigenvalues.real < 0) & (eigenvalues.imag > 0))
    growing = eigenvalues[(eigenvalues.real > 0) & (eigenvalues.imag > 0)]
    apart = np.abs(eigenvalues[decaying][:, None] + growing.conj())
    apart /= np.abs(eigenvalues[decaying][:, None])
    mirrored = decaying[assign(apart, DEGENERATE)[0]]
    return np.setdiff1d(np.arange(len(eigenvalues)), mirrored)


def growing(kappa: Complexes) -> Complexes:
    """Lambda of -lambda^2 with Im lambda >= 0; of real ones below zero, the one that grows."""
    values = np.sqrt(-np.asarray(kappa, dtype=complex))
    values = np.where(values.imag < 0, -values, values) + 0j
    return np.where(values.imag == 0, np.abs(values.real), values)


def matched(wanted: Complexes, found: Complexes) -> Ints:
    """Number of the eigenvalue that belongs to each wanted one, of least total distance."""
    return assign(np.abs(wanted[:, None] - found))[1]


def ritz(
    works: Floats, masses: Floats, *, symmetric: bool = False
) -> tuple[Complexes, Complexes, Complexes]:
    """Eigenvalues, right and left vectors of a projected problem, whose bases may be dependent."""
    if symmetric:
        sizes, turned = np.linalg.eigh(0.5 * (masses + masses.T))
        large = sizes > DEPENDENT * sizes.max()
        kept = turned[:, large]
        own = kept.T @ works @ kept
        mu, z = eigh(0.5 * (own + own.T), np.diag(sizes[large]))
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
