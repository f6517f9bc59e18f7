"""Eigenpairs as a driver found them, normalised, with residuals and condition numbers."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import (
    all_inner,
    column_blocks,
    columns_inner,
    norms,
    times,
    transposed_times,
)
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted
from cea.eigen.sizes import Sizes
from cea.eigen.subspace import conditions_of
from cea.matrices import destroy

SMALL = 1e-8
"""Part of an eigenvalue up to which it does not matter how large a residual is exactly."""
LUMPED = 4.0
"""What the norm of the inverse of a mass is at most, about, in that of its diagonal."""


@dataclass(frozen=True)
class Eigenpairs:
    """Eigenpairs K x = kappa M x, kappa = -lambda^2.

    Parameters
    ----------
    kappa
        Eigenvalues (1/s^2), shape (n,).
    vectors
        Eigenvectors with x^H M x = 1, the rows of this rank, shape (n_local, n).
    forces
        Contact forces that are unknowns, shape (multipliers of this rank, n).
    residuals
        Norm of (K - kappa M) x relative to abs(kappa) times that of M x, shape (n,); where kappa is
        nothing but rounding, relative to that.
    conditions
        Condition numbers of kappa within the computed invariant subspace, shape (n,).
    errors
        Backward errors of kappa (1/s^2), shape (n,): what the residual amounts to, and what
        rounding the entries of K does.
    bounds
        Bounds on errors of kappa (1/s^2) by the clusters that they belong to
        (:mod:`cea.eigen.clusters`), shape (n,); infinite where there is none.
    """

    kappa: Complexes
    vectors: Complexes
    forces: Complexes
    residuals: Floats
    conditions: Floats
    errors: Floats
    bounds: Floats


def checked(
    matrices: Matrices,
    factors: Shifted,
    kappa: Complexes,
    vectors: Complexes,
    conditions: Floats | None = None,
) -> Eigenpairs:
    """Normalise eigenpairs and find their residuals, condition numbers and backward errors.

    Where contact forces are unknowns, one step of inverse iteration gives displacements that obey
    the contact, and the forces. With the residual r and the shift sigma,

        abs(kappa - sigma) || (K - sigma M)^-1 r ||_M

    is the backward error of kappa in the inverse problem, which is the one that was solved, and
    || r || in the norm of M^-1, or nearly of the diagonal of M, is that in the problem itself: far
    from the shift it is the smaller one. Rounding of the entries of K adds u abs(x)^T abs(K)
    abs(x).

    Parameters
    ----------
    matrices
        The pencil at the parameters it was solved at.
    factors
        The pencil factorised.
    kappa
        Eigenvalues (1/s^2), shape (n,).
    vectors
        Eigenvectors, the rows of this rank, shape (n_local, n). They are normalised in place. That
        of a conjugate which follows its eigenvalue is the conjugate.
    conditions
        Condition numbers where they are known.
    """
    n, mass, comm = len(kappa), matrices.mass, matrices.stiffness.comm
    kappa, residuals, errors, sizes = kappa.copy(), np.empty(n), np.empty(n), Sizes(matrices)
    forces = np.empty((factors.multipliers, n), dtype=complex)
    diagonal = mass.getDiagonal()
    root = np.sqrt(diagonal.array_r)
    destroy(diagonal)
    twins = _twins(kappa)
    rows = 0 if matrices.multipliers is not None else matrices.size  # forces take solves
    for block, x in _blocks(kappa, vectors, twins, rows):
        value = kappa[block] if np.iscomplexobj(x) else kappa[block].real
        f = np.empty((0, x.shape[1]), dtype=x.dtype)
        if matrices.multipliers is not None:
            x, f = inverse_step(matrices, factors, value, x)
        force, inertia = internal_forces(matrices, x, f), times(mass, x)
        size = np.sqrt(columns_inner(x, inertia, comm).real)
        for part in (x, f, force, inertia):
            part /= size
        vectors[:, block], forces[:, block] = x, f
        if matrices.symmetric:  # the Rayleigh quotient has the square of the vector's error
            value = columns_inner(x, force, comm).real
            kappa[block] = value
        rounding = np.finfo(float).eps * sizes.works(x, f)
        scale = np.maximum(np.abs(value), rounding) * norms(inertia, comm)
        inertia *= value
        force -= inertia
        defect: NDArray[Any] = force
        residuals[block] = norms(defect, comm) / scale
        error = LUMPED * norms(defect / root[:, None], comm)
        large = np.flatnonzero(error > SMALL * np.abs(value))
        if len(large):  # solves cost as much as all the rest
            step = solved(factors, defect[:, large])
            length = np.sqrt(np.abs(columns_inner(step, times(mass, step), comm)))
            inverse = np.abs(value[large] - factors.kappa) * length
            error[large] = np.minimum(error[large], inverse)
        errors[block] = rounding + error
    sizes.free()
    for each in (vectors, forces):
        each[:, twins] = each[:, twins - 1].conj()
    residuals[twins], errors[twins] = residuals[twins - 1], errors[twins - 1]
    if conditions is None:
        conditions = np.ones(n) if matrices.symmetric else conditions_of(_gram(mass, vectors))
    return Eigenpairs(kappa, vectors, forces, residuals, conditions, errors, np.full(n, np.inf))


def _twins(kappa: Complexes) -> NDArray[np.int64]:
    """Numbers of the eigenvalues that are the conjugates of those before them."""
    return 1 + np.flatnonzero((kappa[:-1].imag > 0) & (kappa[1:] == kappa[:-1].conj()))


def _blocks(
    kappa: Complexes, vectors: Complexes, twins: NDArray[np.int64], rows: int
) -> Iterator[tuple[NDArray[np.int64], NDArray[Any]]]:
    """Numbers of eigenvalues with their vectors, real ones in real numbers; without twins."""
    real = kappa.imag == 0
    other = ~real
    other[twins] = False
    for chosen, part in ((real, np.real), (other, np.asarray)):
        numbers = np.flatnonzero(chosen)
        for columns in column_blocks(len(numbers), rows):
            block = numbers[columns]
            yield block, np.asfortranarray(part(vectors)[:, block])


def _gram(mass: Any, vectors: Complexes) -> Complexes:
    """Inner products of unit eigenvectors."""
    gram = np.empty((vectors.shape[1],) * 2, dtype=complex)
    for block in column_blocks(len(gram)):
        gram[block] = all_inner(times(mass, vectors[:, block]), vectors, mass.comm)
    return gram


def solved(factors: Shifted, columns: NDArray[Any]) -> NDArray[Any]:
    """(K - sigma M)^-1 times a block of columns, real or complex."""
    if not np.iscomplexobj(columns):
        return factors.solve_block(columns)
    n = columns.shape[1]
    parts = factors.solve_block(np.hstack([columns.real, columns.imag]))
    return parts[:, :n] + 1j * parts[:, n:]


def inverse_step(
    matrices: Matrices,
    factors: Shifted,
    kappa: NDArray[Any],
    vectors: NDArray[Any],
    *,
    transposed: bool = False,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """One step of inverse iteration, scaled as the vectors are: displacements and contact forces.

    Parameters
    ----------
    matrices, factors
        The pencil, and factorised.
    kappa, vectors
        Eigenvalues and the rows of this rank of their vectors, both real or both complex.
    transposed
        Whether the vectors are left ones.
    """
    n = vectors.shape[1]
    inertia = times(matrices.mass, vectors * (kappa - factors.kappa))
    if not np.iscomplexobj(inertia):
        return factors.solve_with_forces(inertia, transposed=transposed)
    x, f = factors.solve_with_forces(np.hstack([inertia.real, inertia.imag]), transposed=transposed)
    return x[:, :n] + 1j * x[:, n:], f[:, :n] + 1j * f[:, n:]


def internal_forces(
    matrices: Matrices, x: NDArray[Any], f: NDArray[Any], *, transposed: bool = False
) -> NDArray[Any]:
    """K x + L^T f, or K^T x + J^T f, of displacements and contact forces, in blocks of columns."""
    force = times(matrices.stiffness, x)
    if matrices.unsymmetric is not None:
        force += (transposed_times if transposed else times)(matrices.unsymmetric, x)
    if matrices.circulatory is not None:
        force += matrices.circulatory.times(x, transposed=transposed)
    if (forces := matrices.multipliers) is not None:
        force += transposed_times(forces.closure if transposed else forces.reaction, f)
    return force
