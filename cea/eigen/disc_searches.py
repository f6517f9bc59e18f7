"""Searches of discs of one pencil: shifts that factors move to, and what lay about each.

A disc counts as searched when a search beside all that is known, from other random vectors, finds
nothing more in it.
"""

from typing import Any, Literal

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.block_krylov import BlockKrylov
from cea.eigen.coverage import distance_within, touching_disc
from cea.eigen.found import Disc
from cea.eigen.krylov_run import Outside
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted
from cea.eigen.slepc_search import SlepcSearch
from cea.eigen.slices import NO_SLICES, Plan, Slice, covered, joined, plan_of
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.surroundings import nothing_beside
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_MOST_SEARCHES = 20
"""Searches of one disc, each beside what those before it found."""
_ASIDE = 1e-3
"""Step of a shift aside relative to itself, from an eigenvalue that is the square as near."""
_WIDER = 10.0
"""Radius of a disc around an empty one, relative to it."""
_EQUAL = 1 + 1e-12
"""Ratio of radii that are equal but for rounding."""
_STEPS_ASIDE = 4
"""Most such steps."""

Solver = Literal["block", "krylov-schur"]
"""What searches discs: by blocks, or Krylov-Schur of SLEPc as a reference."""


class DiscSearches:
    """Searches of discs of one pencil at given parameters.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    factors
        The pencil factorised in the middle of the window; searches move them.
    tolerance, max_restarts
        Of each search (:class:`cea.eigen.block_krylov.BlockKrylov`).
    timer
        Counts factorisation and krylov.
    solver
        What searches a disc.

    Attributes
    ----------
    middle
        Shift of the first disc (1/s^2).
    moves
        Factorisations made so far.
    discs
        Discs that were searched.
    farthest
        For each shift how far from it something was found (1/s^2).
    farthest_kappa
        Largest modulus (1/s^2) of an eigenvalue that the last search knew of, about its shift;
        infinite where it did not see the far end of the spectrum.
    slices
        Slices in which the eigenvalues around the middle were found; none where there are few.
    around
        What lies in the disc about the middle, and nearly converged around it; None where that is
        not known.
    """

    def __init__(
        self,
        matrices: Matrices,
        factors: Shifted,
        *,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
        solver: Solver = "block",
    ) -> None:
        self._matrices, self._factors = matrices, factors
        self.finite = matrices.size - matrices.tied
        """Finite eigenvalues."""
        self._limits = tolerance, max_restarts
        self._timer, self._solver = timer, solver
        self._searches = 0
        self._signs: dict[float, int] = {}
        self.middle = factors.kappa
        self.moves = self.slices = 0
        self.discs: list[Disc] = []
        self.farthest: dict[float, float] = {}
        self.farthest_kappa = np.inf
        self.around: InvariantSubspace | None = None
        self._confirmed = 0.0

    @property
    def shift(self) -> float:
        """Where the factors are (1/s^2)."""
        return float(self._factors.kappa)

    @property
    def signs(self) -> list[float]:
        """Shifts at which the sign of the determinant is known, rising."""
        return sorted(self._signs)

    def move(self, kappa: float) -> None:
        """Factorise about a shift (1/s^2), unless that is where the factors are."""
        if kappa != self._factors.kappa:
            with self._timer("factorisation"):
                self._factors.move(kappa)
            self.moves += 1
        if (parity := self._factors.parity()) is not None:
            self._signs[kappa] = parity

    def around_the_middle(self, upper: float, outside: Outside | None = None) -> InvariantSubspace:
        """Eigenvalues about the middle of the window; the shift steps aside where it is one.

        Parameters
        ----------
        upper
            Right end of the disc (1/s^2).
        outside
            What of the disc is not wanted; None where all of it is.
        """
        for _ in range(_STEPS_ASIDE):
            self.move(self.middle)
            known = self._first(upper - self.middle, outside)
            nearest = np.abs(known.eigenvalues() - self.middle).min(initial=np.inf)
            if nearest > _ASIDE**2 * self.middle:
                break
            self.farthest.clear()
            self._signs.clear()
            self.discs.clear()
            self.middle *= 1 - _ASIDE
        if not known.size:  # what lies around shows what rounding does
            known = self.filled(known, _WIDER * (upper - self.middle), once=True)
        return known

    def _first(self, radius: float, outside: Outside | None) -> InvariantSubspace:
        """Eigenvalues of the disc about the middle, of which none is known; of many, in slices."""
        self.slices = 0
        first = self._slice(radius, outside=outside)
        if self.slices:
            low, high = self.middle - radius, self.middle + radius
            slices = covered(first, low, high, lambda at, reach: self._slice(reach, at))
            with self._timer("krylov"):
                known = joined(slices, self._matrices.mass)
            self.move(self.middle)
        else:
            known = first.found
        self.discs.append(Disc(self.middle, radius))
        return known

    def _slice(
        self, radius: float, to: float | None = None, outside: Outside | None = None
    ) -> Slice:
        """What a disc about the shift holds, or about one to move to; of many those nearest."""
        if to is not None:
            self.move(to)
        shift = self._factors.kappa
        krylov = self._searcher(plan=plan_of(self.finite, *self._factors.cost()))
        found = krylov.search(
            self.nothing(), radius, self._searches, outside=outside, fresh=outside is not None
        )
        self._confirmed = radius if krylov.confirmed else 0.0
        self.around = None if to is not None or krylov.reached is not None else krylov.around
        self._searches += 1
        distances = np.abs(found.eigenvalues() - shift)
        if to is not None and distances.min(initial=np.inf) <= _ASIDE**2 * abs(shift):
            self._signs.pop(shift, None)
            return self._slice(radius, shift + _ASIDE * radius)
        self.slices += to is not None or krylov.reached is not None
        self._note(shift, distances)
        return Slice(Disc(shift, krylov.reached or radius), found)

    def odd(self, known: InvariantSubspace) -> list[float]:
        """Shifts to the left of which the sign of the determinant shows another real kappa."""
        return [s for s, parity in self._signs.items() if parity != below(known, s) % 2]

    def covered(
        self,
        known: InvariantSubspace,
        top: float,
        depth: float,
        *,
        right: float,
        left: float = 1.0,
    ) -> InvariantSubspace:
        """The known with what lies between two real parts."""
        centre = touching_disc(top, depth)
        radius = distance_within(top, centre, -left * depth, right)
        self.move(centre)
        return self.filled(known, radius)

    def filled(
        self,
        known: InvariantSubspace,
        radius: float,
        *,
        once: bool = False,
        around: InvariantSubspace | None = None,
    ) -> InvariantSubspace:
        """Search a disc, once or again and again beside what was found until nothing more is.

        Beside what is known around the disc too, it is soon seen that nothing is missing; the
        search about the middle may have seen it itself.
        """
        shift = self._factors.kappa
        krylov = self._searcher()
        if shift == self.middle and radius <= self._confirmed * _EQUAL:
            return known
        if around is not None:
            seed, self._searches = self._searches, self._searches + 1
            if nothing_beside(krylov, around, shift, radius, seed):
                self.discs.append(Disc(shift, radius))
                return known
        for _ in range(1 if once else _MOST_SEARCHES):
            before = known.size
            known = krylov.search(known, radius, self._searches, both_ends=not once)
            self.farthest_kappa = krylov.farthest
            self._searches += 1  # never from the same random vectors
            new = np.abs(known.eigenvalues(before) - shift)
            self._note(shift, new)
            if not (new < radius).any():
                break
        else:
            if not once:
                raise _not_full(shift, radius, known)
        self.discs.append(Disc(shift, radius))
        return known

    def filled_with_left_ones(
        self, known: InvariantSubspace, radius: float, right: Complexes
    ) -> InvariantSubspace:
        """Left vectors of a disc about the shift beside the known, as many as right eigenvalues."""
        shift = self._factors.kappa
        krylov = self._searcher(transposed=True)
        wanted = int((np.abs(right - shift) < radius).sum())
        for _ in range(_MOST_SEARCHES):
            before = known.size
            known = krylov.search(known, radius, self._searches, both_ends=True)
            self._searches += 1  # never from the same random vectors
            inside, new = (
                int((np.abs(known.eigenvalues(first) - shift) < radius).sum())
                for first in (0, before)
            )
            if inside >= wanted or not new:
                return known
        raise _not_full(shift, radius, known)

    def _note(self, shift: float, distances: Floats) -> None:
        """Take note of how far from a shift something was found, for its left vectors."""
        if len(distances):
            self.farthest[shift] = max(self.farthest.get(shift, 0.0), float(distances.max()))

    def _searcher(
        self, *, transposed: bool = False, plan: Plan = NO_SLICES
    ) -> BlockKrylov | SlepcSearch:
        """What searches discs about the shift; in part where they hold very many."""
        tolerance, max_restarts = self._limits
        options: Any = {
            **{"tolerance": tolerance, "max_restarts": max_restarts},
            **{"timer": self._timer, "transposed": transposed},
        }
        if self._solver == "krylov-schur":
            return SlepcSearch(self._matrices, self._factors, **options)
        return BlockKrylov(self._matrices, self._factors, plan=plan, **options)

    def nothing(self) -> InvariantSubspace:
        """Where a search begins: nothing is known."""
        rows = self._matrices.stiffness.getLocalSize()[0]
        return InvariantSubspace.empty(rows, symmetric=self._matrices.symmetric)


def _not_full(shift: float, radius: float, known: InvariantSubspace) -> ConvergenceError:
    return ConvergenceError(
        f"the disc of radius {radius:.4g} about kappa = {shift:.4g} is not full after "
        f"{_MOST_SEARCHES} searches, each of which found more",
        best=known,
    )


def below(known: InvariantSubspace, kappa: float) -> int:
    """Number of known eigenvalues left of a shift."""
    return int(np.sum(known.eigenvalues().real < kappa))
