"""A search for eigenvalues: discs about real shifts, one beside the other.

Modes that earlier discs hold are locked while a disc is searched. It is the discs of a window
(:mod:`cea.eigen.window`) that are searched, or one about a place.
"""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np

from cea.arrays import Complexes
from cea.eigen.errors import SAME
from cea.eigen.krylov_schur import CrowdedError, KrylovOptions, krylov_schur
from cea.eigen.mumps import SingularError
from cea.eigen.pencil import Matrices
from cea.eigen.regions import Disc
from cea.eigen.shift_invert import Companion, ShiftInvert
from cea.eigen.subspace import InvariantSubspace, Radius
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_ASIDE, ATTEMPTS = 1e-3, 6
"""Step of a shift aside from an eigenvalue, relative to itself, and shifts tried at most."""
SHIFT = 0.25
"""Real shift relative to omega where growth may be large, or to the modulus of a place."""
_INSIDE = 1 + SAME
"""Radius of a disc of left eigenvalues relative to the farthest right one in it: those that are the
same but for rounding, which is large of rigid motions and near coalescence, are inside."""
_EDGE = 1 + 1e-9
"""Radius of a disc relative to the farthest eigenvalue in it: conjugates are equally far."""


class Search:
    """A search of discs for eigenvalues of a pencil at given parameters, in units of omega (1/s).

    Attributes
    ----------
    found, discs
        Invariant subspace of the eigenvalues found, of the companion form where something damps,
        and the discs that were searched.
    factorisations
        Factorisations made so far.
    reach, decay
        Ends of the window (1/s): of Im lambda, and down to which decay Re lambda; infinite where
        all that a disc holds is wanted.
    growth, bounded
        Every eigenvalue of the window that grows at this rate or slower was found (1/s), and
        whether none grows faster.
    counted
        Eigenvalues below the end of the window by inertia; None where friction or damping act.
    most, crowded
        Eigenvalues of a disc from which on it is left, and why the last one was.
    """

    def __init__(
        self, matrices: Matrices, end: float, options: KrylovOptions, timer: StageTimer
    ) -> None:
        self.matrices, self.end, self.options, self.timer = matrices, end, options, timer
        self.found: InvariantSubspace | None = None
        self.discs: list[Disc] = []
        self.factorisations = 0
        self.reach = self.decay = np.inf
        self.growth, self.bounded = 0.0, False
        self.counted: int | None = None
        self.most, self.crowded = sys.maxsize, ""
        self.parities: dict[float, int] = {}
        self._op: ShiftInvert | None = None

    def run(self, plan: Iterable[tuple[float, float | Radius]]) -> InvariantSubspace:
        """Search planned discs, by centre and radius; the shift steps aside from an eigenvalue.

        ConvergenceError when a disc cannot be searched; ``best`` is the invariant subspace so far.
        """
        for centre, radius in plan:
            for attempt in range(ATTEMPTS):
                step, number = attempt * _ASIDE, len(self.discs)
                shift = centre * (1 + step)
                reach = radius if callable(radius) else radius + step * abs(centre)
                try:
                    op, known, most = self.at(shift), self.found, self.most
                    with self.timer("krylov"):
                        self.found = krylov_schur(
                            op, reach, self.options, known, seed=number, most=most
                        )
                except SingularError:
                    self.parities.pop(shift, None)
                    continue
                except CrowdedError as error:
                    self.crowded = str(error)
                else:
                    self.crowded = ""
                    self.discs.append(Disc(shift, np.inf if callable(reach) else reach))
                break
            else:
                raise ConvergenceError(
                    f"the pencil is singular at every shift near {centre:.4g}", best=self.found
                )
        assert self.found is not None
        return self.found

    @contextmanager
    def factorising(self, number: int = 1) -> Iterator[None]:
        """Time and count matrices that are factorised."""
        self.factorisations += number
        with self.timer("factorisation"):
            yield

    def at(self, shift: float) -> ShiftInvert:
        """The operator at a shift; that before it is freed."""
        if self._op is None or self._op.shift != shift:
            self.free()
            kind = Companion if self.matrices.quadratic else ShiftInvert
            with self.factorising():
                self._op = kind(self.matrices, shift, self.end, self.reach, self.decay)
            if (parity := self._op.factors.parity()) is not None:
                self.parities[shift] = parity
        return self._op

    @property
    def near(self) -> ShiftInvert:
        """An operator near the window, by which errors are estimated."""
        near = [each.centre for each in self.discs[:2]]
        if self._op is not None and (not near or self._op.shift in near):
            return self._op
        return self.at(near[0])

    def odd(self, shift: float | None = None) -> bool:
        """Whether signs of determinants show another real eigenvalue beyond a shift, or any."""
        if self.found is None:
            return False
        values = self.found.eigenvalues.real
        chosen = self.parities if shift is None else {shift} & self.parities.keys()
        sign = 1 if self.matrices.quadratic else -1
        return any(self.parities[s] != np.sum(sign * (values - s) > 0) % 2 for s in chosen)

    def left(self, rows: int) -> tuple[Complexes, Complexes]:
        """Eigenvalues of the transposed pencil and so many rows of their vectors, of all found."""
        assert self.found is not None
        values, found = self.found.eigenvalues, None
        discs = sorted(
            self.discs, key=lambda each: self._op is None or each.centre != self._op.shift
        )
        beyond = [np.abs(values - disc.centre) - disc.radius for disc in discs]
        nearest = np.argmin(beyond, axis=0)  # some converged outside of all discs
        for number, disc in enumerate(discs):
            distances = np.abs(values - disc.centre)
            inside = self.found.whole | (distances < disc.radius * _INSIDE) | (nearest == number)
            farthest = max(float(distances[inside].max(initial=0.0)), _ASIDE * disc.radius)
            op = self.at(disc.centre).transposed()
            with self.timer("krylov"):
                found = krylov_schur(op, _INSIDE * farthest, self.options, found, seed=len(values))
        assert found is not None
        return found.eigenpairs(rows)

    def free(self) -> None:
        """Free the factors."""
        if self._op is not None:
            self._op.free()
            self._op = None


def nearest_plan(search: Search, place: complex, wanted: int) -> Iterator[tuple[float, Radius]]:
    """The disc that holds the few eigenvalues nearest to a place.

    The place is a real kappa (1/s^2); with damping or rotation lambda with Im lambda >= 0 (1/s),
    not zero, and the disc about a real shift holds the disc about it, and more. A few more than
    ``wanted`` may come, with damping of those with Im lambda >= 0.
    """
    matrices = search.matrices
    wanted = min(wanted, matrices.size - matrices.tied)

    def radius(shift: float, theta: Complexes) -> float:
        values = shift + 1 / theta
        chosen = values[values.imag >= 0] if matrices.quadratic else values
        if len(chosen) < wanted:
            return np.inf
        farthest = np.sort(np.abs(chosen - place))[wanted - 1]
        return _EDGE * float(abs(place - shift) + farthest)

    yield SHIFT * abs(place) if matrices.quadratic else place.real, radius
