"""Searches of discs about real shifts for eigenvalues, one beside the other.

Modes that earlier discs hold are locked while a disc is searched. A plan tells the discs: those of
a window (:mod:`cea.eigen.window`), or one about a place.
"""

import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator

import numpy as np

from cea.arrays import Complexes
from cea.eigen.errors import SAME
from cea.eigen.krylov_schur import CrowdedError, KrylovOptions, krylov_schur
from cea.eigen.mumps import SingularError
from cea.eigen.pencil import Matrices
from cea.eigen.regions import Disc
from cea.eigen.shift_invert import Companion, ShiftInvert
from cea.eigen.spectrum import Window
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


class Search(ABC):
    """Searches of discs for eigenvalues of a pencil at given parameters, in units of omega (1/s).

    Attributes
    ----------
    found, discs
        Invariant subspace of the eigenvalues found, of the companion form where something damps,
        and the discs that were searched.
    factorisations
        Factorisations made so far.
    """

    def __init__(
        self, matrices: Matrices, end: float, options: KrylovOptions, timer: StageTimer
    ) -> None:
        self._matrices, self._end, self._options, self.timer = matrices, end, options, timer
        self.found: InvariantSubspace | None = None
        self.discs: list[Disc] = []
        self.factorisations = 0
        self.reach, self.decay = end, np.inf  # ends of the window (1/s)
        self._op: ShiftInvert | None = None
        self._parities: dict[float, int] = {}
        self._most, self._crowded, self._verify = sys.maxsize, "", True

    def run(self) -> InvariantSubspace:
        """Every eigenvalue that is asked for.

        ConvergenceError when a disc cannot be searched; ``best`` is the invariant subspace so far.
        """
        for centre, radius in self._plan():
            for attempt in range(ATTEMPTS):  # a shift steps aside where it is an eigenvalue
                step = attempt * _ASIDE
                shift = centre * (1 + step)
                reach = radius if callable(radius) else radius + step * abs(centre)
                try:
                    op = self.at(shift)
                    with self.timer("krylov"):
                        self.found = krylov_schur(
                            op,
                            reach,
                            self._options,
                            self.found,
                            seed=len(self.discs),
                            most=self._most,
                            verify=self._verify,
                        )
                except SingularError:
                    self._parities.pop(shift, None)
                    continue
                except CrowdedError as error:
                    self._crowded = str(error)
                else:
                    self._crowded = ""
                    self.discs.append(Disc(shift, np.inf if callable(reach) else reach))
                break
            else:
                raise ConvergenceError(
                    f"the pencil is singular at every shift near {centre:.4g}", best=self.found
                )
        assert self.found is not None
        return self.found

    @abstractmethod
    def _plan(self) -> Iterator[tuple[float, float | Radius]]:
        """Centre and radius of each disc, once that before it was searched."""

    @abstractmethod
    def window(self, values: Complexes) -> Window:
        """What was searched, and why it is believed complete, given all eigenvalues found."""

    def at(self, shift: float) -> ShiftInvert:
        """The operator at a shift; that before it is freed."""
        if self._op is None or self._op.shift != shift:
            self._free_operator()
            self.factorisations += 1
            kind = Companion if self._matrices.quadratic else ShiftInvert
            with self.timer("factorisation"):
                self._op = kind(self._matrices, shift, self._end, self.reach, self.decay)
            if (parity := self._op.factors.parity()) is not None:
                self._parities[shift] = parity
        return self._op

    @property
    def near(self) -> ShiftInvert:
        """An operator near the window, by which errors are estimated."""
        near = [each.centre for each in self.discs[:2]]
        if self._op is not None and (not near or self._op.shift in near):
            return self._op
        return self.at(self.discs[0].centre)

    def odd(self, shift: float | None = None) -> bool:
        """Whether signs of determinants show another real eigenvalue beyond a shift, or any."""
        if self.found is None:
            return False
        values = self.found.eigenvalues.real
        chosen = self._parities if shift is None else {shift} & self._parities.keys()
        sign = 1 if self._matrices.quadratic else -1
        return any(self._parities[s] != np.sum(sign * (values - s) > 0) % 2 for s in chosen)

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
                found = krylov_schur(op, _INSIDE * farthest, self._options, found, seed=len(values))
        assert found is not None
        return found.eigenpairs(rows)

    def free(self) -> None:
        """Free the factors."""
        self._free_operator()

    def _free_operator(self) -> None:
        if self._op is not None:
            self._op.free()
            self._op = None


class NearestSearch(Search):
    """Searches of the few eigenvalues nearest to a place.

    The place is a real kappa (1/s^2); with damping or rotation lambda with Im lambda >= 0 (1/s),
    not zero, and the disc about a real shift holds the disc about it, and more. A few more than
    ``wanted`` may come, with damping of those with Im lambda >= 0.
    """

    def __init__(
        self,
        matrices: Matrices,
        place: complex,
        wanted: int,
        options: KrylovOptions,
        timer: StageTimer,
    ) -> None:
        super().__init__(matrices, abs(place) if matrices.quadratic else np.inf, options, timer)
        self._place, self._wanted = place, min(wanted, matrices.size - matrices.tied)
        self.reach, self._verify = np.inf, False

    def _plan(self) -> Iterator[tuple[float, Radius]]:
        damped, place = self._matrices.quadratic, self._place
        yield SHIFT * abs(place) if damped else place.real, self._radius

    def _radius(self, shift: float, theta: Complexes) -> float:
        values = shift + 1 / theta
        chosen = values[values.imag >= 0] if self._matrices.quadratic else values
        if len(chosen) < self._wanted:
            return np.inf
        farthest = np.sort(np.abs(chosen - self._place))[self._wanted - 1]
        return _EDGE * float(abs(self._place - shift) + farthest)

    def window(self, values: Complexes) -> Window:
        """No window: the eigenvalues that were found."""
        shift = self.near.shift
        largest = float(np.abs(values).max(initial=abs(shift)))
        return Window(
            max_frequency=largest / (2 * np.pi) if self._matrices.quadratic else np.inf,
            shift=shift,
            radius=float(np.abs(values - self._place).max(initial=0.0)),
            found=len(values),
            neighbours=True,
        )
