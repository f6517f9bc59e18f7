"""Search of a window: every eigenvalue in it, its copies too, and what shows that none is missing.

Eigenvalues around the middle of the window come first. Where friction leaves no more than a cone
about the real axis, a disc about the middle covers it: the search goes on beside what was found, in
random directions, until it finds nothing more. Else a second shift, left of all of them, covers the
whole window with another disc. Where friction might move eigenvalues farther to the left than that
disc reaches, which in large systems is judged by turned test functions too, further discs follow.
"""

from itertools import pairwise
from typing import Any, Literal

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.block_krylov import BlockKrylov
from cea.eigen.coverage import distance_of_cone, distance_within, touching_disc
from cea.eigen.field_of_values import FieldOfValues, field_of_values
from cea.eigen.found import Disc, Found, upper_end
from cea.eigen.pencil import Matrices
from cea.eigen.sensitivity import SAME
from cea.eigen.shifted import Shifted
from cea.eigen.slepc_search import SlepcSearch
from cea.eigen.slices import NO_SLICES, Plan, Slice, covered, joined, plan_of
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.surroundings import nothing_beside
from cea.eigen.turned_field import TurnedField
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_DEPTH = 0.1
"""Depth X of the first covering disc relative to omega^2, where friction reaches no farther."""
_AROUND = 1.5
"""Radius up to which a disc about the middle is searched, relative to that of the first search."""
_DEEP = 3.0
"""The same where friction may reach farther: modes that grow by 1.7 omega."""
_DEEPER = 8.0
"""Growth of the depth from one covering disc to the next."""
_REACHED = 0.8
"""Part of the depth of a disc that it answers for."""
_SMALL = 10_000
"""Unknowns up to which covering discs are cheap."""
_MOST_DISCS = {True: 24, False: 3}
"""Most covering discs of small systems, and of others."""
_MOST_SEARCHES = 20
"""Searches of one disc, each beside what those before it found."""
_NEAR = 2
"""Discs whose shifts are near the window."""
_ASIDE = 1e-3
"""Step of a shift aside relative to itself, from an eigenvalue that is the square as near."""
_WIDER = 10.0
"""Radius of a disc around an empty one, relative to it."""
_STEPS_ASIDE = 4
"""Most such steps."""

Solver = Literal["block", "krylov-schur"]
"""What searches discs: by blocks, or Krylov-Schur of SLEPc as a reference."""
_INSIDE = 1 + SAME
"""Radius of a disc of left eigenvalues relative to the farthest right one in it."""


