"""Bounds on the errors of eigenvalues of a reduced model, of one and of several together.

Where eigenvalues nearly coalesce, bounds of one mean little: their condition grows without limit.
With a biorthonormal basis Y, Z of a cluster of p eigenvalues, block B = Z^H K Y, and the residuals
R and S of its invariant subspaces, the true block differs from B by e = g |R| |S| at most. The mean
of the cluster then is off by no more than e, and its members by

    (2 |B - mean| + e)^(1 - 1/p) e^(1/p)

(L. Elsner, An optimal bound for the spectral variation of two matrices, Linear Algebra Appl. 71
(1985)).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import connected
from cea.reduced.products import real_times
from cea.reduced.rounding import Rounding

TOUCH = 10.0
"""Bound of an eigenvalue, in its distance from the next, from the inverse of which on they are
judged together."""


class Projection(Protocol):
    """K or M on a basis (:class:`cea.reduced.spectrum.Residuals`)."""

    @property
    def square(self) -> Floats:
        """V^T A V."""
        ...

    @property
    def right(self) -> Floats:
        """Q^T A V."""
        ...

    @property
    def left(self) -> Floats:
        """Q^T A^T V."""
        ...

    @property
    def lost(self) -> float:
        """Norm of what these leave out."""
        ...

    def measured(self, residuals: Complexes) -> Complexes:
        """Coordinates of residuals, shape (q, n), whose lengths are their norms."""
        ...


@dataclass(frozen=True)
class Certificate:
    """Bounds on errors of eigenvalues.

    Parameters
    ----------
    errors
        Of each kappa (1/s^2), shape (n,).
    means
        Of the mean of the cluster that it belongs to (1/s^2), shape (n,): that of itself where it
        is alone.
    reduction
        What the basis makes of the latter, without rounding (1/s^2), shape (n,).
    clusters
        Number of that cluster, shape (n,).
    conditions
        Condition numbers of kappa in the M-norm, shape (n,).
    """

    errors: Floats
    means: Floats
    reduction: Floats
    clusters: Ints
    conditions: Floats

    def __getitem__(self, modes: Ints) -> "Certificate":
        return Certificate(
            self.errors[modes],
            self.means[modes],
            self.reduction[modes],
            self.clusters[modes],
            self.conditions[modes],
        )


def certify(
    kappa: Complexes,
    right: Complexes,
    left: Complexes,
    stiffness: Projection,
    mass: Projection,
    outside: Floats,
    rounding: Rounding,
) -> Certificate:
    """Bounds on the errors of eigenvalues.

    Parameters
    ----------
    kappa
        Eigenvalues (1/s^2), shape (n,).
    right, left
        Coordinates of their vectors of M-norm one, shape (k, n).
    stiffness, mass
        The reduced matrices.
    outside
        g, shape (n,).
    rounding
        What rounding does to eigenvalues.
    """
    M = mass.square
    overlap = np.abs(np.einsum("ij,ij->j", left.conj(), real_times(M, right)))
    conditions = 1 / np.maximum(overlap, np.finfo(float).tiny)
    r = real_times(stiffness.right, right) - real_times(mass.right, right * kappa)
    s = real_times(stiffness.left, left) - real_times(mass.left, left * kappa.conj())
    lost = stiffness.lost + np.abs(kappa) * mass.lost
    sizes = (np.linalg.norm(each, axis=0) for each in (right, left))
    lengths = [
        np.linalg.norm(stiffness.measured(defect), axis=0) + lost * size
        for defect, size in zip((r, s), sizes, strict=True)
    ]
    reduction = conditions * outside * lengths[0] * lengths[1]
    errors = reduction + conditions * rounding.of_pairs(left, right, np.sqrt(np.abs(kappa)))
    means, clusters = errors.copy(), np.arange(len(kappa))
    distance = np.abs(kappa[:, None] - kappa)
    near = distance <= TOUCH * np.minimum(errors[:, None], errors)
    for number, members in enumerate(connected(near)):
        clusters[members] = number
        if len(members) > 1:
            own, doubt, spread = _together(
                right[:, members],
                left[:, members],
                stiffness,
                mass,
                outside[members].max(),
                rounding,
            )
            e, p = own + doubt, len(members)
            reduction[members], means[members] = own, e
            errors[members] = (2 * spread + e) ** (1 - 1 / p) * e ** (1 / p)
    return Certificate(errors, means, reduction, clusters, conditions)


def _together(
    right: Complexes,
    left: Complexes,
    stiffness: Projection,
    mass: Projection,
    outside: float,
    rounding: Rounding,
) -> tuple[float, float, float]:
    """Error of the block of a cluster, rounding of it, distance from a multiple of one."""
    M = mass.square
    y, z = (_apart(vectors, int(np.count_nonzero(np.diag(M)))) for vectors in (right, left))
    y = y @ np.linalg.inv(np.linalg.cholesky(y.conj().T @ M @ y)).conj().T
    overlap = z.conj().T @ M @ y
    try:
        z = z @ np.linalg.inv(overlap).conj().T
    except np.linalg.LinAlgError:
        return np.inf, np.inf, np.inf
    block = z.conj().T @ stiffness.square @ y
    r = _defect(stiffness.right, mass.right, y, block)
    s = _defect(stiffness.left, mass.left, z, block.conj().T)
    size = float(np.linalg.norm(block, 2))
    lost = stiffness.lost + size * mass.lost
    lengths = [
        float(np.linalg.norm(stiffness.measured(defect), 2) + lost * np.linalg.norm(vectors, 2))
        for defect, vectors in ((r, y), (s, z))
    ]
    mean = np.trace(block) / len(block)
    spread = float(np.linalg.norm(block - mean * np.eye(len(block)), 2))
    projector = float(np.sqrt(np.linalg.norm(z.conj().T @ M @ z, 2)))
    doubt = rounding.solves * projector + rounding.of_block(z, y, np.sqrt(size))
    return float(outside * lengths[0] * lengths[1]), doubt, spread


def _apart(vectors: Complexes, k: int) -> Complexes:
    """Combinations of vectors with orthonormal displacements, their first k numbers."""
    _, sizes, axes = np.linalg.svd(vectors[:k], full_matrices=False)
    return vectors @ axes.conj().T / sizes


def _defect(K: Floats, M: Floats, vectors: Complexes, block: Complexes) -> Complexes:
    """(K - M .) of vectors: K X - M X B."""
    return real_times(K, vectors) - real_times(M, vectors @ block)
