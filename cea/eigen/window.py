"""Search of a window: discs about real shifts, and what shows that none of its modes is missing.

Each disc is searched beside what the discs before it hold. Without damping the first lies about the
middle of the window, in kappa = -lambda^2. Where friction leaves no more than a cone about the real
axis it covers the window; else further discs, left of all, cover it as far as friction may move
eigenvalues (:mod:`cea.eigen.coverage`). With damping or rotation the window holds the lambda with
0 <= Im lambda <= omega and Re lambda >= -d, and a disc about a real shift c > 0,

    abs(lambda - c)^2 <= (c + d)^2 + omega^2,

holds all of it up to the growth 2 c + d, and the conjugates; further discs follow to the right.
Of small systems the first disc tells all (:mod:`cea.eigen.dense`).
"""

import sys
from abc import ABC, abstractmethod
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cea.arrays import Complexes
from cea.eigen.block_krylov import CrowdedError, NearShiftError, krylov_schur
from cea.eigen.coverage import Disc, distance_of_cone, distance_within, touching_disc, upper_end
from cea.eigen.field_of_values import FieldOfValues, field_of_values, has_cone
from cea.eigen.left_vectors import SAME
from cea.eigen.options import KrylovOptions
from cea.eigen.pencil import Matrices
from cea.eigen.shift_invert import MARGIN, Companion, Undamped
from cea.eigen.shifted import count_below
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.turned_field import TurnedField
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_DEPTH, _DEEP = 0.15, 3.0
"""Depth X of the first covering disc relative to omega^2: where friction reaches no farther, and
where it may, for modes that grow by 1.7 omega."""
_FARTHER = 8.0
"""Growth of the depth, or of a real shift, from one disc to the next."""
_REACHED = 0.8
"""Part of the depth of a disc that it answers for where eigenvalues may lie beyond."""
_AROUND = 1.5
"""Radius up to which a disc about the middle is searched, relative to that of the plain one."""
_DECAY = 0.1
"""Decay d down to which a damped window is complete by default, relative to omega."""
_CROWDED, _FEW = 4, 100
"""Eigenvalues in a disc that are too many: modes of the window without damping, and a number."""
_AWAY, _SLIM = 4.0, 2.0
"""Growth of a real shift where eigenvalues crowd, and the shift relative to omega from which on a
disc reaches little beyond the decay asked for."""
_ATTEMPTS = 6
"""Shifts tried at most, where they are eigenvalues and where eigenvalues crowd."""
_ASIDE = 1e-3
"""Step of a shift aside from an eigenvalue, relative to itself."""
_INSIDE = 1 + SAME
"""Radius of a disc of left eigenvalues relative to the farthest right one in it: those that are the
same but for rounding, which is large of rigid motions and near coalescence, are inside."""


@dataclass(frozen=True)
class Found:
    """What a search of a window found.

    Parameters
    ----------
    subspace
        Invariant subspace of the eigenvalues found, of the companion form where something damps.
    discs
        Discs that were searched.
    growth
        Every eigenvalue of the window that grows at this rate or slower was found (1/s).
    bounded
        Whether none grows faster.
    odd
        Whether the sign of a determinant shows that a real eigenvalue is missing.
    counted
        Without friction, eigenvalues below :func:`cea.eigen.coverage.upper_end` by inertia.
    """

    subspace: InvariantSubspace
    discs: tuple[Disc, ...] = ()
    growth: float = 0.0
    bounded: bool = False
    odd: bool = False
    counted: int | None = None


