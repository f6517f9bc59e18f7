"""Errors of eigenvalues by their left vectors, which show what norms and subspaces do not.

A backward error moves an eigenvalue by as much as its left vector y is long, y^H M x = 1. Of the
left vectors the invariant subspace of the right ones knows no more than their projection. What it
leaves out comes out of one step of inverse iteration,

    W = Q - A^-T M Q (R - sigma)^T,    A = K - sigma M,    M^-1 K Q = Q R,

which vanishes where the subspace holds its left vectors too. Friction between bodies makes it about
as large as one. Where it is much larger, or conditions are bad, or the mass cancels, left vectors
are searched themselves. With the residual r = (K - kappa M) x and rounding u of all entries, kappa
is then in error by

    abs(y)^T (abs(r) + u (abs(K) + abs(kappa) abs(M)) abs(x)) / abs(y^H M x)

to first order, however unknowns and equations are scaled. That holds as far as y is right. Left
eigenvalues come of systems, start vectors and roundings of their own: by how much they and right
ones differ is what both searches have made of the matrices, a backward error that is counted for
every eigenvalue, times its condition.
"""

from dataclasses import replace

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import column_blocks, columns_inner, combined, image_of, times
from cea.eigen.clusters import cluster_bounds, clusters
from cea.eigen.eigenpairs import Eigenpairs, internal_forces
from cea.eigen.eigenvalue_matching import assign
from cea.eigen.pencil import Matrices
from cea.eigen.sensitivity import LeftVectors
from cea.eigen.shifted import Shifted
from cea.eigen.sizes import Sizes
from cea.eigen.subspace import InvariantSubspace
from cea.matrices import absolute, destroy
from cea.petsc import Mat

PLAIN = 30.0
"""Norm of W up to which the subspace says enough of its left vectors."""
ILL = 1e2
"""Condition number up to which one residual says enough of an eigenvalue."""
_CANCELS = 100.0
"""Sum of m_ii abs(x_i)^2, x^H M x = 1, up to which rounding of the mass counts for nothing."""
MORE = 2.0
"""Factor by which errors by left vectors are larger where they are believed instead."""
_UNKNOWN = 1e300
"""Error (1/s^2) in the place of an infinite one."""
COLUMNS = 4
"""Random combinations of a subspace by which its left vectors are judged."""


def one_sided(
    matrices: Matrices, factors: Shifted, subspace: InvariantSubspace, pairs: Eigenpairs
) -> bool:
    """Whether the right vectors say too little of the errors of eigenvalues; collective.

    Parameters
    ----------
    matrices, factors
        The pencil at given parameters, factorised.
    subspace, pairs
        Its invariant subspace, and the eigenpairs of that.
    """
    if matrices.symmetric or not subspace.size:
        return False
    if subspace.graded or pairs.conditions.max() > ILL or cancels(matrices.mass, pairs.vectors):
        return True
    return _left_out(matrices, factors, subspace) > PLAIN


def cancels(mass: Mat, vectors: Complexes) -> bool:
    """Whether parts of x^H M x = 1 are much larger than their sum; collective."""
    diagonal, parts = _diagonal(mass), (vectors.real, vectors.imag)
    sums: Floats = sum(np.einsum("i,ij,ij->j", diagonal, part, part) for part in parts)
    return bool(mass.comm.tompi4py().allreduce(sums).max() > _CANCELS)


def _left_out(matrices: Matrices, factors: Shifted, subspace: InvariantSubspace) -> float:
    """Estimate of the norm of W."""
    mixed = np.random.default_rng(3).standard_normal((subspace.size, COLUMNS))
    # Of what is far from the shift a step of inverse iteration leaves rounding.
    far = np.abs(np.diag(subspace.projected) - factors.kappa) / abs(factors.kappa)
    mixed /= np.maximum(1.0, far)[:, None]
    image = subspace.projected.T @ mixed - factors.kappa * mixed
    load = image_of(matrices.mass, combined(subspace.basis, image))
    rest = combined(subspace.basis, mixed) - factors.solve_block(load, transposed=True)
    squares = columns_inner(rest, image_of(matrices.mass, rest), matrices.mass.comm)
    return float(np.sqrt(squares.sum() / COLUMNS))


def _diagonal(mass: Mat) -> Floats:
    vector = mass.getDiagonal()
    diagonal = np.array(vector.array_r, dtype=float)
    destroy(vector)
    return diagonal


