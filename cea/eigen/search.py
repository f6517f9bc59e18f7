"""Search of a window: every eigenvalue in it, its copies too, and what shows that none is missing.

Eigenvalues around the middle of the window come first. Where friction leaves no more than a cone
about the real axis, a disc about the middle covers it, unless it would hold many that lie beyond
the window: the search goes on beside what was found, in random directions, until it finds nothing
more. Else a second shift, left of all of them, covers the whole window with another disc. Where
friction might move eigenvalues farther to the left than that disc reaches, which in large systems
is judged by turned test functions too, further discs follow.
"""

from functools import partial
from itertools import pairwise
from math import sqrt

import numpy as np

from cea.arrays import Complexes
from cea.eigen.coverage import distance_of_cone, outside_of_window
from cea.eigen.disc_searches import DiscSearches, Solver, below
from cea.eigen.field_of_values import FieldOfValues, field_of_values, has_cone
from cea.eigen.found import Found, upper_end
from cea.eigen.pencil import Matrices
from cea.eigen.sensitivity import SAME
from cea.eigen.shifted import Shifted
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.turned_field import TurnedField
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_DEPTH = 0.15
"""Depth X of the first covering disc relative to omega^2, where friction reaches no farther."""
_AROUND = 1.5
"""Radius up to which a disc about the middle is searched, relative to that of the first search."""
_FEW = 40
"""Eigenvalues beyond the window, by what it holds itself, that are found about the middle sooner
than a further shift is factorised, and once more for left vectors."""
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
_NEAR = 2
"""Discs whose shifts are near the window."""
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
    field
        :func:`first_field` of a pencil with friction; None without.
    tolerance, max_restarts
        Of each search (:class:`cea.eigen.block_krylov.BlockKrylov`).
    timer
        Counts factorisation and krylov.
    solver
        What searches a disc.
    """

    def __init__(
        self,
        matrices: Matrices,
        factors: Shifted,
        field: FieldOfValues | None,
        *,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
        solver: Solver = "block",
    ) -> None:
        self._matrices, self._timer = matrices, timer
        self._discs = DiscSearches(
            matrices,
            factors,
            tolerance=tolerance,
            max_restarts=max_restarts,
            timer=timer,
            solver=solver,
        )
        self._first_field = field
        self._tests = int(field is not None)
        self._turned: TurnedField | None = None
        self._turns = matrices.size > _SMALL

    @property
    def factorisations(self) -> int:
        """Factorisations made so far."""
        return self._discs.moves + self._tests

    def real(self, top: float, counted: int) -> Found:
        """A window of a symmetric pencil: all that the inertia counts.

        Parameters
        ----------
        top
            Upper end omega^2 (1/s^2).
        counted
            Eigenvalues below :func:`upper_end`, by inertia.
        """
        discs, upper = self._discs, upper_end(top)
        known = discs.around_the_middle(upper)
        radius = upper - discs.middle
        if below(known, upper) < counted:
            known = discs.filled(known, radius)
        depth = max(0.0, radius - discs.middle)
        while below(known, upper) < counted and len(discs.discs) < _MOST_DISCS[True]:
            depth = _DEEPER * max(depth, top)  # a stiffness that is not positive definite
            known = discs.covered(known, top, depth, right=upper)
        bounded = below(known, upper) == counted
        return Found(
            known, tuple(discs.discs), depth, bounded, counted=counted, slices=discs.slices
        )

    def complex(self, top: float) -> Found:
        """A window of a pencil with friction.

        Parameters
        ----------
        top
            Upper end omega^2 (1/s^2).
        """
        discs, field = self._discs, self._first_field
        assert field is not None
        upper, depth, reached = upper_end(top), field.depth, -top
        bounded = field.bounded
        radius = distance_of_cone(top, discs.middle, field)
        if radius <= _AROUND * (upper - discs.middle):
            known = discs.around_the_middle(
                max(upper, discs.middle + radius), partial(outside_of_window, upper)
            )
            known = discs.filled(
                known, distance_of_cone(top, discs.middle, field), around=discs.around
            )
            if not discs.odd(known):
                return Found(known, tuple(discs.discs), depth, bounded, slices=discs.slices)
        else:
            known = discs.around_the_middle(upper)
            radius = distance_of_cone(top, discs.middle, field)
            if known.size * (sqrt((discs.middle + radius) / top) - 1) <= _FEW:
                known = discs.filled(known, radius)
                if not discs.odd(known):
                    return Found(known, tuple(discs.discs), depth, bounded, slices=discs.slices)
        most = _MOST_DISCS[self._matrices.size <= _SMALL]
        if not bounded:
            depth = _DEEP * top
        while known.size < discs.finite:
            left = 1.0 if bounded else _REACHED
            known = discs.covered(known, top, depth, left=left, right=-reached)
            reached = left * depth
            bounded = bounded or discs.farthest_kappa <= reached or self._ends(top, reached)
            covering = len(discs.discs) - 1
            odd = discs.shift in discs.odd(known)
            if (bounded and not odd) or covering >= (_MOST_DISCS[True] if odd else most):
                break
            depth *= _DEEPER
        else:
            reached, bounded = np.inf, True
        if self._turned is not None:
            self._turned.free()
        known = self._with_real_ones(known)
        if len(discs.discs) > _NEAR:
            discs.move(discs.middle)  # modes are judged by factors near them
        odd = bool(discs.odd(known))
        return Found(known, tuple(discs.discs), reached, bounded, odd, slices=discs.slices)

    def _with_real_ones(self, known: InvariantSubspace) -> InvariantSubspace:
        """Look for real kappa that signs of determinants show between two shifts."""
        discs = self._discs
        for low, high in pairwise(discs.signs):
            odd = discs.odd(known)
            if (low in odd) != (high in odd):
                discs.move(0.5 * (low + high))
                known = discs.filled(known, 0.5 * (high - low))
        return known

    def left(self, found: Complexes) -> tuple[Complexes, Complexes]:
        """Left eigenvectors, with the conjugates of their eigenvalues, of all that was found.

        Without friction they are the right ones, and none are searched.

        Parameters
        ----------
        found
            Eigenvalues that were found (1/s^2): a disc is full when it holds as many.
        """
        discs = self._discs
        known = discs.nothing()
        if self._matrices.symmetric:
            return known.eigenpairs()
        for shift, distance in discs.farthest.items():
            discs.move(shift)
            known = discs.filled_with_left_ones(known, _INSIDE * distance, found)
        return known.eigenpairs()

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
            self._tests += 2
            self._turned = TurnedField.of(self._matrices)
            self._turns = self._turned is not None
        if self._turned is None:
            return False
        self._tests += 1
        return self._turned.bounds(top, depth)

    def _field(self, depth: float) -> FieldOfValues:
        self._tests += 1
        with self._timer("factorisation"):
            return field_of_values(self._matrices, depth)


def first_field(
    matrices: Matrices, top: float, near_contact: Matrices | None = None
) -> FieldOfValues:
    """How far friction moves eigenvalues near the window: what its first disc rests on.

    Parameters
    ----------
    matrices
        The pencil at given parameters, with friction.
    top
        Upper end omega^2 (1/s^2).
    near_contact
        What lies near the contacts alone (:attr:`cea.eigen.pencil.Pencil.near_contact`): its field
        of values is the wider one, and known sooner. Where it leaves no more than a disc about the
        middle of the window it is taken.

    Raises
    ------
    ConvergenceError
        When the factorisation fails.
    """
    if near_contact is not None and has_cone(near_contact):
        field, middle = field_of_values(near_contact, _DEPTH * top, cone=True), 0.5 * top
        if distance_of_cone(top, middle, field) <= _AROUND * (upper_end(top) - middle):
            return field
    return field_of_values(matrices, _DEPTH * top, cone=True)