class WindowSearch(ABC):
    """Searches of one window of one pencil at given parameters.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    end
        omega (1/s).
    options
        Options of the method.
    timer
        Counts factorisation and krylov.

    Attributes
    ----------
    known
        Invariant subspace of what was found.
    discs
        Discs that were searched.
    factorisations
        Factorisations made so far.
    """

    def __init__(
        self, matrices: Matrices, end: float, options: KrylovOptions, timer: StageTimer
    ) -> None:
        self._matrices, self._end, self._options, self._timer = matrices, end, options, timer
        self.known: InvariantSubspace | None = None
        self.discs: list[Disc] = []
        self.factorisations = 0
        self._op: Undamped | None = None
        self._parities: dict[float, int] = {}

    @abstractmethod
    def run(self) -> Found:
        """Every eigenvalue of the window, with what shows it.

        Raises
        ------
        ConvergenceError
            When a disc cannot be searched; ``best`` is the invariant subspace so far.
        """

    @abstractmethod
    def _operator(self, shift: float) -> Undamped:
        """The operator at a shift."""

    def at(self, shift: float) -> Undamped:
        """The operator at a shift; that before it is freed.

        Raises
        ------
        ConvergenceError
            When the pencil is singular there.
        """
        if self._op is None or self._op.shift != shift:
            self.free()
            self.factorisations += 1
            with self._timer("factorisation"):
                self._op = self._operator(shift)
            if (parity := self._op.factors.parity()) is not None:
                self._parities[shift] = parity
        return self._op

    @property
    def near(self) -> Undamped:
        """An operator near the window, by which modes are judged."""
        near = [each.centre for each in self.discs[:2]]
        if self._op is not None and (not near or self._op.shift in near):
            return self._op
        return self.at(self.discs[0].centre)

    def search(self, centre: float, radius: float, most: int = sys.maxsize) -> None:
        """Search a disc; its shift steps aside where it is an eigenvalue."""
        before = self.known
        for _ in range(_ATTEMPTS):
            op = self._at_regular(centre)
            try:
                if op is not None:
                    with self._timer("krylov"):
                        self.known = krylov_schur(
                            op, radius, self._options, before, seed=len(self.discs), most=most
                        )
                    self.discs.append(Disc(centre, radius))
                    return
            except NearShiftError:
                self._parities.pop(centre, None)
            radius += _ASIDE * abs(centre)
            centre *= 1 + _ASIDE
        raise ConvergenceError(
            f"the pencil is singular at every shift near {centre:.4g}", best=before
        )

    def _at_regular(self, shift: float) -> Undamped | None:
        """The operator at a shift; None where that is an eigenvalue."""
        try:
            return self.at(shift)
        except ConvergenceError:
            return None

    @property
    def whole(self) -> bool:
        """Whether everything in the window was found, however fast it grows."""
        return self.known is not None and self.known.whole

    def odd(self, shift: float | None = None) -> bool:
        """Whether signs of determinants show another real eigenvalue beyond a shift, or any."""
        assert self.known is not None
        values = self.known.eigenvalues()
        chosen = self._parities if shift is None else {shift} & self._parities.keys()
        return any(self._parities[s] != self._beyond(values, s) % 2 for s in chosen)

    @abstractmethod
    def _beyond(self, values: Complexes, shift: float) -> int:
        """Number of eigenvalues beyond a shift."""

    def left(self, rows: int) -> tuple[Complexes, Complexes]:
        """Eigenvectors of the transposed pencil, and their eigenvalues, of all that was found.

        Parameters
        ----------
        rows
            Displacements of this rank: the rows of the vectors.

        Raises
        ------
        ConvergenceError
            When they do not converge.
        """
        assert self.known is not None
        values, found = self.known.eigenvalues(), None
        for disc in sorted(
            self.discs, key=lambda each: self._op is None or each.centre != self._op.shift
        ):
            distances = np.abs(values - disc.centre)
            inside = self.whole | (distances < disc.radius * _INSIDE)
            farthest = max(float(distances[inside].max(initial=0.0)), _ASIDE * disc.radius)
            op = self.at(disc.centre).transposed()
            with self._timer("krylov"):
                found = krylov_schur(op, _INSIDE * farthest, self._options, found, seed=len(values))
            op.free()
        assert found is not None
        return found.eigenpairs(rows)

    def free(self) -> None:
        """Free the factors."""
        if self._op is not None:
            self._op.free()
            self._op = None


