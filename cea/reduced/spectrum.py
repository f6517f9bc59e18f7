"""Eigenvalues of a reduced model up to the end of a window and its margin, with their bounds.

Undamped, the inverse of the shifted stiffness is solved for 1 / (kappa + s); damped, the companion
form inverted about a real shift of growth. What lies in the margin helps to judge the rest.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, lu_factor, lu_solve, solve_triangular

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.classify import Word, cannot_grow, classify, thresholds
from cea.eigen.modes import uncertainties_of
from cea.eigen.spectrum import SLOW
from cea.reduced.certificate import Certifier, Pairs, Residuals, Rounding

MARGIN = 1.15
"""Frequency up to which eigenvectors are taken into a basis, relative to the end of the window."""
_FURTHER = 0.05
"""Decay beyond that of the window, relative to its end, down to which they are."""
_BELOW = 0.05
"""Part of the window below the real axis whose eigenvalues help to judge those next to it."""
_INFINITE = 1e4
"""Speed, relative to the window's end, of eigenvalues that ties make infinite but for rounding."""
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
    coordinates of their vectors of M-norm one, of displacements and contact forces below them;
    bounds on the errors of z (:class:`cea.reduced.certificate.Certificate`).
    """

    settings: Settings
    displacements: int
    z: Complexes
    eigenvalues: Complexes
    right: Complexes
    left: Complexes
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
        return cls(settings, 0, none, none, vectors, vectors, real, real, real, clusters, real)

    def __len__(self) -> int:
        return len(self.z)

    def __getitem__(self, modes: Ints) -> "ReducedSpectrum":
        arrays = {each.name: getattr(self, each.name)[..., modes] for each in fields(self)[2:]}
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
    def shapes(self) -> Complexes:
        """Coordinates of the displacements of right vectors."""
        return self.right[: self.displacements]

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
    displacements: int,
    settings: Settings,
    rounding: Rounding,
) -> ReducedSpectrum:
    """Eigenvalues of a window and its margin; ``damping`` is None without it.

    Contact forces stand behind so many displacements.
    """
    k = displacements
    K, M = stiffness.square, mass.square[:k, :k]
    root = np.linalg.cholesky(M)
    if damping is None:
        pairs = _undamped(K, M, root, settings)
        eigenvalues, scale = upper_root(pairs.values), 1.0
    else:
        pairs = _damped(K, damping.square[:k, :k], M, root, settings)
        eigenvalues, scale = pairs.values, settings.end
    certifier = Certifier(stiffness, damping, mass, rounding, scale)
    told = certifier.certificate(pairs, settings.outside(pairs.values))
    found = ReducedSpectrum(
        settings=settings,
        displacements=k,
        z=pairs.values,
        eigenvalues=eigenvalues,
        right=pairs.right,
        left=pairs.left,
        errors=told.errors,
        means=told.means,
        reduction=told.reduction,
        clusters=told.clusters,
        slopes=told.slopes,
    )
    return found if damping is None else found[np.flatnonzero(eigenvalues.imag >= 0)]


class Inverse:
    """The inverse of a shifted stiffness A with contact forces eliminated from [A, L; N, -c].

    A^-1 - A^-1 L S^-1 N A^-1 with S = c + N A^-1 L: nothing grows with a contact stiffness 1 / c.
    """

    def __init__(self, whole: Floats, shifted: Floats) -> None:
        k = len(shifted)
        self._factors = lu_factor(shifted)
        self._reacts, self._closes = whole[:k, k:], whole[k:, :k]
        self._flexible = lu_solve(self._factors, self._reacts)
        self._schur = lu_factor(self._closes @ self._flexible - whole[k:, k:])

    def __call__(self, block: Floats) -> Floats:
        """Displacements under a block of forces."""
        found: Floats = lu_solve(self._factors, block)
        return found - self._flexible @ lu_solve(self._schur, self._closes @ found)

    def extended(self, right: Complexes, loads: Complexes) -> Complexes:
        """Right vectors with their contact forces below, by the loads they are in balance with."""
        gaps = self._closes @ lu_solve(self._factors, loads)
        return np.vstack([right, lu_solve(self._schur, gaps)])

    def extended_left(self, left: Complexes, loads: Complexes) -> Complexes:
        """The same of left vectors."""
        gaps = self._reacts.T @ lu_solve(self._factors, loads, trans=1)
        return np.vstack([left, lu_solve(self._schur, gaps, trans=1)])


def _undamped(K: Floats, M: Floats, root: Floats, settings: Settings) -> Pairs:
    """Eigenpairs by the inverse of K + s M."""
    shift, k = settings.shift, len(M)
    inverse = Inverse(K, K[:k, :k] + shift * M)
    operator = root.T @ inverse(root)
    theta, duals, states = eig(operator, left=True, right=True)
    with np.errstate(divide="ignore"):
        kappa = 1 / theta - shift
    speeds = upper_root(kappa)
    order = np.lexsort((speeds.real, speeds.imag))
    inside = (speeds.imag <= MARGIN * settings.end) & (np.abs(speeds) < _INFINITE * settings.end)
    order = order[inside[order]]
    kappa, states, duals = kappa[order], states[:, order], duals[:, order]
    right = solve_triangular(root, states, lower=True, trans="T")
    left = solve_triangular(root, duals, lower=True, trans="T")
    loads = M @ right * (kappa + shift), M @ left * (kappa + shift).conj()
    right, left = inverse.extended(right, loads[0]), inverse.extended_left(left, loads[1])
    return Pairs(kappa, right, left, states, duals, operator, -shift)


def _damped(K: Floats, D: Floats, M: Floats, root: Floats, settings: Settings) -> Pairs:
    """Eigenpairs by the companion form, inverted about a real shift of growth."""
    k, shift, scale = len(M), np.sqrt(settings.shift), settings.end
    inverse_of = Inverse(K, shift**2 * M + shift * D + K[:k, :k])
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
    inside &= (np.abs(values) < _INFINITE * scale) & (values.real >= -settings.reach)
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
