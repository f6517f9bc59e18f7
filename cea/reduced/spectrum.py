"""Eigenvalues of a reduced model, with bounds on how far they are from those of the pencil.

A window and its margin are known to a basis; what lies in the margin helps to judge the rest. For a
right vector x and a left vector y of the reduced model, of M-norm one, with residuals r and s,

    |kappa - kappa_pencil| <= c g |r| |s|,    c = 1 / |y^H M x|,

norms in X^-1. It is of second order because r and s vanish on the basis (Galerkin). The factor g
stands for the inverse of the pencil outside of the basis, where no eigenvalue lies below the end
kappa_m of the margin: g = (kappa_m + s) / (kappa_m - Re kappa), taken twice. Friction adds to that
inverse what no factor bounds beforehand; full solves test it (:mod:`cea.reduced.greedy`).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, solve_triangular

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.modes import uncertainties_of
from cea.eigen.spectrum import SLOW
from cea.reduced.certificate import Certificate, certify
from cea.reduced.products import real_times
from cea.reduced.residuals import Residuals
from cea.reduced.rounding import Rounding
from cea.reduced.saddle import Inverse, Saddle

MARGIN = 1.15
"""Frequency up to which eigenvectors are taken into a basis, relative to the end of the window."""
_FURTHER = 0.05
"""Decay beyond that of the window, relative to its end, down to which they are."""
_SAFETY = 2.0
"""Factor on the inverse outside of the basis."""


@dataclass(frozen=True)
class Settings:
    """What bounds are made with.

    Parameters
    ----------
    max_frequency
        Upper end of the window (Hz).
    shift
        s (1/s^2) of the energy norm.
    safety
        Factor on the inverse outside of the basis.
    decay
        Decay (1/s) down to which eigenvalues of damped pencils are in the window.
    """

    max_frequency: float
    shift: float
    safety: float = _SAFETY
    decay: float = np.inf

    @property
    def end(self) -> float:
        """Upper end of the window (1/s)."""
        return 2 * np.pi * self.max_frequency

    @property
    def reach(self) -> float:
        """Decay (1/s) down to which eigenvectors of damped pencils are taken into a basis."""
        return self.decay + _FURTHER * self.end

    def holds(self, eigenvalues: Complexes) -> NDArray[np.bool_]:
        """Which eigenvalues lambda, Im lambda >= 0, the window holds."""
        return (eigenvalues.imag <= self.end) & (eigenvalues.real >= -self.decay)

    def outside(self, kappa: Complexes) -> Floats:
        """G of eigenvalues, shape (n,): infinite at the end of the margin."""
        top = (MARGIN * self.end) ** 2
        room = top - np.minimum(kappa.real, self.end**2)
        return self.safety * (top + self.shift) / room

    def outside_damped(self, eigenvalues: Complexes) -> Floats:
        """G of eigenvalues lambda of a damped pencil, shape (n,).

        Modes that decay faster than the basis reaches are outside of it too. Where one has the
        frequency of an eigenvalue, P on it is about 2 |lambda| times their distance.
        """
        speeds = np.abs(eigenvalues)
        room = self.reach + np.maximum(eigenvalues.real, -self.decay)
        decaying = (speeds**2 + self.shift) / np.maximum(2 * speeds, SLOW * self.end) / room
        return np.maximum(self.outside(-(eigenvalues**2)), self.safety * decaying)


@dataclass(frozen=True)
class ReducedSpectrum:
    """Eigenvalues of a window, by rising frequency.

    Parameters
    ----------
    kappa
        -lambda^2 (1/s^2), shape (n,).
    eigenvalues
        lambda (1/s), Im lambda >= 0, shape (n,).
    right, left
        Coordinates of their vectors, shape (k, n), of M-norm one.
    certificate
        Bounds on their errors.
    settings
        What they were made with.
    forces, left_forces
        Coordinates of their contact forces, shape (m, n).
    """

    kappa: Complexes
    eigenvalues: Complexes
    right: Complexes
    left: Complexes
    certificate: Certificate
    settings: Settings
    forces: Complexes
    left_forces: Complexes

    def __len__(self) -> int:
        return len(self.kappa)

    def __getitem__(self, modes: Ints) -> "ReducedSpectrum":
        return ReducedSpectrum(
            self.kappa[modes],
            self.eigenvalues[modes],
            self.right[:, modes],
            self.left[:, modes],
            self.certificate[modes],
            self.settings,
            self.forces[:, modes],
            self.left_forces[:, modes],
        )

    @property
    def window(self) -> "ReducedSpectrum":
        """Those of the window, without its margin."""
        return self[np.flatnonzero(self.inside)]

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Which are in the window, shape (n,)."""
        return self.settings.holds(self.eigenvalues)

    @property
    def speeds(self) -> Floats:
        """abs(lambda), no less than a tenth of the window (1/s): what errors are relative to."""
        return np.maximum(np.abs(self.eigenvalues), SLOW * self.settings.end)

    @property
    def uncertainties(self) -> Floats:
        """Bounds on errors of lambda (1/s), shape (n,)."""
        return uncertainties_of(self.eigenvalues, self.certificate.errors)

    @property
    def worst(self) -> float:
        """Largest error of a cluster's mean in the window that the basis makes, as `bound` has it.

        Rounding is left aside: a larger basis does not help against it.
        """
        return self._largest(self.certificate.reduction)

    @property
    def bound(self) -> float:
        """Largest error of a cluster's mean in the window, of lambda relative to its speed.

        Infinite where there is no basis.
        """
        return self._largest(self.certificate.means)

    def _largest(self, errors: Floats) -> float:
        if not len(self.right):
            return np.inf
        return float((errors / (2 * self.speeds**2))[self.inside].max(initial=0.0))

    def lifted(self, axes: Floats) -> "ReducedSpectrum":
        """With coordinates in the basis that a local one was taken from."""
        return replace(self, right=real_times(axes, self.right), left=real_times(axes, self.left))