class UndampedSearch(WindowSearch):
    """Searches of K x = kappa M x.

    Parameters
    ----------
    matrices, end, options, timer
        Those of :class:`WindowSearch`.
    counted
        Without friction, eigenvalues below :func:`cea.eigen.coverage.upper_end` by inertia.
    near_contact
        Pencil of what lies near the contacts (:attr:`cea.eigen.pencil.Pencil.near_contact`).
    """

    def __init__(
        self,
        matrices: Matrices,
        end: float,
        options: KrylovOptions,
        timer: StageTimer,
        counted: int | None,
        near_contact: Matrices | None = None,
    ) -> None:
        super().__init__(matrices, end, options, timer)
        self._top, self._counted, self._near_contact = end**2, counted, near_contact
        self._turned: TurnedField | None = None
        self._turns = True

    def run(self) -> Found:
        """A window of any growth."""
        return self._with_friction() if self._counted is None else self._symmetric(self._counted)

    def _operator(self, shift: float) -> Undamped:
        return Undamped(self._matrices, shift, self._end)

    def _beyond(self, values: Complexes, shift: float) -> int:
        return int(np.sum(values.real < shift))

    def _below(self, upper: float) -> int:
        assert self.known is not None
        return int(np.sum(self.known.eigenvalues().real < upper))

    def _symmetric(self, counted: int) -> Found:
        """All that the inertia counts."""
        top, middle, upper = self._top, 0.5 * self._top, upper_end(self._top)
        self.search(middle, upper - middle)
        depth = 0.0
        while self._below(upper) < counted and len(self.discs) <= self._options.max_discs:
            depth = _FARTHER * max(depth, top)  # a stiffness that is not positive definite
            centre = touching_disc(top, depth)
            self.search(centre, distance_within(top, centre, -depth, upper))
        bounded = self._below(upper) == counted
        return self._found(depth, bounded=bounded, counted=counted)

    def _with_friction(self) -> Found:
        top, middle = self._top, 0.5 * self._top
        plain = upper_end(top) - middle
        if self._matrices.size <= self._options.dense_limit:
            self.search(middle, plain)
            return self._found(0.0, bounded=True)
        field = self._first_field()
        radius = distance_of_cone(top, middle, field)
        if radius <= _AROUND * plain:
            self.search(middle, max(plain, radius))
            if not self.odd():
                return self._found(field.depth, bounded=field.bounded)
        else:
            self.search(middle, plain)
        bounded, reached = field.bounded, -top
        depth = field.depth if bounded else _DEEP * top
        for _ in range(self._options.max_discs):
            centre, left = touching_disc(top, depth), depth if bounded else _REACHED * depth
            self.search(centre, distance_within(top, centre, -left, -reached))
            reached, depth = left, _FARTHER * depth
            bounded = bounded or self._bounds(reached)
            if bounded and not self.odd(self.discs[-1].centre):
                break
        if self._turned is not None:
            self._turned.free()
        for low, high in pairwise(sorted(self._parities)):  # a real one between two shifts
            if self.odd(low) != self.odd(high):
                self.search(0.5 * (low + high), 0.5 * (high - low))
        return self._found(reached, bounded=bounded)

    def _found(self, depth: float, *, bounded: bool, counted: int | None = None) -> Found:
        assert self.known is not None
        growth = np.inf if self.known.whole else float(np.sqrt(max(depth, 0.0)))
        bounded = bounded or self.known.whole
        odd = counted is None and self.odd()
        return Found(self.known, tuple(self.discs), growth, bounded, odd, counted)

    def _first_field(self) -> FieldOfValues:
        """How far friction moves eigenvalues near the window: what its first disc rests on.

        That of what lies near the contacts is the wider one, and known sooner.
        """
        top, near = self._top, self._near_contact
        with self._timer("factorisation"):
            self.factorisations += 1
            if near is not None and has_cone(near):
                field, middle = field_of_values(near, _DEPTH * top, cone=True), 0.5 * top
                if distance_of_cone(top, middle, field) <= _AROUND * (upper_end(top) - middle):
                    return field
            return field_of_values(self._matrices, _DEPTH * top, cone=True)

    def _bounds(self, depth: float) -> bool:
        """Whether nothing of the window has Re kappa < -depth: by as few tests as show it."""
        with self._timer("factorisation"):
            self.factorisations += 1
            if field_of_values(self._matrices, depth).bounded:
                return True
            try:
                if self._turns and self._turned is None:
                    self.factorisations += 2
                    self._turned = TurnedField.of(self._matrices)
                self._turns = self._turned is not None
                self.factorisations += self._turns
                return self._turned is not None and self._turned.bounds(self._top, depth)
            except ConvergenceError:  # what shows nothing must not end what was found
                self._turns = False
                return False


