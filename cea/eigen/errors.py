"""Eigenpairs of an invariant subspace, with residuals, backward errors and condition numbers.

With a left vector y, y^H (2 lambda M + D) x = 1, a change of the problem moves an eigenvalue by

    d lambda = - y^H (lambda^2 dM + lambda dD + dK) x,

so that a backward error e of lambda^2 is worth || y ||_M e. Left vectors are those within the
invariant subspace, unless they are given (:mod:`cea.eigen.left_vectors`). Where the other
eigenvalue of a motion was not found, as of overdamped ones, they say too little:

    || y ||_M >= 1 / || (2 lambda M + D) x ||,

and e makes no more than sqrt(e) of the two of a motion where they meet. Without damping the
eigenvalue is kappa = -lambda^2, and || y ||_M its condition number.

With the residual r the backward error is || r || in the norm of M^-1, or nearly of the diagonal of
M, or what it is in the inverse problem, which is the one that was solved: without damping

    abs(kappa - sigma) || (K - sigma M)^-1 r ||_M.

Far from the shift the first is the smaller one. Rounding of the entries adds
u abs(x)^T abs(P) abs(x).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.blocks import all_inner, column_blocks, columns_inner, image_of, norms, times
from cea.eigen.pencil import Sizes, internal_forces
from cea.eigen.shift_invert import MARGIN, ShiftInvert
from cea.eigen.subspace import InvariantSubspace
from cea.matrices import destroy

_SMALL = 1e-8
"""Part of an eigenvalue up to which it does not matter how large a residual is exactly."""
_LUMPED = 4.0
"""What the norm of the inverse of a mass is at most, about, in that of its diagonal."""


@dataclass(frozen=True)
class Eigenpairs:
    """Eigenpairs of a window and around it."""

    values: Complexes  # kappa (1/s^2), or with damping or rotation lambda (1/s), shape (n,)
    vectors: Complexes  # eigenvectors with x^H M x = 1, rows of this rank, shape (n_local, n)
    forces: Complexes  # contact forces that are unknowns, shape (multipliers of this rank, n)
    residuals: Floats  # as :class:`cea.eigen.spectrum.Spectrum` has them
    conditions: Floats  # condition numbers of the values within the invariant subspace
    # what a backward error is multiplied by: the condition number, with damping norm(y)_M (s)
    slopes: Floats
    # backward errors of lambda^2 (1/s^2): of the residual, and of rounding the matrices
    errors: Floats

    @property
    def uncertainties(self) -> Floats:
        """Errors of the values, shape (n,)."""
        return self.errors * self.slopes


def error_estimates(op: ShiftInvert, subspace: InvariantSubspace) -> Eigenpairs:
    """Eigenpairs of an invariant subspace, normalised, with their errors.

    Where contact forces are unknowns, one step of inverse iteration gives displacements that obey
    the contact, and the forces. With damping conjugates with Im lambda < 0 are left out but for
    those next to the real axis. The operator is one near to the eigenvalues.
    """
    values, vectors = subspace.eigenpairs(op.matrices.stiffness.getLocalSize()[0])
    duals = subspace.duals()
    if op.damped:
        kept = np.flatnonzero(values.imag >= -MARGIN * op.scale)
        values, vectors, duals = values[kept], vectors[:, kept], duals[:, kept]
        # Left vectors are scaled by lambda, which may be zero to the last digit.
        values = np.where(values == 0, 1j * np.finfo(float).eps * op.scale, values)
    conditions = np.maximum(np.linalg.norm(duals, axis=0), 1.0)
    slopes = _slopes(op, subspace, duals) if op.damped else conditions
    return _checked(op, values, vectors, conditions, slopes)


def _checked(
    op: ShiftInvert, values: Complexes, vectors: Complexes, conditions: Floats, slopes: Floats
) -> Eigenpairs:
    """Eigenpairs, the vectors normalised in place, with residuals and backward errors.

    Conditions and slopes are those of vectors of unit length of the operator.
    """
    matrices, comm = op.matrices, op.matrices.stiffness.comm
    values, slopes, n = values.copy(), slopes.copy(), len(values)
    forces = np.empty((op.factors.multipliers, n), dtype=complex)
    lengths, residuals, errors, least = np.empty((4, n))
    sizes, diagonal = Sizes(matrices, op.damping), matrices.mass.getDiagonal()
    root = np.sqrt(diagonal.array_r)[:, None]
    destroy(diagonal)
    for block, x in _blocks(values, vectors):
        value = values[block] if np.iscomplexobj(x) else values[block].real
        f = np.empty((0, x.shape[1]), dtype=x.dtype)
        if matrices.multipliers is not None:
            lengths[block] = np.sqrt(columns_inner(x, times(matrices.mass, x), comm).real)
            x, f = op.inverse_step(value, x)
        parts = residual(op, value, x, f)
        size = np.sqrt(columns_inner(x, parts[-1], comm).real)
        x, f, defect, derivative, inertia = (part / size for part in (x, f, *parts))
        if matrices.multipliers is None:
            lengths[block] = size
        vectors[:, block], forces[:, block] = x, f
        if op.symmetric:  # Rayleigh's quotient has the square of the vector's error
            change = columns_inner(x, defect, comm).real
            values[block] = value = value + change
            defect -= inertia * change
        square, speed = op.square(value), np.sqrt(np.abs(op.square(value)))
        if op.damped:
            turned = norms(derivative / root, comm)
            least[block] = 1 / np.maximum(turned, np.finfo(float).tiny)
        entries = sizes.forces(x, 2 * np.abs(f), speed)
        works = comm.tompi4py().allreduce(np.einsum("ij,ij->j", np.abs(x), entries))
        rounding = np.finfo(float).eps * works
        scale = np.maximum(np.abs(square), rounding)
        whole = norms(entries, comm) if op.damped else scale * norms(inertia, comm)
        residuals[block] = norms(defect, comm) / np.maximum(whole, np.finfo(float).tiny)
        if op.damped:
            slopes[block] *= lengths[block]
        error = _LUMPED * norms(defect / root, comm)
        large = np.flatnonzero(error > _SMALL * scale)
        if len(large):  # solves cost as much as all the rest
            step = op.factors.solve_block(np.asfortranarray(defect[:, large]))
            length = np.sqrt(np.abs(columns_inner(step, times(matrices.mass, step), comm)))
            chosen = block[large]
            left = conditions[chosen] * lengths[chosen] if op.damped else slopes[chosen]
            slope = np.maximum(slopes[chosen], np.finfo(float).eps * left / op.scale)
            inverse = op.distance(value[large]) * length * left / slope
            error[large] = np.minimum(error[large], inverse)
        errors[block] = rounding + error
    sizes.free()
    if op.damped:
        slopes = np.maximum(slopes, np.minimum(least, 1 / np.sqrt(errors)))
    return Eigenpairs(values, vectors, forces, residuals, conditions, slopes, errors)


def residual(
    op: ShiftInvert, values: NDArray[Any], x: NDArray[Any], f: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """P(lambda) [x; f], its derivative (2 lambda M + D) x, M x undamped, and M x."""
    inertia = times(op.matrices.mass, x)
    defect = internal_forces(op.matrices, x, f) + op.square(values) * inertia
    if op.damping is None:
        return defect, inertia, inertia
    drag = op.damping.times(x)
    return defect + values * drag, 2 * values * inertia + drag, inertia


def _slopes(op: ShiftInvert, subspace: InvariantSubspace, duals: Complexes) -> Floats:
    """Norms of the second halves of dual vectors of the companion form (s), of unit vectors."""
    rows = len(subspace.basis) // 2
    second, comm = np.asfortranarray(subspace.basis[rows:]), op.matrices.stiffness.comm
    gram = np.empty((subspace.size,) * 2)
    for block in column_blocks(subspace.size):
        gram[:, block] = all_inner(second, image_of(op.matrices.mass, second[:, block]), comm)
    squares = np.einsum("ij,ij->j", duals.conj(), gram @ duals).real
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / op.scale)


def _blocks(values: Complexes, vectors: Complexes) -> Iterator[tuple[Ints, NDArray[np.inexact]]]:
    """Numbers of eigenvalues with their vectors, real ones in real numbers."""
    real = values.imag == 0
    for chosen, part in ((real, np.real), (~real, np.asarray)):
        numbers = np.flatnonzero(chosen)
        for columns in column_blocks(len(numbers)):
            block = numbers[columns]
            yield block, np.asfortranarray(part(vectors)[:, block])
