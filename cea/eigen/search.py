"""Search for eigenvalues in a sequence of discs about real shifts.

Eigenvalues found in earlier discs are locked while a disc is searched. The discs cover a window
(:mod:`cea.eigen.window`), or are a single one that holds the eigenvalues nearest to a target.
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
"""Relative step of a shift away from an eigenvalue, and largest number of shifts tried."""
SHIFT = 0.25
"""Real shift relative to omega where growth may be large, or to the modulus of a target."""
_INSIDE = 1 + SAME
"""Radius of a disc of left eigenvalues relative to the farthest right eigenvalue in it. The margin
allows for rounding, which is large for rigid body modes and near coalescence."""
_EDGE = 1 + 1e-9
"""Radius of a disc relative to the farthest eigenvalue in it, so that its conjugate is inside."""


class Search:
    """Search of discs for the eigenvalues of a pencil at given parameters, scaled by omega (1/s).

    Attributes
    ----------
    found, discs
        Invariant subspace of the eigenvalues found (of the companion form with damping or
        rotation), and the discs that were searched.
    factorisations
        Number of factorisations so far.
    scale
        Size of eigenvalues lambda (1/s): omega, or less where the window is far wider than needed.
    reach, decay
        Ends of the window (1/s): Im lambda <= reach and Re lambda >= -decay. Infinite where every
        eigenvalue of a disc is wanted.
    growth, bounded
        Growth rate (1/s) up to which every eigenvalue of the window was found, and whether it was
        shown that none grows faster.
    counted
        Number of eigenvalues below the end of the window by inertia; None with friction or damping.
    most, crowded
        Largest number of eigenvalues for which a disc is searched, and the message of the last
        disc that exceeded it.
    """

    def __init__(
        self, matrices: Matrices, end: float, options: KrylovOptions, timer: StageTimer
    ) -> None:
        self.matrices, self.end, self.options, self.timer = matrices, end, options, timer
        self.found: InvariantSubspace | None = None
        self.discs: list[Disc] = []
        self.factorisations = 0
        self.scale, self.reach, self.decay = end, np.inf, np.inf
        self.growth, self.bounded = 0.0, False
        self.counted: int | None = None
        self.most, self.crowded = sys.maxsize, ""
        self.parities: dict[float, int] = {}
        self._op: ShiftInvert | None = None

    def run(self, plan: Iterable[tuple[float, float | Radius]]) -> InvariantSubspace:
        """Search discs given by centre and radius; a shift next to an eigenvalue is moved.

        ConvergenceError when a search fails; its ``best`` is the invariant subspace found so far.
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
        """Time and count a number of factorisations."""
        self.factorisations += number
        with self.timer("factorisation"):
            yield

    def at(self, shift: float) -> ShiftInvert:
        """Return the operator at a shift, and free the previous one."""
        if self._op is None or self._op.shift != shift:
            self.free()
            kind = Companion if self.matrices.quadratic else ShiftInvert
            with self.factorising():
                self._op = kind(self.matrices, shift, self.scale, self.reach, self.decay)
            if (parity := self._op.factors.parity()) is not None:
                self.parities[shift] = parity
        return self._op

    @property
    def near(self) -> ShiftInvert:
        """Operator at the shift of one of the first two discs, used for error estimates."""
        near = [each.centre for each in self.discs[:2]]
        if self._op is not None and (not near or self._op.shift in near):
            return self._op
        return self.at(near[0])

    def odd(self, shift: float | None = None) -> bool:
        """Whether the sign of a determinant shows that a real eigenvalue beyond a shift is missing.

        Without a shift: beyond any of those factorised.
        """
        if self.found is None:
            return False
        values = self.found.eigenvalues.real
        chosen = self.parities if shift is None else {shift} & self.parities.keys()
        sign = 1 if self.matrices.quadratic else -1
        return any(self.parities[s] != np.sum(sign * (values - s) > 0) % 2 for s in chosen)

    def left(self, rows: int) -> tuple[Complexes, Complexes]:
        """Return the left eigenvalues of all found, and the first rows of their vectors.

        They are eigenvalues and vectors of the transposed pencil.
        """
        assert self.found is not None
        values, found = self.found.eigenvalues, None
        beyond = [np.abs(values - disc.centre) - disc.radius for disc in self.discs]
        nearest = np.argmin(beyond, axis=0)  # some eigenvalues converged outside of all discs
        waiting = np.ones(len(values), dtype=bool)
        for number, disc in enumerate(self.discs):
            distances = np.abs(values - disc.centre)
            inside = self.found.whole | (distances < disc.radius * _INSIDE) | (nearest == number)
            if found is not None and not (inside & waiting).any():
                continue  # earlier discs hold them
            waiting &= ~inside
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
    """Yield the disc that holds the ``wanted`` eigenvalues nearest to a target, the ``place``.

    The target is a real kappa (1/s^2), or with damping or rotation a nonzero lambda (1/s) with
    Im lambda >= 0; the disc about a real shift then contains the disc about the target. It may
    hold a few more eigenvalues than ``wanted``; with damping those with Im lambda >= 0 count.
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
