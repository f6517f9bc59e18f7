"""Eigenvalues of a reduced model up to the end of a window and its margin, with their bounds.

Undamped, the inverse of the shifted stiffness is solved for 1 / (kappa + s); damped, the companion
form inverted about a real shift of growth. What lies in the margin helps to judge the rest.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, solve_triangular

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.classify import Word, cannot_grow, classify, thresholds
from cea.eigen.modes import uncertainties_of
from cea.eigen.spectrum import SLOW
from cea.reduced.certificate import Certifier, Pairs, Residuals, Rounding
from cea.reduced.saddle import Inverse, Saddle

MARGIN = 1.15
"""Frequency up to which eigenvectors are taken into a basis, relative to the end of the window."""
_FURTHER = 0.05
"""Decay beyond that of the window, relative to its end, down to which they are."""
_BELOW = 0.05
"""Part of the window below the real axis whose eigenvalues help to judge those next to it."""
_SAFETY = 2.0
"""Factor on the inverse outside of the basis."""


@dataclass(frozen=True)
class Settings:
    """What bounds are made with.

    Upper end of the window (Hz), shift s (1/s^2) of the energy norm, factor on the inverse outside
    of the basis, decay (1/s) down to which damped eigenvalues are in the window, infinite without
    damping.
    """

    max_frequency: float
    shift: float
    safety: float = _SAFETY
    decay: float = np.inf

    @property
    def damped(self) -> bool:
        """Whether z is lambda rather than kappa."""
        return self.decay < np.inf

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

    def outside(self, z: Complexes) -> Floats:
        """The factor g for the inverse of the pencil outside of the basis, shape (n,).

        Outside no eigenvalue lies below the end kappa_m of the margin: g = (kappa_m + s) /
        (kappa_m - Re kappa), taken twice. Friction adds to that inverse what no factor bounds
        beforehand; full solves test it. Modes that decay faster than the basis reaches are
        outside of it too: where one has the frequency of an eigenvalue, P on it is about
        2 |lambda| times their distance.
        """
        kappa = -(z**2) if self.damped else z
        top = (MARGIN * self.end) ** 2
        of_margin = self.safety * (top + self.shift) / (top - np.minimum(kappa.real, self.end**2))
        if not self.damped:
            return of_margin
        speeds, room = np.abs(z), self.reach + np.maximum(z.real, -self.decay)
        decaying = (speeds**2 + self.shift) / np.maximum(2 * speeds, SLOW * self.end) / room
        return np.maximum(of_margin, self.safety * decaying)


@dataclass(frozen=True)
class ReducedSpectrum:
    """Eigenvalues of a window and its margin, by rising frequency.

    kappa (1/s^2), or lambda (1/s) of damped pencils, as z, and lambda with Im lambda >= 0;
    coordinates of their vectors of M-norm one and of their contact forces; bounds on the errors of
    z (:class:`cea.reduced.certificate.Certificate`).
    """

    settings: Settings
    z: Complexes
    eigenvalues: Complexes
    right: Complexes
    left: Complexes
    forces: Complexes
    left_forces: Complexes
    errors: Floats
    means: Floats
    reduction: Floats
    clusters: Ints
    slopes: Floats

    @classmethod
    def empty(cls, settings: Settings) -> "ReducedSpectrum":
        """What a basis without vectors knows."""
        none, vectors = np.empty(0, dtype=complex), np.empty((0, 0), dtype=complex)
        real, clusters = np.empty(0), np.empty(0, dtype=np.int64)
        of_modes = (real, real, real, clusters, real)
        return cls(settings, none, none, vectors, vectors, vectors, vectors, *of_modes)

    def __len__(self) -> int:
        return len(self.z)

    def __getitem__(self, modes: Ints) -> "ReducedSpectrum":
        arrays = {each.name: getattr(self, each.name)[..., modes] for each in fields(self)[1:]}
        return replace(self, **arrays)

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
        if self.settings.damped:
            return self.errors
        return uncertainties_of(self.eigenvalues, self.errors)

    @property
    def mean_errors(self) -> Floats:
        """Bounds on errors of the means of clusters, of lambda relative to its speed, (n,)."""
        return self.means * self._relative

    @property
    def conditions(self) -> Floats:
        """Condition numbers of kappa in the M-norm, shape (n,)."""
        if self.settings.damped:
            return np.maximum(2 * np.abs(self.z) * self.slopes, 1.0)
        return self.slopes

    @property
    def worst(self) -> float:
        """Largest error of a cluster's mean in the window that the basis makes, as `bound` has it.

        Rounding is left aside: a larger basis does not help against it.
        """
        return self._largest(self.reduction)

    @property
    def bound(self) -> float:
        """Largest error of a cluster's mean in the window, of lambda relative to its speed.

        Infinite where there is no basis.
        """
        return self._largest(self.means)

    @property
    def _relative(self) -> Floats:
        """What takes errors of z to those of lambda relative to its speed."""
        return 1 / self.speeds if self.settings.damped else 1 / (2 * self.speeds**2)

    def _largest(self, errors: Floats) -> float:
        if not len(self.right):
            return np.inf
        return float((errors * self._relative)[self.inside].max(initial=0.0))

    def words(self, threshold: float | None) -> list[Word]:
        """A word for each mode, whose error is its bound, with a limit of growth (1/s)."""
        values, bounds = self.eigenvalues, self.uncertainties
        bounded = np.zeros(len(values), dtype=bool)
        if not self.settings.damped:
            bounded = cannot_grow(self.z, self.errors, symmetric=False)
        limits, rigid = thresholds(values, threshold), np.abs(values) <= bounds
        return classify(values.real, bounds, limits, bounded, rigid)


def upper_root(kappa: Complexes) -> Complexes:
    """The lambda = sqrt(-kappa) with Im lambda >= 0; it grows where lambda is real."""
    root = np.sqrt(-kappa.astype(complex))
    return np.where(root.imag < 0, -root, root) + 0j


def reduced_spectrum(
    stiffness: Residuals,
    damping: Residuals | None,
    mass: Residuals,
    settings: Settings,
    rounding: Rounding,
    saddle: Saddle | None,
) -> ReducedSpectrum:
    """Eigenvalues of a window and its margin; ``damping`` is None without it."""
    K, M, k = stiffness.square, mass.square, len(mass.square)
    root = np.linalg.cholesky(M)
    if damping is None:
        pairs = _undamped(K, M, root, settings, saddle)
        eigenvalues, scale = upper_root(pairs.values), 1.0
    else:
        pairs = _damped(K, damping.square, M, root, settings, saddle)
        eigenvalues, scale = pairs.values, settings.end
    if saddle is not None:
        stiffness, mass = saddle.with_stiffness(stiffness), saddle.beside(mass)
        damping = None if damping is None else saddle.beside(damping)
    certifier = Certifier(stiffness, damping, mass, rounding, scale)
    told = certifier.certificate(pairs, settings.outside(pairs.values))
    found = ReducedSpectrum(
        settings,
        pairs.values,
        eigenvalues,
        *(pairs.right[:k], pairs.left[:k], pairs.right[k:], pairs.left[k:]),
        *(told.errors, told.means, told.reduction),
        told.clusters,
        told.slopes,
    )
    return found if damping is None else found[np.flatnonzero(eigenvalues.imag >= 0)]


def _undamped(
    K: Floats, M: Floats, root: Floats, settings: Settings, saddle: Saddle | None
) -> Pairs:
    """Eigenpairs by the inverse of K + s M."""
    shift = settings.shift
    inverse = Inverse(K + shift * M, saddle)
    operator = root.T @ inverse(root)
    theta, duals, states = eig(operator, left=True, right=True)
    with np.errstate(divide="ignore"):
        kappa = 1 / theta - shift
    speeds = upper_root(kappa)
    order = np.lexsort((speeds.real, speeds.imag))
    order = order[speeds.imag[order] <= MARGIN * settings.end]
    kappa, states, duals = kappa[order], states[:, order], duals[:, order]
    right = solve_triangular(root, states, lower=True, trans="T")
    left = solve_triangular(root, duals, lower=True, trans="T")
    loads = M @ right * (kappa + shift), M @ left * (kappa + shift).conj()
    right, left = inverse.extended(right, loads[0]), inverse.extended_left(left, loads[1])
    return Pairs(kappa, right, left, states, duals, operator, -shift)


def _damped(
    K: Floats, D: Floats, M: Floats, root: Floats, settings: Settings, saddle: Saddle | None
) -> Pairs:
    """Eigenpairs by the companion form, inverted about a real shift of growth."""
    k, shift, scale = len(K), np.sqrt(settings.shift), settings.end
    inverse_of = Inverse(shift**2 * M + shift * D + K, saddle)
    one = np.eye(k)
    half = solve_triangular(root, D, lower=True)
    drag = solve_triangular(root, half.T, lower=True).T  # L^-1 D L^-T
    inverse = root.T @ inverse_of(root @ np.hstack([drag + shift * one, one]))
    of_motion, of_speed = -inverse[:, :k], -scale * inverse[:, k:]
    operator = np.block(
        [[of_motion, of_speed], [(one + shift * of_motion) / scale, shift * of_speed / scale]]
    )
    mu, duals, states = eig(operator, left=True, right=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = shift + 1 / mu
    order = np.lexsort((values.real, values.imag))
    inside = (values.imag >= -_BELOW * scale) & (values.imag <= MARGIN * scale)
    inside &= np.isfinite(values) & (values.real >= -settings.reach)
    order = order[inside[order]]
    values, states, duals = values[order], states[:, order], duals[:, order]
    states = states / np.linalg.norm(states[:k], axis=0)
    duals = duals / np.linalg.norm(duals[k:], axis=0)
    right = solve_triangular(root, states[:k], lower=True, trans="T")
    left = solve_triangular(root, duals[k:], lower=True, trans="T")
    back = values.conj()
    load = M @ right * (shift**2 - values**2) + D @ right * (shift - values)
    left_load = M @ left * (shift**2 - back**2) + D.T @ left * (shift - back)
    right, left = inverse_of.extended(right, load), inverse_of.extended_left(left, left_load)
    return Pairs(values, right, left, states, duals, operator, shift)
