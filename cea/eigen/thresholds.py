"""Thresholds of flutter: friction at which two modes coalesce.

With friction s F the pencil (S - s F) x = kappa M x has two real eigenvalues on one side of a
threshold and a conjugate pair on the other. At the threshold, an exceptional point, they behave
like square roots of s, and rounding takes half their digits. The discriminant of the pair,

    d(s) = (kappa_1 - kappa_2)^2,

and its mean are analytic there: d is real and passes through zero at a finite slope, from positive
to negative where flutter begins. Its root holds all digits, and on a mesh it converges as
eigenvalues do (Kato, Perturbation Theory for Linear Operators, sec. II.1).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from cea.body import Floats
from cea.eigen.krylov_schur import solve_modes
from cea.eigen.modes import Modes
from cea.errors import ConvergenceError, InputError
from cea.system.coupled import CoupledSystem

_NOT_A_PAIR = 1e-6
"""Imaginary part of a discriminant, relative to its modulus, beyond which two eigenvalues are
neither both real nor conjugate."""
_LEAST_PART = 0.5
"""Least part of a mode in the span of the pair it is taken to continue."""
_INDEPENDENT = 1e-8
"""Least ratio of squared lengths across and along two vectors that span a plane."""


@dataclass(frozen=True)
class FrictionFamily:
    """Systems that differ by a factor of their friction, assembled once.

    Parameters
    ----------
    stiffness
        Symmetric part S = K + K_n, PETSc AIJ (N/m).
    mass
        M, PETSc AIJ (kg).
    friction
        F, the friction matrix K_f at factor 1, PETSc AIJ (N/m).
    max_frequency
        Upper end of the modes followed (Hz).
    """

    stiffness: Any
    mass: Any
    friction: Any
    max_frequency: float

    @classmethod
    def of(cls, system: CoupledSystem, max_frequency: float) -> "FrictionFamily":
        """Family of a coupled system: factor 1 is its own friction.

        Raises
        ------
        InputError
            When the system has no friction matrix.
        """
        friction = system.friction()
        if friction is None:
            raise InputError("mu", 0.0, "friction on a contact in penalty form")
        return cls(system.symmetric_stiffness(), system.mass, friction, max_frequency)

    def modes(self, factor: float) -> Modes:
        """Modes with so many times the friction."""
        friction = self.friction.copy()
        friction.scale(factor)
        try:
            return solve_modes(
                self.stiffness, self.mass, friction, max_frequency=self.max_frequency
            )
        finally:
            friction.destroy()


@dataclass(frozen=True)
class Threshold:
    """A coalescence of two modes.

    Parameters
    ----------
    factor
        Factor of the friction there.
    eigenvalue
        Their common lambda (1/s).
    solves
        Eigenvalue problems solved.
    """

    factor: float
    eigenvalue: complex
    solves: int

    @property
    def frequency(self) -> float:
        """Frequency (Hz)."""
        return self.eigenvalue.imag / (2 * np.pi)


def flutter_threshold(
    family: FrictionFamily,
    real: float,
    flutter: float,
    *,
    frequency: float | None = None,
    tolerance: float = 1e-12,
) -> Threshold:
    """Where a pair of modes begins to flutter, or ceases to.

    Parameters
    ----------
    family
        Systems by factor of friction.
    real, flutter
        Factors on either side of the threshold: the pair is real at one and flutters at the other.
        Which is the larger does not matter.
    frequency
        The growing mode at ``flutter`` nearest to this frequency (Hz) is followed; None follows
        the fastest.
    tolerance
        Error of the factor relative to ``flutter``.

    Raises
    ------
    InputError
        When no mode grows at ``flutter``, or the pair that does is not real at ``real``.
    ConvergenceError
        When the pair is lost on the way: the factors are too far apart.
    """
    for name, factor in (("real", real), ("flutter", flutter)):
        if not 0 <= factor < np.inf:
            raise InputError(name, factor, "zero or more")
    follower = _Follower(family)
    follower.start(flutter, frequency)
    if not follower.discriminant(real) > 0:
        raise InputError("real", real, f"a factor at which the pair growing at {flutter} is real")
    factor = float(brentq(follower.discriminant, real, flutter, xtol=tolerance * flutter))
    follower.discriminant(factor)
    return Threshold(factor, complex(np.sqrt(-follower.mean + 0j)), follower.solves)


class _Follower:
    """One pair of modes from factor to factor, known by the invariant subspace of its modes.

    The subspace, unlike the modes, turns smoothly with friction through a coalescence.
    """

    def __init__(self, family: FrictionFamily) -> None:
        self._family = family
        self._known: list[tuple[float, Floats]] = []
        self.mean = 0.0
        self.solves = 0

    def start(self, factor: float, frequency: float | None) -> None:
        """Choose the pair of a growing mode."""
        modes = self._solve(factor)
        growing = np.flatnonzero(modes.unstable())
        if not len(growing):
            raise InputError("flutter", factor, "a factor at which a mode grows")
        if frequency is None:
            chosen = growing[np.argmax(modes.growth_rates[growing])]
        else:
            chosen = growing[np.argmin(np.abs(modes.frequencies[growing] - frequency))]
        vector = modes.vectors[:, chosen]
        self._remember(factor, np.column_stack([vector.real, vector.imag]))

    def discriminant(self, factor: float) -> float:
        """(kappa_1 - kappa_2)^2 of the pair (1/s^4), positive while it is real."""
        modes = self._solve(factor)
        pair = self._continued(factor, modes)
        kappa = -(modes.eigenvalues[pair] ** 2)
        square = complex((kappa[0] - kappa[1]) ** 2)
        if abs(square.imag) > _NOT_A_PAIR * abs(square):
            raise ConvergenceError(
                f"the pair is lost at factor {factor:.6g}: {kappa[0]:.6g} and {kappa[1]:.6g} are "
                "neither real nor conjugate; take factors nearer to each other"
            )
        self.mean = float(kappa.mean().real)
        self._remember(factor, _real_basis(modes, pair))
        return square.real

    def _solve(self, factor: float) -> Modes:
        self.solves += 1
        return self._family.modes(factor)

    def _remember(self, factor: float, vectors: Floats) -> None:
        """Keep M Q with Q an M-orthonormal basis of two vectors.

        At its coalescence a pair spans one direction only and is not worth keeping.
        """
        images = self._times_mass(vectors)
        size, axes = np.linalg.eigh(self._sum(vectors.T @ images))
        if size[0] > _INDEPENDENT * size[1]:
            self._known.append((factor, images @ (axes / np.sqrt(size))))

    def _continued(self, factor: float, modes: Modes) -> NDArray[np.int64]:
        """The two modes with the greatest parts in the subspace known at the nearest factor."""
        _, image = min(self._known, key=lambda known: abs(known[0] - factor))
        part = np.linalg.norm(self._sum(image.T @ modes.vectors), axis=0)
        pair = np.argsort(part)[-2:]
        if len(pair) < 2 or part[pair].min() < _LEAST_PART:
            raise ConvergenceError(
                f"the pair is lost at factor {factor:.6g}: no two modes continue it; take a "
                "narrower bracket or a higher max_frequency"
            )
        return pair

    def _times_mass(self, vectors: Floats) -> Floats:
        mass = self._family.mass
        given, image = mass.createVecs()
        columns = []
        for vector in vectors.T:
            given.array[:] = vector
            mass.mult(given, image)
            columns.append(np.array(image.array))
        given.destroy()
        image.destroy()
        return np.column_stack(columns)

    def _sum(self, local: NDArray) -> NDArray:
        """Sum over ranks."""
        return self._family.mass.comm.tompi4py().allreduce(local)


def _real_basis(modes: Modes, pair: NDArray[np.int64]) -> Floats:
    """Real vectors that span the modes of a pair, be it real or conjugate."""
    first, second = modes.vectors[:, pair].T
    if (modes.eigenvalues[pair[0]] ** 2).imag != 0:
        return np.column_stack([first.real, first.imag])
    return np.column_stack([first.real, second.real])
