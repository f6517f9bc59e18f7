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

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.block_products import times
from cea.eigen.classify import Word, classify, thresholds
from cea.eigen.modes import Modes
from cea.eigen.pencil import Matrices
from cea.errors import InputError
from cea.nested.block_steps import Approximation, BlockSteps
from cea.nested.clusters import Cluster, clusters_of
from cea.nested.prolongation import Prolongation


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
    clusters
        Modes that are judged together; each is in one of them.
    damped
        Whether the problem is quadratic in lambda; means of clusters are then those of lambda.
    symmetric
        Whether it is symmetric and undamped: nothing flutters.
    dofs
        Unknowns of the richer space.
    growth_threshold
        Growth rate (1/s) above which a mode is called unstable; None takes 1e-4 of abs(lambda).
    """

    eigenvalues: Complexes
    corrected: Complexes
    remaining: Floats
    uncertainties: Floats
    clusters: tuple[Cluster, ...]
    damped: bool
    symmetric: bool
    dofs: int
    growth_threshold: float | None = None

    @property
    def errors(self) -> Floats:
        """Estimated errors of lambda on the coarse mesh (1/s), shape (n,)."""
        return np.abs(self.corrected - self.eigenvalues)

    @property
    def frequency_errors(self) -> Floats:
        """Those of Im lambda (rad/s), shape (n,)."""
        return np.abs(self.corrected.imag - self.eigenvalues.imag)

    @property
    def growth_errors(self) -> Floats:
        """Those of Re lambda (1/s), shape (n,)."""
        return np.abs(self.corrected.real - self.eigenvalues.real)

    @property
    def verdicts(self) -> list[Word]:
        """The word of each mode, with its estimated error (:func:`cea.eigen.classify.classify`).

        Without damping a mode whose kappa is real, and apart from all others beyond their errors,
        cannot grow; a pair that nearly meets is decided by the sign of its splitting. Without
        friction nothing grows.
        """
        bars = self.growth_errors + self.remaining + self.uncertainties
        bounded = np.full(len(bars), self.symmetric)
        for cluster in () if self.damped or self.symmetric else self.clusters:
            members = cluster.members
            if len(members) == 2 and cluster.meets:
                bars[members] = 0.0 if cluster.decided else np.inf
                bounded[members] = cluster.decided and not cluster.flutters
            elif len(members) == 1:
                bounded[members] = self.corrected[members].real == 0
        rigid = np.abs(self.eigenvalues) <= self.uncertainties
        limits = thresholds(self.corrected, self.growth_threshold)
        return classify(self.corrected.real, bars, limits, bounded, rigid)


def error_estimate(
    coarse: Modes,
    matrices: Matrices,
    prolongation: Prolongation,
    *,
    steps: int,
) -> ErrorEstimate:
    """Errors of the eigenvalues of a coarse mesh, as the richer pencil tells them; collective.

    One block inverse step gives them to a few per cent where they are small scale, the next tells
    what remains. Modes without left vectors, or none, are refused.
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
    both = coarse.eigenvalues, corrected
    if not matrices.quadratic:
        both = -(coarse.eigenvalues**2), -(corrected**2)
    falls = steps < 2 or changes[-1] <= np.maximum(changes[-2], rounding)
    return ErrorEstimate(
        coarse.eigenvalues,
        corrected,
        np.where(falls, changes[-1], np.inf),
        rounding,
        clusters_of(*both),
        damped=matrices.quadratic,
        symmetric=matrices.symmetric and not matrices.quadratic,
        dofs=matrices.size,
    )


def prolonged(coarse: Modes, matrices: Matrices, prolongation: Prolongation) -> Approximation:
    """Modes of a coarse mesh as approximations on a finer one."""
    if not len(coarse):
        raise InputError("modes", 0, "at least one mode to begin with")
    right = times(prolongation.matrix, coarse.vectors)
    if coarse.left is not None:
        left = times(prolongation.matrix, coarse.left.vectors)
    elif matrices.symmetric and matrices.gyroscopic is None:
        left = right.conj()
    else:
        raise InputError("left", False, "True where coarse modes are solved for: left vectors")
    return Approximation(coarse.eigenvalues, right, left)
