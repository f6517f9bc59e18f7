"""Which eigenvalues a window may hold, and the discs that cover it.

Modes with 0 <= Im lambda <= omega, of any growth, have kappa = -lambda^2 inside the parabola

    |kappa| + Re kappa <= 2 omega^2,   (Im kappa)^2 <= 4 omega^2 (omega^2 - Re kappa).

Friction opens it to the left: how far is bounded by the field of values (Bendixson),

    Re kappa >= smallest eigenvalue of H x = kappa M x,   H = (K + K^T) / 2,

so that H + X M without negative eigenvalues shows that none has Re kappa below -X. The disc that
touches the parabola at its tip and meets it at Re kappa = -X,

    centre -(X + 3 omega^2) / 2,   radius (X + 5 omega^2) / 2,

holds all of it to the right of there, and no more of the positive axis than the window itself.
"""

from typing import Any

import numpy as np

from cea.eigen.factorisation import Mumps
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import balanced, count_below, force_scale
from cea.matrices import destroy, local_part, scaled_total
from cea.petsc import MPI, PETSc

_TIP = 1.01
"""Tip of the covered parabola relative to omega^2: room between the window and the first mode
beyond it."""


def touching_disc(top: float, depth: float) -> float:
    """Centre of the disc that covers the window to Re kappa = -depth (1/s^2).

    Parameters
    ----------
    top
        omega^2 (1/s^2).
    depth
        X, zero or more (1/s^2).
    """
    return -0.5 * (depth + 3 * _TIP * top)


def distance_within(top: float, centre: float, left: float, right: float) -> float:
    """Largest distance from a centre of points of the parabola with Re kappa from left to right.

    The distance is convex along the parabola: it is largest at an end.
    """
    tip = _TIP * top
    ends = np.array([left, right])
    heights = 4 * tip * np.maximum(tip - ends, 0.0)
    return float(np.sqrt((ends - centre) ** 2 + heights).max())


def bounded_below(matrices: Matrices, depth: float) -> bool:
    """Whether no eigenvalue can have Re kappa < -depth: H + depth M has no negative eigenvalue.

    Contact forces f that are unknowns enter H through M = (J + L) / 2 and D = (J - L) / 2,

        H = K_b + M^T C^-1 M - D^T C^-1 D,

    as two sets of unknowns; where friction acts without compliance there is no bound. Of each set
    those that its closures leave open have rows of their own, and a negative eigenvalue.

    Raises
    ------
    ConvergenceError
        When the factorisation fails.
    """
    if matrices.symmetric:
        return count_below(matrices, -depth) == 0
    hermitian = _hermitian(matrices, depth)
    expected = 0
    if matrices.multipliers is not None:
        bordered = _with_forces(hermitian, matrices)
        destroy(hermitian)
        if bordered is None:
            return False
        hermitian, expected = bordered, matrices.multipliers.size + matrices.multipliers.dependent
    factors = Mumps(hermitian, symmetric=True, inertia=True)
    negative = factors.negative_eigenvalues()
    factors.free()
    return negative == expected


def _hermitian(matrices: Matrices, depth: float) -> Any:
    parts = [(1.0, matrices.stiffness), (depth, matrices.mass)]
    if matrices.unsymmetric is None:
        return scaled_total(parts)
    transpose = matrices.unsymmetric.transpose(PETSc.Mat())
    total = scaled_total([*parts, (0.5, matrices.unsymmetric), (0.5, transpose)])
    destroy(transpose)
    return total


def _with_forces(hermitian: Any, matrices: Matrices) -> Any | None:
    """H with the forces of contacts as two sets of unknowns; None where there is no bound."""
    forces = matrices.multipliers
    assert forces is not None
    mean, half = forces.closure.copy(), forces.closure.copy()
    pattern: Any = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN
    mean.axpy(1.0, forces.reaction, structure=pattern)
    half.axpy(-1.0, forces.reaction, structure=pattern)
    scale = force_scale(hermitian, forces)
    scale.scale(0.5)
    mean.diagonalScale(L=scale)
    half.diagonalScale(L=scale)
    compliance = forces.compliance.copy()
    compliance.diagonalScale(L=scale, R=scale)
    compliance.scale(4.0)
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
            border = balanced(forces.border, scale, mean.norm(PETSc.NormType.INFINITY))
            across = border.transpose(PETSc.Mat())
            blocks = [
                [hermitian, pushed, pulled, None, None],
                [mean, compliance, None, border, None],
                [half, None, other, None, border],
                [None, across, None, None, None],
                [None, None, across, None, None],
            ]
            made += [border, across]
        bordered = PETSc.Mat().createNest(blocks).convert("aij")
        destroy(*made)
    destroy(mean, half, scale, compliance, diagonal)
    return bordered
