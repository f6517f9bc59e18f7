"""Where friction can move eigenvalues: bounds of the field of values of a pencil.

With x^H M x = 1 an eigenvalue is kappa = x^H K x. Its real part is bounded by H = (K + K^T) / 2
(Bendixson): where H + X M has no negative eigenvalue, none has Re kappa < -X. Its imaginary part is
what N = (K - K^T) / 2 makes: with the smallest t for which abs(x^H N x) <= t x^H (H + X M) x holds
for every x, kappa lies in the cone

    abs(Im kappa) <= t (Re kappa + X).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.blocks import all_inner, combined, image_of, subtract
from cea.eigen.eliminated_forces import EliminatedForces, mean_and_half
from cea.eigen.multipliers import Multipliers, with_circulatory
from cea.eigen.mumps import Mumps
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import balanced, count_below, force_scale, nested
from cea.errors import ConvergenceError
from cea.matrices import (
    antisymmetrised,
    destroy,
    largest_row,
    local_part,
    scaled_total,
    symmetrised,
)
from cea.petsc import MPI, PETSc

type Operation = Callable[[Floats], Floats]
"""What takes the rows of this rank of a block of vectors to those of another."""

_COLUMNS, _STEPS = 8, 4
"""Size of the Krylov space from which the slope of the cone is estimated: blocks, and steps."""
SAFETY = 1.5
"""Factor on that estimate, which comes from below and has mostly converged."""
_DEPENDENT = 1e-12
"""Square of a new direction, relative to the largest, below which it is not one."""


@dataclass(frozen=True)
class FieldOfValues:
    """Where x^H K x / x^H M x lies, for all x, and with it every eigenvalue.

    Parameters
    ----------
    depth
        X (1/s^2).
    bounded
        Whether Re kappa >= -X.
    slope
        Then abs(Im kappa) <= slope (Re kappa + X) too; infinite where that is not known.
    """

    depth: float
    bounded: bool
    slope: float = np.inf


def field_of_values(matrices: Matrices, depth: float, *, cone: bool = False) -> FieldOfValues:
    """What one factorisation says of it.

    Contact forces f that are unknowns enter H through M = (J + L) / 2 and D = (J - L) / 2,

        H = K_b + M^T C^-1 M - D^T C^-1 D,

    as two sets of unknowns; where friction acts without compliance there is no bound. Of each set
    those that its closures leave open have rows of their own, and a negative eigenvalue. N has
    M^T C^-1 D - D^T C^-1 M of them (:mod:`cea.eigen.eliminated_forces`).

    Circulatory pieces are not in the factors. Their skew part is in N; with the part s < 1 of
    H + X M that a mesh makes of their symmetric one, H + X M is no less than 1 - s of what it is
    without, and the slope is greater by 1 / (1 - s).

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    depth
        X (1/s^2).
    cone
        Whether the slope is wanted too, without which there is no bound with circulatory pieces; it
        stays infinite where forces are tied, or depend on each other.

    Raises
    ------
    ConvergenceError
        When the factorisation fails.
    """
    if matrices.symmetric:
        return FieldOfValues(depth, count_below(matrices, -depth) == 0, 0.0)
    factors, bounded = factorised_hermitian(hermitian_part(matrices, depth), matrices)
    slope, share = np.inf, 0.0 if matrices.circulatory is None else np.inf
    if factors is None:
        return FieldOfValues(depth, bounded=False)
    if cone and bounded and has_cone(matrices) and not factors.null_pivots():
        slope, share = (SAFETY * each for each in _quotients(factors, matrices, depth))
    factors.free()
    if not share < 1:
        return FieldOfValues(depth, bounded=False)
    return FieldOfValues(depth, bounded, slope / (1 - share))


def has_cone(matrices: Matrices) -> bool:
    """Whether the slope of its cone can be told: no contact force is tied or depends on others."""
    forces = matrices.multipliers
    return forces is None or EliminatedForces.possible(forces)


def factorised_hermitian(
    hermitian: Any, matrices: Matrices, *, circulatory: bool = False
) -> tuple[Mumps | None, bool]:
    """A matrix in the place of H + X M, with the contact forces, factorised.

    Parameters
    ----------
    hermitian
        Symmetric, PETSc AIJ, on the displacements; it is freed, or with the factors.
    matrices
        The pencil, whose contact forces are taken.
    circulatory
        Whether its circulatory pieces are taken too, as such forces.

    Returns
    -------
    tuple
        Its factors, and whether it has no negative eigenvalue; none where that has no bound.

    Raises
    ------
    ConvergenceError
        When the factorisation fails.
    """
    expected, forces = 0, matrices.multipliers
    if circulatory and matrices.circulatory is not None:
        forces = with_circulatory(matrices.multipliers, matrices.circulatory)
    if forces is not None:
        bordered = _with_forces(hermitian, forces)
        destroy(hermitian)
        expected = forces.size + forces.dependent
        if forces is not matrices.multipliers:
            forces.free()
        if bordered is None:
            return None, False
        hermitian = bordered
    factors = Mumps(hermitian, symmetric=True, inertia=True)
    return factors, factors.negative_eigenvalues() == expected


def _quotients(factors: Mumps, matrices: Matrices, depth: float) -> tuple[float, float]:
    """Estimates from below of the largest abs(x^H N x) / x^H (H + X M) x and of another quotient.

    That is the same with the symmetric part of circulatory pieces, which H is without, in the
    place of N. The factors are those of H + X M.
    """
    rows, comm = matrices.stiffness.getLocalSize()[0], matrices.stiffness.comm
    forces: EliminatedForces | None = None
    of_bodies = factors.matrix
    if matrices.multipliers is not None:
        try:
            forces = EliminatedForces(matrices.multipliers)
        except ConvergenceError:  # what shows nothing must not end a run
            return np.inf, 0.0 if matrices.circulatory is None else np.inf
        of_bodies = hermitian_part(matrices, depth)
    skew = None
    if matrices.unsymmetric is not None:
        skew = antisymmetrised(matrices.unsymmetric.copy())
    circulatory = matrices.circulatory
    every = factors.matrix.getLocalSize()[0]

    def solve(b: Floats) -> Floats:
        if forces is None:
            return factors.solve_block(b)
        whole = np.zeros((every, b.shape[1]), order="F")
        whole[:rows] = b
        return factors.solve_block(whole)[:rows]

    def image(x: Floats) -> Floats:
        own = image_of(of_bodies, x)
        return own if forces is None else np.asfortranarray(own + forces.symmetric(x))

    def turned(x: Floats) -> Floats:
        parts = [] if skew is None else [image_of(skew, x)]
        if forces is not None:
            parts.append(forces.skew(x))
        if circulatory is not None:
            parts.append(circulatory.skew(x))
        return np.asfortranarray(sum(parts[1:], parts[0]))

    try:
        slope = largest_quotient(solve, image, turned, rows, comm)
        if circulatory is None:
            return slope, 0.0
        return slope, largest_quotient(solve, image, circulatory.symmetric, rows, comm)
    finally:
        if forces is not None:
            forces.free()
            destroy(of_bodies)
        if skew is not None:
            destroy(skew)


def largest_quotient(
    solve: Operation,
    image: Operation,
    skew: Operation,
    rows: int,
    comm: Any,
    steps: int = _STEPS,
) -> float:
    """Estimate from below of max abs(x^H N x) / x^H H x, N skew or symmetric, by block Krylov.

    Orthonormal in H, with which H^-1 N is skew, or symmetric.

    Parameters
    ----------
    solve, image, skew
        H^-1, which need not be exact, H and N times a block of vectors, the rows of this rank.
    rows
        Rows of this rank.
    comm
        Communicator (petsc4py).
    steps
        Steps of block Krylov, the more the less the extreme quotients stand out.
    """
    most = _COLUMNS * steps
    basis, images, skews = (np.empty((rows, most), order="F") for _ in range(3))
    start = np.random.default_rng([0, comm.rank]).standard_normal((rows, _COLUMNS))
    load, size = skew(start), 0
    for _ in range(steps):
        block = solve(load)
        for _ in range(2):  # what rounding leaves of the first projection goes with the second
            subtract(block, basis[:, :size], all_inner(images[:, :size], block, comm))
        of_block = image(block)
        squares, axes = np.linalg.eigh(all_inner(block, of_block, comm))
        kept = squares > _DEPENDENT * max(squares.max(), np.finfo(float).tiny)
        if not kept.any():
            break
        turn = axes[:, kept] / np.sqrt(squares[kept])
        fresh = slice(size, size + turn.shape[1])
        size = fresh.stop
        basis[:, fresh], images[:, fresh] = combined(block, turn), combined(of_block, turn)
        load = skews[:, fresh] = skew(basis[:, fresh])
    projected = all_inner(basis[:, :size], skews[:, :size], comm)
    return float(np.linalg.norm(projected, 2)) if size else 0.0


def hermitian_part(matrices: Matrices, depth: float) -> Any:
    """H + depth M on the displacements, H = (K + K^T) / 2, a new PETSc AIJ matrix."""
    parts = [(1.0, matrices.stiffness), (depth, matrices.mass)]
    if matrices.unsymmetric is None:
        return scaled_total(parts)
    friction = symmetrised(matrices.unsymmetric.copy())
    total = scaled_total([*parts, (1.0, friction)])
    destroy(friction)
    return total


def _with_forces(hermitian: Any, forces: Multipliers) -> Any | None:
    """H with the forces of contacts as two sets of unknowns; None where there is no bound."""
    mean, half = mean_and_half(forces)
    scale = force_scale(hermitian, forces)
    mean.diagonalScale(L=scale)
    half.diagonalScale(L=scale)
    compliance = forces.compliance.copy()
    compliance.diagonalScale(L=scale, R=scale)
    diagonal = compliance.getDiagonal()
    tied = diagonal.array_r == 0
    friction = local_part(half)
    friction.eliminate_zeros()
    rubs = np.diff(friction.indptr) > 0
    bordered = None
    if not hermitian.comm.tompi4py().allreduce(bool((rubs & tied).any()), MPI.LOR):
        pushed, pulled = mean.transpose(PETSc.Mat()), half.transpose(PETSc.Mat())
        other = compliance.copy()
        diagonal.array[:] = np.where(tied, 1.0, diagonal.array_r)
        other.setDiagonal(diagonal)
        other.assemble()
        compliance.scale(-1.0)
        blocks = [[hermitian, pushed, pulled], [mean, compliance, None], [half, None, other]]
        made = [pushed, pulled, other]
        if forces.border is not None:
            border = balanced(forces.border, scale, largest_row(mean))
            across = border.transpose(PETSc.Mat())
            blocks = [
                [hermitian, pushed, pulled, None, None],
                [mean, compliance, None, border, None],
                [half, None, other, None, border],
                [None, across, None, None, None],
                [None, None, across, None, None],
            ]
            made += [border, across]
        bordered = nested(blocks)
        destroy(*made)
    destroy(mean, half, scale, compliance, diagonal)
    return bordered