def two_sided_errors(
    matrices: Matrices, pairs: Eigenpairs, left: LeftVectors
) -> tuple[Floats, Floats]:
    """Errors of eigenvalues (1/s^2) and their condition numbers, shape (n,).

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    pairs, left
        Eigenpairs and their left vectors.
    """
    comm, mass, kappa = matrices.stiffness.comm, matrices.mass, pairs.kappa
    errors, conditions = np.empty((2, len(kappa)))
    sizes, inertia_sizes = Sizes(matrices), absolute(mass)
    weights = _diagonal(mass)[:, None]
    for block in column_blocks(len(kappa)):
        value, x, y = kappa[block], pairs.vectors[:, block], left.vectors[:, block]
        inertia = times(mass, x)
        force = internal_forces(matrices, x, pairs.forces[:, block])
        big, other = np.abs(x), np.abs(y)
        entries = sizes.forces(big, 2 * np.abs(pairs.forces[:, block]))
        entries += np.abs(value) * image_of(inertia_sizes, big)
        parts = np.einsum("ij,ij->j", other, np.abs(force - inertia * value))
        parts += np.finfo(float).eps * np.einsum("ij,ij->j", other, entries)
        overlap = np.abs(columns_inner(y, inertia, comm))
        total = comm.tompi4py().allreduce(parts)
        lengths = [
            comm.tompi4py().allreduce((weights * part**2).sum(axis=0)) for part in (big, other)
        ]
        with np.errstate(divide="ignore", invalid="ignore"):
            errors[block] = total / overlap
            conditions[block] = np.sqrt(lengths[0] * lengths[1]) / overlap
    sizes.free()
    destroy(inertia_sizes)
    errors[np.isnan(errors)] = np.inf
    return errors, np.maximum(np.nan_to_num(conditions, nan=np.inf), 1.0)


def _disagreement(
    kappa: Complexes, left_kappa: Complexes, conditions: Floats, top: float
) -> Floats:
    """Backward errors (1/s^2) that explain by how much left and right eigenvalues differ.

    It is one for all of a window, and grows with the distance beyond.
    """
    far = np.maximum(1.0, np.abs(kappa) / top)
    return far * disagreement(kappa, left_kappa.conj(), conditions * far)


def disagreement(values: Complexes, left: Complexes, conditions: Floats) -> float:
    """Largest distance of right and left eigenvalues over the conditions of the right ones.

    Parameters
    ----------
    values, left
        Eigenvalues, and conjugates of those of the transposed problem, in any order.
    conditions
        What the distances are measured by, shape (n,).
    """
    distances = np.abs(values[:, None] - left)
    rows, columns = assign(distances)
    return float((distances[rows, columns] / conditions[rows]).max(initial=0.0))


def bounds_widened(
    subspace: InvariantSubspace, values: Complexes, errors: Floats, conditions: Floats
) -> tuple[Floats, Floats]:
    """Errors where they overlap, and bounds of clusters, both of the units of the values.

    Parameters
    ----------
    subspace
        What the values are eigenvalues of.
    values, errors, conditions
        Eigenvalues, their errors by left vectors, and their condition numbers, shape (n,).
    """
    within = np.minimum(errors, _UNKNOWN) / conditions
    bounds = cluster_bounds(subspace.projected, values, within, conditions)
    widened = errors.copy()
    for members in clusters(values, errors):
        widened[members] *= len(members)  # discs that overlap hold all of their eigenvalues
    return widened, bounds


def judged_by_both(
    matrices: Matrices,
    subspace: InvariantSubspace,
    pairs: Eigenpairs,
    left: tuple[Complexes, LeftVectors] | None,
    top: float,
) -> Eigenpairs:
    """Eigenpairs whose errors are those by their left vectors, where these say much more.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    subspace
        What they are eigenpairs of.
    pairs
        Eigenpairs.
    left
        Eigenvalues of the transposed problem, in any order, and left vectors of the pairs; nothing
        is known of any error without.
    top
        Upper end of the window (1/s^2).
    """
    if left is None:
        unknown = np.full(len(pairs.kappa), np.inf)
        return replace(pairs, errors=unknown, bounds=unknown)
    errors, conditions = two_sided_errors(matrices, pairs, left[1])
    if subspace.graded:  # lengths say something in the units that the subspace was found in
        conditions = pairs.conditions
    errors = np.maximum(errors, conditions * _disagreement(pairs.kappa, left[0], conditions, top))
    errors, bounds = bounds_widened(subspace, pairs.kappa, errors, pairs.conditions)
    told = np.minimum(pairs.errors * pairs.conditions, pairs.bounds)
    more = np.minimum(errors, bounds) > MORE * told
    return replace(
        pairs,
        conditions=np.where(more, conditions, pairs.conditions),
        errors=np.where(more, errors / conditions, pairs.errors),
        bounds=np.where(more, bounds, pairs.bounds),
    )