def upper_root(kappa: Complexes) -> Complexes:
    """The lambda = sqrt(-kappa) with Im lambda >= 0; it grows where lambda is real."""
    root = np.sqrt(-kappa.astype(complex))
    return np.where(root.imag < 0, -root, root) + 0j


def reduced_spectrum(
    stiffness: Residuals,
    mass: Residuals,
    settings: Settings,
    rounding: Rounding,
    saddle: Saddle | None,
) -> ReducedSpectrum:
    """Eigenvalues of a window and its margin.

    Parameters
    ----------
    stiffness, mass
        The reduced matrices.
    settings
        What bounds are made with.
    rounding
        What rounding does to eigenvalues.
    saddle
        Contacts whose forces are unknowns.
    """
    k, M = len(mass.square), mass.square
    if not k:
        return without_a_basis(settings)
    root = np.linalg.cholesky(M)
    inverse = Inverse(stiffness.square + settings.shift * M, saddle)
    theta, left, right = eig(root.T @ inverse(root), left=True, right=True)
    with np.errstate(divide="ignore"):
        kappa = 1 / theta - settings.shift
    eigenvalues = upper_root(kappa)
    order = np.lexsort((eigenvalues.real, eigenvalues.imag))
    order = order[eigenvalues.imag[order] <= MARGIN * settings.end]
    kappa, eigenvalues = kappa[order], eigenvalues[order]
    right = solve_triangular(root, right[:, order], lower=True, trans="T")
    left = solve_triangular(root, left[:, order], lower=True, trans="T")
    if saddle is not None:
        speeds = kappa + settings.shift
        right = inverse.extended(right, M @ right * speeds)
        left = inverse.extended_left(left, M @ left * speeds.conj())
        stiffness, mass = saddle.with_stiffness(stiffness), saddle.beside(mass)
    outside = settings.outside(kappa)
    certificate = certify(kappa, right, left, stiffness, mass, outside, rounding)
    vectors = right[:k], left[:k]
    return ReducedSpectrum(kappa, eigenvalues, *vectors, certificate, settings, right[k:], left[k:])


def without_a_basis(settings: Settings) -> ReducedSpectrum:
    """What a basis without vectors knows."""
    none, vectors = np.empty(0), np.empty((0, 0), dtype=complex)
    certificate = Certificate(none, none, none, np.empty(0, dtype=np.int64), none)
    nothing = none.astype(complex)
    return ReducedSpectrum(
        nothing, nothing, vectors, vectors, certificate, settings, vectors, vectors
    )
