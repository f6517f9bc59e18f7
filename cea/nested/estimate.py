"""Errors of eigenvalues, estimated in a richer space without an eigenproblem there.

Prolonged right and left vectors X, Y of the coarse mesh take block inverse steps in the richer
space (:mod:`cea.nested.block_steps`). To first order the projected problem of one is

    d lambda = - (y^H r + s^H e) / y^H (2 lambda M + D) x,

r and s the residuals of x and y there and e = -A(sigma)^-1 r, the hierarchical estimate weighted
by the left vector; y^H r is what rules of contact and geometry that differ between the meshes make
(Heuveline & Rannacher, A posteriori error control for finite element approximations of elliptic
eigenvalue problems, 2001). All modes are projected together, so that groups that nearly coalesce
are corrected as groups.
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
        What the last step changed those by (1/s), shape (n,), more than is left where steps
        converge; infinite where it is more than the step before changed. With damping beta K beyond
        abs(lambda) = 1 / beta steps do not converge.
    uncertainties
        Errors of the coarse ones by rounding and iteration (1/s), shape (n,).
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
    """Errors of the eigenvalues of a coarse mesh, as the richer pencil tells them; collective.

    One block inverse step gives them to a few per cent where they are small scale, the next tells
    what remains. Modes without left vectors, or none, are refused. The prolongation is a PETSc
    AIJ matrix (:mod:`cea.nested.prolongation`).
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
    """Modes of a coarse mesh as approximations on a finer one."""
    if not len(coarse):
        raise InputError("modes", 0, "at least one mode to begin with")
    right = times(prolongation, coarse.vectors)
    if coarse.left is not None:
        left = times(prolongation, coarse.left.vectors)
    elif matrices.symmetric and matrices.gyroscopic is None:
        left = right.conj()
    else:
        raise InputError("left", False, "True where coarse modes are solved for: left vectors")
    return Approximation(coarse.eigenvalues, right, left)
