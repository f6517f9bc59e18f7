"""Bounds of eigenvalues and growth rates by the field of values.

With x^H M x = 1 an eigenvalue is kappa = x^H K x. If H + X M, H = (K + K^T) / 2, has no negative
eigenvalue, no kappa has Re kappa < -X (Bendixson). With N = (K - K^T) / 2 and the smallest t for
which abs(x^H N x) <= t x^H (H + X M) x holds for every x, kappa lies in the cone

    abs(Im kappa) <= t (Re kappa + X).

Multipliers f enter H through M = (J + L) / 2 and D = (J - L) / 2,

    H = K_b + M^T C^-1 M - D^T C^-1 D,

as two sets of unknowns; there is no bound where friction acts without compliance. For each
dependent closure each set has an additional row; the two add one negative eigenvalue.

With damping let h + i n be x^H K x and c + i y be x^H (C + Y) x. An eigenvalue lambda = g + i w
satisfies x^H P(lambda) x = 0. The real parts of this equation and of it divided by lambda are

    g^2 - w^2 + g c - w y + h = 0,       g (abs(lambda)^2 + h) + c abs(lambda)^2 + w n = 0.

By the first, with y the row sums of abs(Y), no eigenvalue with abs(w) <= omega has the growth rate
g if H + (g^2 - omega^2) M + g C - omega diag(y) has no negative eigenvalue, nor a larger one if
2 g M + C has none. By the second, if h >= -X, c >= -d, and abs(n) <= t (h + X),

    g <= max(t omega + 2 d, sqrt(2 X)).

H and C are symmetric parts, Y is the skew part. Low-rank terms of C are positive semidefinite:
bounds that hold without them hold for the sum.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.eigen.block_products import all_inner, combined, times, transposed_times
from cea.eigen.multipliers import Multipliers
from cea.eigen.mumps import Mumps, inertia
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import bordered, count_below
from cea.errors import ConvergenceError
from cea.matrices import (
    block_diagonal,
    destroy,
    distributed,
    local_part,
    one_below_the_other,
    scaled_total,
    symmetrised,
)
from cea.petsc import MPI, Mat

type Operation = Callable[[Floats], Floats]
"""Linear operator on a block of vectors, the rows of this rank."""

_COLUMNS, _STEPS = 8, 4
"""Columns of a block and steps of the Krylov space that estimates the slope of the cone."""
_SAFETY = 1.5
"""Safety factor on that estimate, which is a lower bound."""
_DEPENDENT = 1e-12
"""Squared norm of a new direction relative to the largest below which it is dropped."""
_DEPTH = 0.02
"""X of the cone of damped pencils relative to omega^2."""
_NEGATIVE = (1e-6, 1e-2, 0.1)
"""Bounds d of negative damping relative to omega, tried in turn; the first allows for rounding."""


def field_of_values(matrices: Matrices, depth: float, *, cone: bool = False) -> float | None:
    """Return the slope of a cone abs(Im kappa) <= slope (Re kappa + X) that holds all kappa.

    None where one factorisation at the depth X (1/s^2) does not show Re kappa >= -X. Without
    ``cone``, and for tied or dependent forces, the slope is infinite (without friction zero).
    ConvergenceError when the factorisation fails.
    """
    if matrices.symmetric:
        return None if count_below(matrices, -depth) else 0.0
    slope, forces = np.inf, matrices.multipliers
    factors = _definite(_hermitian_part(matrices, depth), forces)
    if factors is None:
        return None
    loose = forces is None or not (forces.tied or forces.dependent)
    if cone and loose and not factors.inertia()[1]:
        slope = _SAFETY * _largest_slope(factors, matrices)
    factors.free()
    return slope


def largest_growth(matrices: Matrices, end: float) -> float:
    """Return an upper bound (1/s) of Re lambda for abs(Im lambda) <= end by the cone, or inf."""
    depth = _DEPTH * end**2
    slope = field_of_values(matrices, depth, cone=True)
    if slope is None or not np.isfinite(slope):
        return np.inf
    damping, least = _symmetric_damping(matrices), 0.0
    if damping is not None:
        tried = (part * end for part in _NEGATIVE)
        least = next((d for d in tried if _positive(matrices, damping, d)), np.inf)
        destroy(damping)
    return max(slope * end + 2 * least, float(np.sqrt(2 * depth)))


def bounded_growth(matrices: Matrices, growth: float, end: float) -> bool:
    """Whether no eigenvalue with abs(Im lambda) <= end (1/s) has Re lambda >= growth (1/s)."""
    damping, parts = _symmetric_damping(matrices), []
    if damping is not None:
        if not _positive(matrices, damping, 2 * growth):
            destroy(damping)
            return False
        parts.append((growth, damping))
    if matrices.gyroscopic is not None:
        parts.append((-end, _skew_row_sums(matrices.gyroscopic)))
    hermitian = _hermitian_part(matrices, growth**2 - end**2, parts)
    destroy(*(matrix for _, matrix in parts))
    factors = _definite(hermitian, matrices.multipliers)
    if factors is None:
        return False
    factors.free()
    return True


def _symmetric_damping(matrices: Matrices) -> Mat | None:
    """Return the symmetric part of C + Y as a new matrix; None without damping and rotation."""
    parts = [(1.0, each) for each in (matrices.damping, matrices.gyroscopic) if each is not None]
    return symmetrised(scaled_total(parts)) if parts else None


def _positive(matrices: Matrices, damping: Mat, rate: float) -> bool:
    """Whether C + rate M has no negative eigenvalue."""
    return inertia(scaled_total([(rate, matrices.mass), (1.0, damping)]))[0] == 0


def _skew_row_sums(matrix: Mat) -> Mat:
    """Return the diagonal matrix of the row sums of the absolute skew part, PETSc AIJ."""
    skew = symmetrised(matrix.copy(), -1.0)
    sums = np.asarray(abs(local_part(skew)).sum(axis=1)).ravel()
    (local, _), columns = skew.getSizes()
    own = np.arange(*skew.getOwnershipRange())
    diagonal = csr_array((sums, own, np.arange(local + 1)), (local, columns[1]))
    destroy(skew)
    return distributed(diagonal, columns, matrix.comm)


def _definite(hermitian: Mat, forces: Multipliers | None) -> Mumps | None:
    """Return the factors of H + X M with contact forces; they own the matrix.

    None where H + X M has a negative eigenvalue, or contact forces have no bound.
    """
    expected = 0
    if forces is not None:
        sets = _two_sets(forces)
        if sets is None:
            destroy(hermitian)
            return None
        hermitian = bordered(hermitian, sets, symmetric=True)
        sets.free()
        expected = forces.size + forces.dependent
    factors = Mumps(hermitian, symmetric=True, inertia=True)
    if factors.inertia()[0] == expected:
        return factors
    factors.free()
    return None


def _largest_slope(factors: Mumps, matrices: Matrices) -> float:
    """Return a lower estimate of the largest abs(x^H N x) / x^H (H + X M) x.

    ``factors`` are those of H + X M. Infinite where the compliance of forces is singular.
    """
    rows, comm = matrices.stiffness.getLocalSize()[0], matrices.stiffness.comm
    forces = matrices.multipliers
    compliance: Mumps | None = None
    if forces is not None:
        try:
            compliance = Mumps(forces.compliance.copy(), symmetric=True)
        except ConvergenceError:  # without this bound the run continues
            return np.inf

    def unsymmetric(x: Floats, *, transposed: bool = False) -> Floats:
        force = np.zeros_like(x)
        if matrices.unsymmetric is not None:
            force += (transposed_times if transposed else times)(matrices.unsymmetric, x)
        if forces is not None and compliance is not None:
            both = (forces.reaction, forces.closure)
            J, L = both if transposed else both[::-1]
            force += transposed_times(L, compliance.solve_block(times(J, x)))
        return force

    def skew(x: Floats) -> Floats:
        return np.asfortranarray(0.5 * (unsymmetric(x) - unsymmetric(x, transposed=True)))

    def solve(b: Floats) -> Floats:
        return factors.solve_block(b)[:rows]

    slope = _largest_quotient(solve, skew, rows, comm)
    if compliance is not None:
        compliance.free()
    return slope


def _largest_quotient(solve: Operation, skew: Operation, rows: int, comm: Any) -> float:
    """Return a lower estimate of max abs(x^H N x) / x^H H x by a block Krylov method.

    ``solve`` and ``skew`` apply H^-1 and N to a block. The basis is orthonormal in H, in which
    H^-1 N is skew.
    """
    most = _COLUMNS * _STEPS
    basis, images, skews = (np.empty((rows, most), order="F") for _ in range(3))
    start = np.random.default_rng([0, comm.rank]).standard_normal((rows, _COLUMNS))
    load, size = skew(start), 0
    for _ in range(_STEPS):
        block, image = np.asfortranarray(solve(load)), load.copy(order="F")
        for _ in range(2):  # the second projection removes rounding of the first
            part = all_inner(images[:, :size], block, comm)
            block -= basis[:, :size] @ part
            image -= images[:, :size] @ part
        squares, axes = np.linalg.eigh(all_inner(block, image, comm))
        kept = squares > _DEPENDENT * max(squares.max(), np.finfo(float).tiny)
        if not kept.any():
            break
        turn = axes[:, kept] / np.sqrt(squares[kept])
        new = slice(size, size + turn.shape[1])
        size = new.stop
        basis[:, new], images[:, new] = combined(block, turn), combined(image, turn)
        load = skews[:, new] = skew(basis[:, new])
    projected = all_inner(basis[:, :size], skews[:, :size], comm)
    return float(np.linalg.norm(projected, 2)) if size else 0.0


def _hermitian_part(
    matrices: Matrices, depth: float, more: Sequence[tuple[float, Mat]] = ()
) -> Mat:
    """Return H + depth M, H = (K + K^T) / 2, plus further matrices, PETSc AIJ."""
    parts = [(1.0, matrices.stiffness), (depth, matrices.mass), *more]
    if matrices.unsymmetric is None:
        return scaled_total(parts)
    friction = symmetrised(matrices.unsymmetric.copy())
    total = scaled_total([*parts, (1.0, friction)])
    destroy(friction)
    return total


def _two_sets(forces: Multipliers) -> Multipliers | None:
    """Return contact forces as two sets of unknowns, of M and D; None where there is no bound."""
    mean, half = (
        scaled_total([(0.5, forces.closure), (sign, forces.reaction)]) for sign in (0.5, -0.5)
    )
    diagonal = forces.compliance.getDiagonal()
    tied = diagonal.array_r == 0
    friction = local_part(half)
    friction.eliminate_zeros()
    both = bool(((np.diff(friction.indptr) > 0) & tied).any())
    sets = None
    if not forces.closure.comm.tompi4py().allreduce(both, MPI.LOR):
        other = forces.compliance.copy()
        diagonal.array[:] = np.where(tied, 1.0, diagonal.array_r)
        other.setDiagonal(diagonal)
        other.assemble()
        other.scale(-1.0)
        closure, border = one_below_the_other([mean, half]), None
        compliance = block_diagonal([forces.compliance, other]).convert("aij")
        if forces.border is not None:
            border = block_diagonal([forces.border, forces.border]).convert("aij")
        sets = Multipliers(closure, closure, compliance, border, 0)
        destroy(other)
    destroy(mean, half, diagonal)
    return sets
