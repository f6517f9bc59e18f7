"""Eigenpairs of an invariant subspace, with residuals, backward errors and condition numbers.

With a left vector y, y^H (2 lambda M + D) x = 1, a backward error e of lambda^2 moves an eigenvalue
by || y ||_M e, and by at most sqrt(e) where the two eigenvalues of a mode meet. Left vectors are
those of the invariant subspace, unless they are computed separately, with norms of at least
1 / || (2 lambda M + D) x ||. Without damping the eigenvalue is kappa = -lambda^2, and || y ||_M its
condition number.

The backward error is about the norm of the residual r in M^-1, or that of the inverse problem,
which was the one solved: without damping

    abs(kappa - sigma) || (K - sigma M)^-1 r ||_M.

The smaller of the two is taken, plus the rounding of the entries, u abs(x)^T abs(P) abs(x).

One step of inverse iteration with the transposed matrix estimates the part of the left vectors
outside the subspace of right vectors. Where it is large, or eigenvalues are ill-conditioned, the
left vectors are computed. The error of lambda is then, for any scaling of unknowns and equations,

    e / abs(y^H (2 lambda M + D) x),    e = abs(y)^T (abs(r) + u abs(P) abs(x)),

and the largest difference of left and right eigenvalues counts as a backward error of all of them.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.block_products import all_inner, column_blocks, columns_inner, norms, times
from cea.eigen.matching import DEGENERATE, assign, connected, group
from cea.eigen.pencil import Sizes, internal_forces
from cea.eigen.shift_invert import MARGIN, ShiftInvert
from cea.eigen.spectrum import SLOW
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError
from cea.matrices import destroy

_SMALL = 1e-8
"""Backward error relative to the eigenvalue above which a solve sharpens its estimate."""
_LUMPED = 4.0
"""Approximate upper bound of the norm in M^-1 relative to that in diag(M)^-1."""
SAME = 1e-4
"""Relative distance above which a left and a right eigenvalue are treated as different."""
_ILL = 1e2
"""Condition number above which left vectors are computed."""
_PLAIN, _COLUMNS = 30.0, 4
"""Norm of the part of left vectors outside the subspace above which they are computed, and number
of random combinations by which it is estimated."""
_ROUGH = 1e-11
"""Residual of a damped eigenpair above which it exceeds rounding, and left vectors are computed."""
_UNKNOWN = 1e300
"""Finite number in place of an infinite slope."""


@dataclass(frozen=True)
class Eigenpairs:
    """Eigenpairs of a window and guard eigenpairs outside."""

    values: Complexes  # kappa (1/s^2), or with damping or rotation lambda (1/s), shape (n,)
    vectors: Complexes  # eigenvectors with x^H M x = 1, rows of this rank, shape (n_local, n)
    forces: Complexes  # multipliers, those of contacts first, shape (of this rank, n)
    residuals: Floats  # as in :class:`cea.eigen.spectrum.Spectrum`
    conditions: Floats  # condition numbers of the values within the invariant subspace
    # error of a value per backward error: the condition number, with damping norm(y)_M (s)
    slopes: Floats
    # backward errors of lambda^2 (1/s^2): of the residual, and of rounding the matrices
    errors: Floats

    @property
    def uncertainties(self) -> Floats:
        """Errors of the values, shape (n,)."""
        return self.errors * self.slopes


def error_estimates(op: ShiftInvert, subspace: InvariantSubspace) -> Eigenpairs:
    """Return normalised eigenpairs of an invariant subspace with their errors.

    With contact forces as unknowns, one step of inverse iteration yields the forces, and
    displacements that satisfy the contact conditions. With damping, conjugates with Im lambda < 0
    are omitted except next to the real axis. The shift of ``op`` should be near the eigenvalues.
    """
    matrices, comm = op.matrices, op.matrices.stiffness.comm
    values, vectors = subspace.eigenpairs(matrices.stiffness.getLocalSize()[0])
    duals = subspace.duals()
    if op.damped:
        kept = np.flatnonzero(values.imag >= -MARGIN * op.scale)
        values, vectors, duals = values[kept], vectors[:, kept], duals[:, kept]
        # Left vectors are scaled by lambda, which may be exactly zero.
        values = np.where(values == 0, 1j * np.finfo(float).eps * op.scale, values)
    conditions = np.maximum(np.linalg.norm(duals, axis=0), 1.0)
    slopes = _slopes(op, subspace, duals) if op.damped else conditions.copy()
    values, n = values.copy(), len(values)
    forces = np.empty((op.factors.multipliers, n), dtype=complex)
    lengths, residuals, errors, least = np.empty((4, n))
    sizes, diagonal = Sizes(matrices), matrices.mass.getDiagonal()
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
        if op.symmetric:  # the error of the Rayleigh quotient is the square of the vector's
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
        if len(large):  # these solves cost as much as all the rest
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
    """Return P(lambda) [x; f], its derivative (2 lambda M + D) x (undamped: M x), and M x."""
    inertia = times(op.matrices.mass, x)
    defect = internal_forces(op.matrices, x, f) + op.square(values) * inertia
    if not op.damped:
        return defect, inertia, inertia
    drag = op.matrices.drag(x)
    return defect + values * drag, 2 * values * inertia + drag, inertia


def _slopes(op: ShiftInvert, subspace: InvariantSubspace, duals: Complexes) -> Floats:
    """Return the M-norms of the second halves of dual vectors of the companion form (s)."""
    rows = len(subspace.basis) // 2
    second, comm = np.asfortranarray(subspace.basis[rows:]), op.matrices.stiffness.comm
    gram = np.empty((subspace.size,) * 2)
    for block in column_blocks(subspace.size):
        gram[:, block] = all_inner(second, times(op.matrices.mass, second[:, block]), comm)
    squares = np.einsum("ij,ij->j", duals.conj(), gram @ duals).real
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / op.scale)


def _blocks(values: Complexes, vectors: Complexes) -> Iterator[tuple[Ints, NDArray[np.inexact]]]:
    """Yield blocks of indices with their eigenvectors, as real arrays for real eigenvalues."""
    real = values.imag == 0
    for chosen, part in ((real, np.real), (~real, np.asarray)):
        numbers = np.flatnonzero(chosen)
        for columns in column_blocks(len(numbers)):
            block = numbers[columns]
            yield block, np.asfortranarray(part(vectors)[:, block])


@dataclass(frozen=True)
class LeftVectors:
    """Left eigenvectors y with y_i^H M x_j = delta_ij, the rows of this rank.

    With damping or rotation y_i^H ((lambda_i + lambda_j) M + D) x_j = 2 lambda_i delta_ij.
    ``forces`` are their multipliers.
    """

    vectors: Complexes
    forces: Complexes

    def __getitem__(self, modes: Any) -> "LeftVectors":
        return LeftVectors(self.vectors[:, modes], self.forces[:, modes])


def needs_left_vectors(op: ShiftInvert, subspace: InvariantSubspace, pairs: Eigenpairs) -> bool:
    """Whether errors cannot be estimated without computing left vectors; collective."""
    if op.symmetric or not len(pairs.values):
        return False
    rough = op.damped and pairs.residuals.max() > _ROUGH
    if subspace.graded or rough or pairs.conditions.max() > _ILL:
        return True
    mixed = np.random.default_rng(3).standard_normal((subspace.size, _COLUMNS))
    # A step of inverse iteration leaves mere rounding of vectors far from the shift.
    far = np.abs(np.diag(subspace.projected) - op.shift) / abs(op.shift)
    mixed /= np.maximum(1.0, far)[:, None]
    moved = subspace.projected.T @ mixed - op.shift * mixed
    rest = np.asfortranarray(op.left_out(subspace.basis, mixed, moved))
    squares = columns_inner(rest, times(op.matrices.mass, rest), op.matrices.mass.comm)
    return bool(np.sqrt(squares.sum() / _COLUMNS) > _PLAIN)


def left_vectors_of(
    op: ShiftInvert, pairs: Eigenpairs, left_values: Complexes, left: Complexes
) -> LeftVectors:
    """Return left vectors in the order of the eigenpairs; a dual basis for close eigenvalues.

    ``left_values`` and ``left`` are eigenvalues and vectors of the transposed pencil; the vectors
    are conjugates of left ones. ConvergenceError when an eigenvalue has no left vector.
    """
    values, x = pairs.values, pairs.vectors
    slow = SLOW * op.scale if op.damped else (SLOW * op.scale) ** 2  # for rigid body modes
    scale = np.abs(values).max(initial=slow)
    rows, columns = assign(np.abs(values[:, None] - left_values) / scale, SAME)
    if len(rows) < len(values):
        raise ConvergenceError(
            f"no left vector was found for {len(values) - len(rows)} of {len(values)} eigenvalues",
            best=left_values,
        )
    y = left[:, columns].conj()
    for members in group(values, np.sqrt(DEGENERATE), 0.0 if op.damped else slow):
        overlap, target = op.pairing(values[members], y[:, members], x[:, members])
        y[:, members] = y[:, members] @ np.linalg.pinv(overlap).conj().T * target.conj()
    g = np.empty((0, len(values)), dtype=complex)
    if op.matrices.multipliers is not None:
        y, g = op.inverse_step(values, y.conj(), transposed=True)
        y, g = y.conj(), g.conj()
    return LeftVectors(y, g)


def two_sided(
    op: ShiftInvert,
    subspace: InvariantSubspace,
    pairs: Eigenpairs,
    left: tuple[Complexes, LeftVectors] | None,
) -> Eigenpairs:
    """Return the eigenpairs with errors estimated by their left vectors.

    ``left`` holds all eigenvalues of the transposed pencil, and the left vectors of the pairs.
    Without it all errors are infinite.
    """
    values = pairs.values
    if left is None:
        unknown = np.full(len(values), np.inf)
        return replace(pairs, errors=unknown)
    errors, slopes = _two_sided_errors(op, pairs, left[1])
    slopes = np.nan_to_num(slopes, nan=0.0, posinf=_UNKNOWN)
    slopes = np.maximum(slopes, np.finfo(float).tiny if subspace.graded else pairs.slopes)
    # Norms of a balanced pencil are only meaningful in the scaled unknowns of the subspace.
    measure = pairs.conditions if subspace.graded else slopes
    far = np.maximum(1.0, np.abs(op.square(values)) / op.scale**2)
    distances = np.abs(values[:, None] - left[0])
    rows, columns = assign(distances)
    apart = distances[rows, columns] / (measure * far)[rows]  # backward errors
    explained = far * float(apart.max(initial=0.0))
    moved = explained * measure
    if op.damped and not subspace.graded:
        moved = np.minimum(moved, np.sqrt(explained))
    errors = np.maximum(errors, moved)
    for members in connected(np.abs(values[:, None] - values) <= np.add.outer(errors, errors)):
        errors[members] *= len(members)  # a union of overlapping discs holds their eigenvalues
    conditions = pairs.conditions if op.damped else slopes
    return replace(pairs, slopes=slopes, conditions=conditions, errors=errors / slopes)


def _two_sided_errors(
    op: ShiftInvert, pairs: Eigenpairs, left: LeftVectors
) -> tuple[Floats, Floats]:
    """Return errors of eigenvalues and norms of left vectors, y^H (2 lambda M + D) x = 1, (n,)."""
    matrices, comm, n = op.matrices, op.matrices.stiffness.comm, len(pairs.values)
    errors, slopes = np.empty((2, n))
    sizes = Sizes(matrices)
    for block in column_blocks(n):
        value, x, y = pairs.values[block], pairs.vectors[:, block], left.vectors[:, block]
        f, square = pairs.forces[:, block], op.square(pairs.values[block])
        defect, derivative, inertia = residual(op, value, x, f)
        entries = sizes.forces(x, 2 * np.abs(f), np.sqrt(np.abs(square)))
        parts = np.abs(defect) + np.finfo(float).eps * entries
        work = op.comm.tompi4py().allreduce(np.einsum("ij,ij->j", np.abs(y), parts))
        squares = columns_inner(y, times(matrices.mass, y), comm).real
        turned = np.abs(columns_inner(y, derivative, comm))
        with np.errstate(divide="ignore", invalid="ignore"):
            errors[block] = work / turned
            if op.damped:
                root = np.sqrt(work / np.abs(columns_inner(y, inertia, comm)))
                errors[block] = np.fmin(errors[block], root)
            slopes[block] = np.sqrt(np.maximum(squares, 0.0)) / turned
    sizes.free()
    errors[np.isnan(errors)] = np.inf
    return errors, slopes
