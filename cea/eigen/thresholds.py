"""Thresholds of flutter: values of a parameter at which two modes coalesce.

With a parameter s the pencil K(s) x = kappa M x, kappa = -lambda^2, has two real eigenvalues on one
side of a threshold and a conjugate pair on the other. At the threshold, an exceptional point, they
behave like square roots of s, and rounding takes half their digits. The discriminant of the pair,

    d(s) = (kappa_1 - kappa_2)^2,

and its mean are analytic there: d is real and passes through zero at a finite slope, from positive
to negative where flutter begins. Its root holds all digits, and on a mesh it converges as
eigenvalues do (Kato, Perturbation Theory for Linear Operators, sec. II.1).

With damping modes need not coalesce to flutter, and hardly ever do: there the growth of the fastest
mode passes through zero (:mod:`cea.eigen.growth_thresholds`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from cea.arrays import Floats
from cea.eigen.blocks import all_inner, times
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.errors import ConvergenceError, InputError
from cea.petsc import Mat
from cea.warned import ResultWarning

_NOT_A_PAIR = 1e-6
"""Imaginary part of a discriminant, relative to its modulus, beyond which two eigenvalues are
neither both real nor conjugate."""
_LEAST_PART = 0.5
"""Least part of a mode in the span of the pair it is taken to continue."""
_INDEPENDENT = 1e-8
"""Least ratio of squared lengths across and along two vectors that span a plane."""
_NEIGHBOURS = 4
"""Modes that a pair is looked for among, nearest to where it was."""
_ROOT = 1e-6
"""Discriminant at a threshold, relative to that of the real pair, beyond which it jumps there."""
_ASIDE = 1e-3
"""Relative distance from a pair at which it is looked for: a pencil is singular on it."""


@dataclass(frozen=True)
class Threshold:
    """A coalescence of two modes.

    Parameters
    ----------
    parameter
        Name of the parameter, or names of those that have the value.
    value
        Its value there.
    eigenvalue
        Their common lambda (1/s).
    solves, factorisations
        Eigenvalue problems solved and matrices factorised on the way.
    warnings
        What the value must be read with.
    """

    parameter: str
    value: float
    eigenvalue: complex
    solves: int
    factorisations: int
    warnings: tuple[ResultWarning, ...] = ()

    @property
    def frequency(self) -> float:
        """Frequency (Hz)."""
        return self.eigenvalue.imag / (2 * np.pi)


class ThresholdDriver(Protocol):
    """What solves a pencil at values of a parameter."""

    @property
    def pencil(self) -> Pencil:
        """The pencil."""
        ...

    @property
    def solves(self) -> int:
        """Eigenvalue problems solved."""
        ...

    @property
    def factorisations(self) -> int:
        """Matrices factorised for them."""
        ...

    def solve(self, max_frequency: float, changes: Mapping[str, float], /) -> Modes:
        """All modes up to a frequency (Hz)."""
        ...

    def nearest(self, kappa: float, count: int, changes: Mapping[str, float], /) -> Modes:
        """So many modes nearest to kappa (1/s^2)."""
        ...

    def quadratic(self, changes: Mapping[str, float], /) -> bool:
        """Whether the pencil is damped or rotates."""
        ...

    def mass(self, values: Mapping[str, float], /) -> Mat:
        """M, PETSc AIJ (kg)."""
        ...


def flutter_threshold(
    driver: ThresholdDriver,
    parameter: str | Sequence[str],
    real: float,
    flutter: float,
    *,
    max_frequency: float,
    frequency: float | None = None,
    tolerance: float = 1e-12,
) -> Threshold:
    """Where a pair of modes begins to flutter, or ceases to, as a parameter changes.

    Parameters
    ----------
    driver
        What solves the pencil.
    parameter
        Name of a parameter of the pencil, e.g. ``contacts.pad_disc.mu``; or of several, which have
        one value.
    real, flutter
        Values on either side of the threshold: the pair is real at one and flutters at the other.
        Which is the larger does not matter.
    max_frequency
        Upper end of the modes among which the pair is chosen (Hz).
    frequency
        The growing mode at ``flutter`` nearest to this frequency (Hz) is followed; None follows
        the fastest.
    tolerance
        Error of the value relative to ``flutter``.

    Raises
    ------
    InputError
        When there is no such parameter, no mode grows at ``flutter``, or the pair that does is not
        real at ``real``.
    ConvergenceError
        When the pair is lost on the way: the values are too far apart.
    """
    names = names_of(driver, parameter)
    for name, value in (("real", real), ("flutter", flutter)):
        if not 0 <= value < np.inf:
            raise InputError(name, value, "zero or more")
    if any(driver.quadratic(dict.fromkeys(names, value)) for value in (real, flutter)):
        raise InputError(
            "pencil",
            "with damping or rotation",
            "without: no two modes coalesce; take growth_threshold",
        )
    solves, factorisations = driver.solves, driver.factorisations
    follower = _Follower(driver, names, max_frequency)
    follower.start(flutter, frequency)
    before = follower.discriminant(real)
    if not before > 0:
        raise InputError("real", real, f"a value at which the pair growing at {flutter} is real")
    value = float(brentq(follower.discriminant, real, flutter, xtol=tolerance * max(real, flutter)))
    told = ", ".join(names)
    if abs(follower.discriminant(value)) > _ROOT * before:
        raise ConvergenceError(
            f"no two modes coalesce at {told} = {value:.6g}, where one pair was taken for "
            "another; take values nearer to each other"
        )
    return Threshold(
        told,
        value,
        complex(np.sqrt(-follower.mean + 0j)),
        driver.solves - solves,
        driver.factorisations - factorisations,
    )


def names_of(driver: ThresholdDriver, parameter: str | Sequence[str]) -> tuple[str, ...]:
    """Names of the parameters that a threshold is sought in, all of them known to a pencil.

    Raises
    ------
    InputError
        When there is no such parameter.
    """
    names = (parameter,) if isinstance(parameter, str) else tuple(parameter)
    if not names:
        raise InputError("parameter", parameter, "one or more names")
    return tuple(driver.pencil.parameter(name).name for name in names)


class _Follower:
    """One pair of modes from value to value, known by the invariant subspace of its modes.

    The subspace, unlike the modes, turns smoothly through a coalescence. The pair is looked for
    near where it was; where it is not found there, among all modes.
    """

    def __init__(
        self, driver: ThresholdDriver, names: tuple[str, ...], max_frequency: float
    ) -> None:
        self._driver = driver
        self._names, self._told = names, ", ".join(names)
        self._max_frequency = max_frequency
        self._known: list[tuple[float, Floats]] = []
        self._at = np.nan
        self.mean = 0.0

    def start(self, value: float, frequency: float | None) -> None:
        """Choose the pair of a growing mode."""
        modes = self._all(value)
        growing = np.flatnonzero(modes.unstable(0.0) & (modes.eigenvalues.imag > 0))
        if not len(growing):
            raise InputError("flutter", value, "a value at which a mode grows")
        if frequency is None:
            chosen = growing[np.argmax(modes.growth_rates[growing])]
        else:
            chosen = growing[np.argmin(np.abs(modes.frequencies[growing] - frequency))]
        vector = modes.vectors[:, chosen]
        self._remember(value, modes, np.column_stack([vector.real, vector.imag]))
        self._at = (1 + _ASIDE) * float(-(modes.eigenvalues[chosen] ** 2).real)

    def discriminant(self, value: float) -> float:
        """(kappa_1 - kappa_2)^2 of the pair (1/s^4), positive while it is real."""
        modes = self._driver.nearest(self._at, _NEIGHBOURS, self._changes(value))
        pair = self._continued(value, modes)
        if pair is None:
            modes = self._all(value)
            pair = self._continued(value, modes)
        if pair is None:
            raise ConvergenceError(
                f"the pair is lost at {self._told} = {value:.6g}: no two modes continue it; "
                "take a narrower bracket or a higher max_frequency"
            )
        kappa = -(modes.eigenvalues[pair] ** 2)
        square = complex((kappa[0] - kappa[1]) ** 2)
        if abs(square.imag) > _NOT_A_PAIR * abs(square):
            raise ConvergenceError(
                f"the pair is lost at {self._told} = {value:.6g}: {kappa[0]:.6g} and "
                f"{kappa[1]:.6g} are neither real nor conjugate; take values nearer to each other"
            )
        self.mean = float(kappa.mean().real)
        self._remember(value, modes, _real_basis(modes, pair))
        return square.real

    def _all(self, value: float) -> Modes:
        return self._driver.solve(self._max_frequency, self._changes(value))

    def _changes(self, value: float) -> dict[str, float]:
        return dict.fromkeys(self._names, value)

    def _remember(self, value: float, modes: Modes, vectors: Floats) -> None:
        """Keep M Q with Q an M-orthonormal basis of two vectors.

        At its coalescence a pair spans one direction only and is not worth keeping.
        """
        mass = self._driver.mass(modes.values)
        images = times(mass, vectors.astype(complex)).real
        size, axes = np.linalg.eigh(all_inner(vectors, images, mass.comm))
        if size[0] > _INDEPENDENT * size[1]:
            self._known.append((value, images @ (axes / np.sqrt(size))))

    def _continued(self, value: float, modes: Modes) -> NDArray[np.int64] | None:
        """The two modes with the greatest parts in the subspace known at the nearest value."""
        _, image = min(self._known, key=lambda known: abs(known[0] - value))
        overlaps = all_inner(image, modes.vectors, self._driver.pencil.comm)
        part = np.linalg.norm(overlaps, axis=0)
        pair = np.argsort(part)[-2:]
        return pair if len(pair) == 2 and part[pair].min() >= _LEAST_PART else None


def _real_basis(modes: Modes, pair: NDArray[np.int64]) -> Floats:
    """Real vectors that span the modes of a pair, be it real or conjugate."""
    first, second = modes.vectors[:, pair].T
    if (modes.eigenvalues[pair[0]] ** 2).imag != 0:
        return np.column_stack([first.real, first.imag])
    return np.column_stack([first.real, second.real])