class DampedSearch(WindowSearch):
    """Searches of (lambda^2 M + lambda (C + Y) + K) x = 0.

    Parameters
    ----------
    matrices, end, options, timer
        Those of :class:`WindowSearch`.
    decay
        d (1/s); None takes a tenth of omega, or less where modes crowd.

    Attributes
    ----------
    decay
        d (1/s), once the window was searched.
    """

    def __init__(
        self,
        matrices: Matrices,
        end: float,
        options: KrylovOptions,
        timer: StageTimer,
        decay: float | None,
    ) -> None:
        super().__init__(matrices, end, options, timer)
        self._asked = decay is not None
        self.decay = _DECAY * end if decay is None else decay

    def run(self) -> Found:
        """A window of any growth, down to a decay."""
        from cea.eigen.quadratic_coverage import first_shift, largest_growth

        end = self._end
        with self._timer("factorisation"):
            self.factorisations += 2
            largest = largest_growth(self._matrices, end)
        centre = self._not_crowded(first_shift(largest, -self.decay, end))
        growth = 2 * centre + self.decay
        while not (bounded := self.whole or growth >= largest or self._bounded(growth)) or self.odd(
            self.discs[-1].centre
        ):
            if len(self.discs) > self._options.max_discs:
                break
            left, centre = growth, _FARTHER * centre
            try:
                self.search(centre, self._radius(centre, left))
            except CrowdedError:
                break
            growth = 2 * centre - left
        assert self.known is not None
        growth = np.inf if self.whole else growth
        return Found(self.known, tuple(self.discs), growth, bounded, self.odd())

    def _operator(self, shift: float) -> Undamped:
        return Companion(self._matrices, shift, self._end, decay=self.decay)

    def _beyond(self, values: Complexes, shift: float) -> int:
        return int(np.sum(values.real > shift))

    def _radius(self, centre: float, left: float) -> float:
        """Radius of a disc that holds the window to the right of a real part."""
        return float(np.hypot(centre - left, (1 + MARGIN) * self._end))

    def _not_crowded(self, centre: float) -> float:
        """Search the first disc; the real part of its shift.

        Overdamped modes may crowd at one rate of decay. From farther to the right a disc reaches
        less beyond the decay asked for; where that does not help it is reduced, if nobody asked.
        """
        most = sys.maxsize
        if self._matrices.size > self._options.dense_limit:  # else any number is affordable
            self.factorisations += 1
            with self._timer("factorisation"):
                most = _CROWDED * count_below(self._matrices, self._end**2) + _FEW
        for _ in range(_ATTEMPTS):
            try:
                self.search(centre, self._radius(centre, -self.decay), most)
                return self.discs[0].centre
            except CrowdedError as error:
                crowded = error
            self.free()
            if centre >= _SLIM * self._end and not self._asked:
                self.decay /= _AWAY
            centre *= _AWAY
        raise ConvergenceError(
            f"{crowded}: modes crowd near or above the growth rate {-self.decay:.4g} 1/s; a higher "
            "min_growth leaves them out"
        )

    def _bounded(self, growth: float) -> bool:
        """Whether no eigenvalue of the window grows at a rate or faster."""
        from cea.eigen.quadratic_coverage import bounded_growth

        self.factorisations += 1
        with self._timer("factorisation"):
            return bounded_growth(self._matrices, growth, self._end)
