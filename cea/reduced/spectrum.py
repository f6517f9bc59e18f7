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
from scipy.linalg import eig, lu_factor, lu_solve, solve_triangular

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.modes import uncertainties_of
from cea.eigen.spectrum import SLOW
from cea.reduced.certificate import Certificate, certify

MARGIN = 1.15
"""Frequency up to which eigenvectors are taken into a basis, relative to the end of the window."""
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
    """

    max_frequency: float
    shift: float
    safety: float = _SAFETY

    @property
    def end(self) -> float:
        """Upper end of the window (1/s)."""
        return 2 * np.pi * self.max_frequency

    def outside(self, kappa: Complexes) -> Floats:
        """G of eigenvalues, shape (n,): infinite at the end of the margin."""
        top = (MARGIN * self.end) ** 2
        room = top - np.minimum(kappa.real, self.end**2)
        return self.safety * (top + self.shift) / room


@dataclass(frozen=True)
class Residuals:
    """K or M of a reduced model at given parameters, with what its residuals need.

    Parameters
    ----------
    square
        V^T A V, shape (k, k).
    right, left
        Q^T A V and Q^T A^T V, shape (q, k).
    lost
        Norm of what these leave out.
    """

    square: Floats
    right: Floats
    left: Floats
    lost: float


@dataclass(frozen=True)
class ReducedSpectrum:
    """Eigenvalues kappa = -lambda^2 of a window, by rising frequency.

    Parameters
    ----------
    kappa
        Eigenvalues (1/s^2), shape (n,).
    right, left
        Coordinates of their vectors, shape (k, n), of M-norm one.
    certificate
        Bounds on their errors.
    settings
        What they were made with.
    """

    kappa: Complexes
    right: Complexes
    left: Complexes
    certificate: Certificate
    settings: Settings

    def __len__(self) -> int:
        return len(self.kappa)

    def __getitem__(self, modes: Ints) -> "ReducedSpectrum":
        return ReducedSpectrum(
            self.kappa[modes],
            self.right[:, modes],
            self.left[:, modes],
            self.certificate[modes],
            self.settings,
        )

    @property
    def eigenvalues(self) -> Complexes:
        """Lambda (1/s), Im lambda >= 0, shape (n,)."""
        return upper_root(self.kappa)

    @property
    def window(self) -> "ReducedSpectrum":
        """Those of the window, without its margin."""
        return self[np.flatnonzero(self.eigenvalues.imag <= self.settings.end)]

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
        """Largest error of a cluster's mean in the window, of lambda relative to its speed.

        It is what the basis makes; rounding is left aside. Infinite where there is no basis.
        """
        if not len(self.right):
            return np.inf
        window = self.window
        return float((window.certificate.reduction / (2 * window.speeds**2)).max(initial=0.0))

    def lifted(self, axes: Floats) -> "ReducedSpectrum":
        """With coordinates in the basis that a local one was taken from."""
        return replace(self, right=axes @ self.right, left=axes @ self.left)


def upper_root(kappa: Complexes) -> Complexes:
    """The lambda = sqrt(-kappa) with Im lambda >= 0; it grows where lambda is real."""
    root = np.sqrt(-kappa.astype(complex))
    return np.where(root.imag < 0, -root, root) + 0j


def reduced_spectrum(
    stiffness: Residuals, mass: Residuals, settings: Settings, rounding: float
) -> ReducedSpectrum:
    """Eigenvalues of a window and its margin.

    Parameters
    ----------
    stiffness, mass
        The reduced matrices.
    settings
        What bounds are made with.
    rounding
        What rounding does to eigenvalues of condition one (1/s^2).
    """
    if not len(mass.square):
        return _nothing(settings)
    root = np.linalg.cholesky(mass.square)
    factors = lu_factor(stiffness.square + settings.shift * mass.square)
    theta, left, right = eig(root.T @ lu_solve(factors, root), left=True, right=True)
    with np.errstate(divide="ignore"):
        kappa = 1 / theta - settings.shift
    eigenvalues = upper_root(kappa)
    order = np.lexsort((eigenvalues.real, eigenvalues.imag))
    order = order[eigenvalues.imag[order] <= MARGIN * settings.end]
    kappa = kappa[order]
    right = solve_triangular(root, right[:, order], lower=True, trans="T")
    left = solve_triangular(root, left[:, order], lower=True, trans="T")
    outside = settings.outside(kappa)
    certificate = certify(kappa, right, left, stiffness, mass, outside, rounding)
    return ReducedSpectrum(kappa, right, left, certificate, settings)


def _nothing(settings: Settings) -> ReducedSpectrum:
    """What a basis without vectors knows."""
    none, vectors = np.empty(0), np.empty((0, 0), dtype=complex)
    certificate = Certificate(none, none, none, np.empty(0, dtype=np.int64), none)
    return ReducedSpectrum(none.astype(complex), vectors, vectors, certificate, settings)
