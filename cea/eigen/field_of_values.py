"""Where friction can move eigenvalues, and how fast modes may grow: bounds by fields of values.

With x^H M x = 1 an eigenvalue is kappa = x^H K x. Where H + X M, H = (K + K^T) / 2, has no negative
eigenvalue none has Re kappa < -X (Bendixson). With N = (K - K^T) / 2 and the smallest t for which
abs(x^H N x) <= t x^H (H + X M) x holds for every x, kappa lies in the cone

    abs(Im kappa) <= t (Re kappa + X).

Multipliers f enter H through M = (J + L) / 2 and D = (J - L) / 2,

    H = K_b + M^T C^-1 M - D^T C^-1 D,

as two sets of unknowns; where friction acts without compliance there is no bound. Of each set
those that its closures leave open have rows of their own, and a negative eigenvalue.

With damping let h + i n be x^H K x and c + i y be x^H (C + Y) x. An eigenvalue lambda = g + i w
obeys x^H P(lambda) x = 0, of which the real part, as it is and divided by lambda, is

    g^2 - w^2 + g c - w y + h = 0,       g (abs(lambda)^2 + h) + c abs(lambda)^2 + w n = 0.

The first: with y the row sums of abs(Y), no eigenvalue with abs(w) <= omega grows at the rate g
where H + (g^2 - omega^2) M + g C - omega diag(y) has no negative eigenvalue, nor faster if
2 g M + C has none. The second: where h >= -X, c >= -d, and abs(n) <= t (h + X),

    g <= max(t omega + 2 d, sqrt(2 X)).

H and C are symmetric parts, Y the skew one. Pieces of C of low rank are positive semidefinite: both
hold for the sum where they hold without them.
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
    antisymmetrised,
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
"""What takes the rows of this rank of a block of vectors to those of another."""

_COLUMNS, _STEPS = 8, 4
"""Size of the Krylov space from which the slope of the cone is estimated: blocks, and steps."""
_SAFETY = 1.5
"""Factor on that estimate, which comes from below and has mostly converged."""
_DEPENDENT = 1e-12
"""Square of a new direction, relative to the largest, below which it is not one."""
_DEPTH = 0.02
"""X of the cone of damped pencils relative to omega^2."""
_NEGATIVE = (1e-6, 1e-2, 0.1)
"""Negative damping d relative to omega that is tried: none but for rounding, and some."""


def field_of_values(matrices: Matrices, depth: float, *, cone: bool = False) -> float | None:
    """A slope with abs(Im kappa) <= slope (Re kappa + X) where Re kappa >= -X, else None.

    One factorisation at the depth X (1/s^2) says so; ConvergenceError when it fails. The slope is
    told where a cone is asked for; it stays infinite where forces are tied or dependent.
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
    """Rate (1/s) that no eigenvalue with abs(Im lambda) <= end exceeds by the cone, or infinity."""
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
    """Whether no eigenvalue with abs(Im lambda) <= end (1/s) can grow at a rate (1/s) or faster."""
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
    """Symmetric part of C + Y, a new matrix; None without."""
    parts = [(1.0, each) for each in (matrices.damping, matrices.gyroscopic) if each is not None]
    return symmetrised(scaled_total(parts)) if parts else None


def _positive(matrices: Matrices, damping: Mat, rate: float) -> bool:
    """Whether C + rate M has no negative eigenvalue."""
    return inertia(scaled_total([(rate, matrices.mass), (1.0, damping)]))[0] == 0


def _skew_row_sums(matrix: Mat) -> Mat:
    """Diagonal matrix of the row sums of the absolute values of the skew part, PETSc AIJ."""
    skew = antisymmetrised(matrix.copy())
    sums = np.asarray(abs(local_part(skew)).sum(axis=1)).ravel()
    (local, _), columns = skew.getSizes()
    own = np.arange(*skew.getOwnershipRange())
    diagonal = csr_array((sums, own, np.arange(local + 1)), (local, columns[1]))
    destroy(skew)
    return distributed(diagonal, columns, matrix.comm)


def _definite(hermitian: Mat, forces: Multipliers | None) -> Mumps | None:
    """Factors of a matrix in the place of H + X M with contact forces, which is freed with them.

    None where it has a negative eigenvalue, or that has no bound.
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
    """Estimate from below of the largest abs(x^H N x) / x^H (H + X M) x.

    The factors are those of H + X M. Infinite where the compliance of forces is singular.
    """
    rows, comm = matrices.stiffness.getLocalSize()[0], matrices.stiffness.comm
    forces = matrices.multipliers
    compliance: Mumps | None = None
    if forces is not None:
        try:
            compliance = Mumps(forces.compliance.copy(), symmetric=True)
        except ConvergenceError:  # what shows nothing must not end a run
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
    """Estimate from below of max abs(x^H N x) / x^H H x by block Krylov.

    ``solve`` and ``skew`` are H^-1 and N times a block. The vectors are orthonormal in H, with
    which H^-1 N is skew.
    """
    most = _COLUMNS * _STEPS
    basis, images, skews = (np.empty((rows, most), order="F") for _ in range(3))
    start = np.random.default_rng([0, comm.rank]).standard_normal((rows, _COLUMNS))
    load, size = skew(start), 0
    for _ in range(_STEPS):
        block, image = np.asfortranarray(solve(load)), load.copy(order="F")
        for _ in range(2):  # what rounding leaves of the first projection goes with the second
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
    """H + depth M, H = (K + K^T) / 2, and other pieces on the displacements, PETSc AIJ."""
    parts = [(1.0, matrices.stiffness), (depth, matrices.mass), *more]
    if matrices.unsymmetric is None:
        return scaled_total(parts)
    friction = symmetrised(matrices.unsymmetric.copy())
    total = scaled_total([*parts, (1.0, friction)])
    destroy(friction)
    return total


def _two_sets(forces: Multipliers) -> Multipliers | None:
    """Forces of contacts as two sets of unknowns, of M and of D; None where there is no bound."""
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
