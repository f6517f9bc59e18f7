"""The few eigenvalues of a damped or rotating pencil nearest to a place, by shift-and-invert there.

The companion form is searched about the place (:mod:`cea.eigen.companion`), complex or real,
without a disc: the Krylov space is restarted until as many eigenvalues as are wanted have
converged, with all that are nearer. Of conjugate ones that with Im lambda >= 0 counts.
"""

import sys
from dataclasses import dataclass

import numpy as np

from cea.eigen.block_krylov import BlockSearch
from cea.eigen.companion import CompanionSearch
from cea.eigen.krylov_run import KrylovRun
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_search import upper_half
from cea.eigen.quadratic_shifted import QuadraticShifted
from cea.eigen.quadratic_window import QuadraticWindow
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_ASIDE = 1e-3
"""Step of the shift aside, relative to the place, where that is an eigenvalue."""
_TOO_NEAR = 1e-9
"""Distance of an eigenvalue from the shift, relative to the place, at which others lose digits."""
_TIE = 1e-9
"""Relative difference of distances from the shift that counts as none."""
_ROOM = 24
"""Vectors kept at a restart beside those wanted."""
_FULL = 2.5
"""Size of the Krylov space, relative to the vectors kept, at which it is restarted."""


class NearestCompanionSearch(CompanionSearch):
    """Searches for so many eigenvalues nearest to the shift; options are those of its base."""

    def nearest(self, wanted: int) -> InvariantSubspace:
        """The invariant subspace of so many eigenvalues nearest to the shift, or a few more.

        Those with Im lambda < 0 are left out, but for conjugates of those next to the real axis.

        Raises
        ------
        ConvergenceError
            When they do not converge; ``best`` is the subspace of those that did.
        """
        with self._timer("krylov"):
            rows = 2 * self._mass.getLocalSize()[0]
            return upper_half(_NearestRun(self, rows, wanted).complete(), self._scale)


class _NearestRun(KrylovRun):
    """A Krylov run that ends when so many eigenvalues have converged."""

    def __init__(self, owner: BlockSearch, rows: int, wanted: int) -> None:
        nothing = InvariantSubspace.empty(rows, symmetric=False)
        super().__init__(owner, nothing, 1.0, 0, both_ends=False)
        self._wanted = wanted

    def complete(self) -> InvariantSubspace:
        """What is wanted, all of it converged."""
        restarts, look = 0, 2 * self._wanted + _ROOM
        while True:
            exhausted = not self._space.next or self._space.size >= self._room
            if self._space.size < look and not exhausted:
                self._space.extend()
                continue
            theta, residuals = self._ritz()
            converged = residuals <= self._owner.tolerance * np.abs(theta)
            if exhausted:  # the space is all there is
                converged = self._largest(theta)
            nearest = self._nearest(theta)
            if exhausted or converged[nearest].all():
                chosen = np.zeros(len(theta), dtype=bool)
                chosen[nearest] = True
                return self._locked(theta, converged & chosen)
            kept = len(nearest) + _ROOM
            if self._space.size >= _FULL * kept:
                if restarts == self._owner.max_restarts:
                    raise ConvergenceError(
                        f"{int(converged[nearest].sum())} of {len(nearest)} eigenvalues next to "
                        f"lambda = {self._shift:.4g} converged",
                        best=self._locked(theta, converged),
                    )
                restarts += 1
                self._space.restart(*self._leading(theta, kept))
            look = self._space.size + 1

    def _nearest(self, theta: np.ndarray) -> np.ndarray:
        """Of which theta stand for those wanted and all that are nearer."""
        order = np.argsort(-np.abs(theta))
        order = order[np.abs(theta[order]) > np.finfo(float).tiny]
        upper = (self._shift + 1 / theta[order]).imag >= 0
        end = int(np.searchsorted(np.cumsum(upper), self._wanted)) + 1
        sizes = np.abs(theta[order])
        while 0 < end < len(order) and sizes[end] > (1 - _TIE) * sizes[end - 1]:
            end += 1  # about a real shift conjugates are equally near
        return order[:end]


@dataclass(frozen=True)
class QuadraticNeighbours(QuadraticWindow):
    """What was searched about a place: no window.

    Parameters
    ----------
    place
        lambda of the shift (1/s).
    """

    place: complex

    @property
    def evidence(self) -> str:
        """What was looked for, in words."""
        return (
            f"{self.found} eigenvalues lambda nearest to {self.place:.6g} 1/s, "
            f"up to {self.radius:.4g} 1/s away; no window was searched"
        )


def nearest_subspace(
    matrices: Matrices,
    place: complex,
    wanted: int,
    *,
    tolerance: float,
    max_restarts: int,
    timer: StageTimer,
) -> tuple[InvariantSubspace, QuadraticShifted]:
    """Invariant subspace of the eigenvalues nearest to a place, and the factors it was found with.

    Where the place is an eigenvalue, or next to one, the shift is a thousandth beside it.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    place
        lambda (1/s), Im lambda >= 0; not zero. A real one is searched with real factors.
    wanted
        Number of eigenvalues.
    tolerance, max_restarts
        Of the Krylov iteration.
    timer
        Counts factorisation and krylov.

    Raises
    ------
    ConvergenceError
        When fewer converge, or the pencil is singular at and beside the place.
    """
    wanted = min(wanted, 2 * (matrices.size - matrices.tied))
    for shift in (place, place * (1 + _ASIDE)):
        try:
            with timer("factorisation"):
                factors = QuadraticShifted(matrices, shift if shift.imag else shift.real)
        except ConvergenceError:
            continue
        search = NearestCompanionSearch(
            matrices,
            factors,
            abs(place),
            tolerance=tolerance,
            max_restarts=max_restarts,
            timer=timer,
            most=sys.maxsize,
        )
        try:
            found = search.nearest(wanted)
        except ConvergenceError:
            factors.free()
            raise
        finally:
            search.free()
        distance = np.abs(found.eigenvalues() - shift).min(initial=np.inf)
        if distance > _TOO_NEAR * abs(place) or shift != place:
            return found, factors
        factors.free()
    raise ConvergenceError(f"the pencil is singular at and beside lambda = {place:.6g} 1/s")


def neighbours(place: complex, found: InvariantSubspace) -> QuadraticNeighbours:
    """What stands in the place of a window."""
    values = found.eigenvalues()
    return QuadraticNeighbours(
        max_frequency=float(np.abs(values).max(initial=abs(place))) / (2 * np.pi),
        shift=place.real,
        radius=float(np.abs(values - place).max(initial=0.0)),
        found=found.size,
        discs=1,
        max_growth=0.0,
        bounded=False,
        odd=False,
        upper=np.inf,
        found_below=found.size,
        symmetric_count=None,
        min_growth=-np.inf,
        place=place,
    )
