"""Errors of eigenvalues, estimated in a richer space without solving an eigenproblem there.

Right and left vectors X, Y of the coarse mesh are prolonged to the richer space and improved by
block inverse iteration (:mod:`cea.nested.block_steps`). To first order one step gives

    d lambda = - (y^H r + s^H e) / y^H (2 lambda M + D) x,

with the residuals r and s of x and y there, and e = -A(sigma)^-1 r. The second term is the
hierarchical estimate weighted by the left residual. The first, y^H r, is the effect of contact
rules and geometry that differ between the meshes (Heuveline & Rannacher, A posteriori error control
for finite element approximations of elliptic eigenvalue problems, 2001). All modes are projected
together, so that modes that nearly coalesce are corrected as a group.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.block_products import times
from cea.eigen.modes import Modes
from cea.eigen.pencil import Matrices
from cea.errors import InputError
from cea.nested.block_steps import Approximation, BlockSteps


@dataclass(frozen=True)
class ErrorEstimate:
    """Eigenvalues of a coarse mesh with their estimated errors.

    Parameters
    ----------
    eigenvalues
        lambda on the coarse mesh (1/s), shape (n,).
    corrected
        lambda in the richer space (1/s), in the same order.
    remaining
        Change of ``corrected`` in the last step (1/s), shape (n,). It exceeds the remaining error
        if the iteration converges, and is infinite where the last change is larger than the one
        before. With damping beta K the iteration diverges beyond abs(lambda) = 1 / beta.
    uncertainties
        Algebraic errors of ``eigenvalues`` (1/s), shape (n,).
    """

    eigenvalues: Complexes
    corrected: Complexes
    remaining: Floats
    uncertainties: Floats

    @property
    def errors(self) -> Floats:
        """Estimated errors of lambda on the coarse mesh (1/s), shape (n,)."""
        return np.abs(self.corrected - self.eigenvalues)


def error_estimate(
    coarse: Modes,
    matrices: Matrices,
    prolongation: Any,
    *,
    steps: int,
) -> ErrorEstimate:
    """Return error estimates of the eigenvalues of a coarse mesh, by a richer pencil; collective.

    The first step gives the error to a few per cent if the error has short wavelengths; the change
    in the second estimates the rest. An empty list of modes, or an unsymmetric problem without left
    vectors, is refused. The prolongation is a PETSc AIJ matrix (:mod:`cea.nested.prolongation`).
    """
    start = prolonged(coarse, matrices, prolongation)
    if steps < 1:
        raise InputError("steps", steps, "1 or more")
    kappa = -(start.eigenvalues**2).real
    work = BlockSteps(matrices, 0.5 * (kappa.min() + kappa.max()))
    try:
        improved, changes = work.improved(start, steps)
    finally:
        work.free()
    corrected, rounding = improved.eigenvalues, coarse.growth_uncertainties
    falls = steps < 2 or changes[-1] <= np.maximum(changes[-2], rounding)
    remaining = np.where(falls, changes[-1], np.inf)
    return ErrorEstimate(coarse.eigenvalues, corrected, remaining, rounding)


def prolonged(coarse: Modes, matrices: Matrices, prolongation: Any) -> Approximation:
    """Return modes of a coarse mesh as approximations on a finer mesh."""
    if not len(coarse):
        raise InputError("modes", 0, "at least one mode")
    right = times(prolongation, coarse.vectors)
    if coarse.left is not None:
        left = times(prolongation, coarse.left.vectors)
    elif matrices.symmetric and matrices.gyroscopic is None:
        left = right.conj()
    else:
        raise InputError("left", False, "True: the coarse mesh needs left vectors")
    return Approximation(coarse.eigenvalues, right, left)