class WindowSearch:
    """Searches of the windows of one pencil at given parameters.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    factors
        The pencil factorised in the middle of the window; the search moves them.
    tolerance, max_restarts
        Of each search (:class:`cea.eigen.block_krylov.BlockKrylov`).
    timer
        Counts factorisation and krylov.
    solver
        What searches a disc.

    Attributes
    ----------
    factorisations
        Factorisations made so far.
    slices
        Slices in which the eigenvalues around the middle were found; none where there are few.
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
        self._middle = factors.kappa
        self.factorisations = 0
        self._finite = matrices.size - matrices.tied
        self._limits = tolerance, max_restarts
        self._timer, self._solver = timer, solver
        self._searches = self.slices = 0
        self._around: InvariantSubspace | None = None
        self._discs: list[Disc] = []
        self._farthest: dict[float, float] = {}
        self._signs: dict[float, int] = {}
        self._farthest_kappa = np.inf
        self._turned: TurnedField | None = None
        self._turns = matrices.size > _SMALL

    def real(self, top: float, counted: int) -> Found:
        """A window of a symmetric pencil: all that the inertia counts.

        Parameters
        ----------
        top
            Upper end omega^2 (1/s^2).
        counted
            Eigenvalues below :func:`upper_end`, by inertia.
        """
        upper = upper_end(top)
        known = self._around_the_middle(upper)
        radius = upper - self._middle
        if _below(known, upper) < counted:
            known = self._filled(known, radius)
        depth = max(0.0, radius - self._middle)
        while _below(known, upper) < counted and len(self._discs) < _MOST_DISCS[True]:
            depth = _DEEPER * max(depth, top)  # a stiffness that is not positive definite
            known = self._covered(known, top, depth, right=upper)
        bounded = _below(known, upper) == counted
        return Found(known, tuple(self._discs), depth, bounded, counted=counted, slices=self.slices)

    def complex(self, top: float) -> Found:
        """A window of a pencil with friction.

        Parameters
        ----------
        top
            Upper end omega^2 (1/s^2).
        """
        upper, depth, reached = upper_end(top), _DEPTH * top, -top
        field = self._field(depth, cone=True)
        bounded = field.bounded
        radius = distance_of_cone(top, self._middle, field)
        if radius <= _AROUND * (upper - self._middle):
            known = self._around_the_middle(max(upper, self._middle + radius))
            known = self._filled(
                known, distance_of_cone(top, self._middle, field), around=self._around
            )
            if not self._odd(known):
                return Found(known, tuple(self._discs), depth, bounded, slices=self.slices)
        else:
            known = self._around_the_middle(upper)
        most = _MOST_DISCS[self._matrices.size <= _SMALL]
        if not bounded:
            depth = _DEEP * top
        while known.size < self._finite:
            left = 1.0 if bounded else _REACHED
            known = self._covered(known, top, depth, left=left, right=-reached)
            reached = left * depth
            bounded = bounded or self._farthest_kappa <= reached or self._ends(top, reached)
            covering = len(self._discs) - 1
            odd = self._factors.kappa in self._odd(known)
            if (bounded and not odd) or covering >= (_MOST_DISCS[True] if odd else most):
                break
            depth *= _DEEPER
        else:
            reached, bounded = np.inf, True
        if self._turned is not None:
            self._turned.free()
        known = self._with_real_ones(known)
        if len(self._discs) > _NEAR:
            self._move(self._middle)  # modes are judged by factors near them
        odd = bool(self._odd(known))
        return Found(known, tuple(self._discs), reached, bounded, odd, slices=self.slices)

    def _around_the_middle(self, upper: float) -> InvariantSubspace:
        """Eigenvalues about the middle of the window; the shift steps aside where it is one."""
        for _ in range(_STEPS_ASIDE):
            self._move(self._middle)
            known = self._first(upper - self._middle)
            nearest = np.abs(known.eigenvalues() - self._middle).min(initial=np.inf)
            if nearest > _ASIDE**2 * self._middle:
                break
            self._farthest.clear()
            self._signs.clear()
            self._discs.clear()
            self._middle *= 1 - _ASIDE
        if not known.size:  # what lies around shows what rounding does
            known = self._filled(known, _WIDER * (upper - self._middle), once=True)
        return known

    def _first(self, radius: float) -> InvariantSubspace:
        """Eigenvalues of the disc about the middle, of which none is known; of many, in slices."""
        self.slices = 0
        first = self._slice(radius)
        if self.slices:
            low, high = self._middle - radius, self._middle + radius
            slices = covered(first, low, high, lambda at, reach: self._slice(reach, at))
            with self._timer("krylov"):
                known = joined(slices, self._matrices.mass)
            self._move(self._middle)
        else:
            known = first.found
        self._discs.append(Disc(self._middle, radius))
        return known

    def _slice(self, radius: float, to: float | None = None) -> Slice:
        """What a disc about the shift holds, or about one to move to; of many those nearest."""
        if to is not None:
            self._move(to)
        shift = self._factors.kappa
        krylov = self._searcher(plan=plan_of(self._finite, *self._factors.cost()))
        found = krylov.search(self._nothing(), radius, self._searches)
        self._around = None if to is not None or krylov.reached is not None else krylov.around
        self._searches += 1
        distances = np.abs(found.eigenvalues() - shift)
        if to is not None and distances.min(initial=np.inf) <= _ASIDE**2 * abs(shift):
            self._signs.pop(shift, None)
            return self._slice(radius, shift + _ASIDE * radius)
        self.slices += to is not None or krylov.reached is not None
        self._note(shift, distances)
        return Slice(Disc(shift, krylov.reached or radius), found)

    def _odd(self, known: InvariantSubspace) -> list[float]:
        """Shifts to the left of which the sign of the determinant shows another real kappa."""
        return [s for s, parity in self._signs.items() if parity != _below(known, s) % 2]

    def _with_real_ones(self, known: InvariantSubspace) -> InvariantSubspace:
        """Look for real kappa that signs of determinants show between two shifts."""
        shifts = sorted(self._signs)
        for low, high in pairwise(shifts):
            odd = self._odd(known)
            if (low in odd) != (high in odd):
                self._move(0.5 * (low + high))
                known = self._filled(known, 0.5 * (high - low))
        return known

    def left(self) -> tuple[Complexes, Complexes]:
        """Left eigenvectors, with the conjugates of their eigenvalues, of all that was found.

        Without friction they are the right ones, and none are searched.
        """
        known = self._nothing()
        if self._matrices.symmetric:
            return known.eigenpairs()
        for shift, distance in self._farthest.items():
            self._move(shift)
            known = self._filled(known, _INSIDE * distance, transposed=True)
        return known.eigenpairs()

    def _covered(
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
        self._move(centre)
        return self._filled(known, radius)

    def _filled(
        self,
        known: InvariantSubspace,
        radius: float,
        *,
        once: bool = False,
        transposed: bool = False,
        around: InvariantSubspace | None = None,
    ) -> InvariantSubspace:
        """Search a disc, once or again and again beside what was found until nothing more is.

        Beside what is known around the disc too, it is soon seen that nothing is missing.
        """
        shift = self._factors.kappa
        krylov = self._searcher(transposed=transposed)
        if around is not None:
            seed, self._searches = self._searches, self._searches + 1
            if nothing_beside(krylov, around, shift, radius, seed):
                self._discs.append(Disc(shift, radius))
                return known
        for _ in range(1 if once else _MOST_SEARCHES):
            before = known.size
            known = krylov.search(known, radius, self._searches, both_ends=not once)
            self._farthest_kappa = krylov.farthest
            self._searches += 1  # never from the same random vectors
            new = np.abs(known.eigenvalues(before) - shift)
            if not transposed:
                self._note(shift, new)
            if not (new < radius).any():
                break
        else:
            if not once:
                raise ConvergenceError(
                    f"the disc of radius {radius:.4g} about kappa = {shift:.4g} is not "
                    f"full after {_MOST_SEARCHES} searches, each of which found more",
                    best=known,
                )
        if not transposed:
            self._discs.append(Disc(shift, radius))
        return known

    def _note(self, shift: float, distances: Floats) -> None:
        """Take note of how far from a shift something was found, for its left vectors."""
        if len(distances):
            self._farthest[shift] = max(self._farthest.get(shift, 0.0), float(distances.max()))

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

    def _move(self, kappa: float) -> None:
        if kappa != self._factors.kappa:
            with self._timer("factorisation"):
                self._factors.move(kappa)
            self.factorisations += 1
        if (parity := self._factors.parity()) is not None:
            self._signs[kappa] = parity

    def _ends(self, top: float, depth: float) -> bool:
        """Whether nothing of the window has Re kappa < -depth: by as few tests as show it."""
        if self._field(depth).bounded:
            return True
        if not self._turns:
            return False
        with self._timer("factorisation"):
            try:
                return self._turned_ends(top, depth)
            except ConvergenceError:  # what shows nothing must not end what was found
                self._turns = False
                return False

    def _turned_ends(self, top: float, depth: float) -> bool:
        """The same by turned test functions, made when they are first asked for."""
        if self._turned is None:
            self.factorisations += 2
            self._turned = TurnedField.of(self._matrices)
            self._turns = self._turned is not None
        if self._turned is None:
            return False
        self.factorisations += 1
        return self._turned.bounds(top, depth)

    def _field(self, depth: float, *, cone: bool = False) -> FieldOfValues:
        self.factorisations += 1
        with self._timer("factorisation"):
            return field_of_values(self._matrices, depth, cone=cone)

    def _nothing(self) -> InvariantSubspace:
        rows = self._matrices.stiffness.getLocalSize()[0]
        return InvariantSubspace.empty(rows, symmetric=self._matrices.symmetric)


def _below(known: InvariantSubspace, kappa: float) -> int:
    return int(np.sum(known.eigenvalues().real < kappa))
