"""Eigenvalues of a reduced pencil in a window with a margin, by small dense matrices.

Without damping eigenvalues 1 / (kappa + s) of the inverse of the shifted stiffness are computed;
with damping those of the companion form, inverted about a positive real shift. Eigenvalues in the
margin are needed for the error bounds of clusters at the end of the window.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, lu_factor, lu_solve, solve_triangular

from cea.arrays import Complexes, Floats, Ints, real_product
from cea.eigen.classify import Word, cannot_grow, classify, thresholds
from cea.eigen.modes import uncertainties_of
from cea.eigen.spectrum import SLOW
from cea.reduced.certificate import Pairs, Term

MARGIN = 1.15
"""Largest frequency of modes in the basis relative to the end of the window."""
_FURTHER = 0.05
"""Margin of the decay rate of modes in the basis beyond that of the window, relative to its end."""
DECAY = 0.1
"""Default decay rate of a damped window relative to its end."""
_BELOW = 0.05
"""Margin of damped windows below the real axis, relative to the end of the window."""
_INFINITE = 1e4
"""abs(lambda) relative to the end of the window from which on it is infinite (tied contact)."""


@dataclass(frozen=True)
class Window:
    """A window of frequencies up to ``end`` (rad/s) and decay rates up to ``decay`` (1/s).

    Eigenvalues z are lambda if ``damped``, else kappa = -lambda^2. Modes count as growing if their
    growth rate is above ``level`` (1/s).
    """

    end: float
    damped: bool
    level: float = 0.0
    decay: float = np.inf

    @property
    def reach(self) -> float:
        """Largest decay rate (1/s) of eigenvectors of damped pencils in a basis."""
        return self.decay + _FURTHER * self.end

    @property
    def by_growth(self) -> bool:
        """Whether modes grow by their growth rate above the level, instead of by coalescence."""
        return self.damped or self.level != 0.0

    def roots(self, z: Complexes) -> Complexes:
        """Return lambda; of a kappa the root with Im lambda >= 0, or the positive real one."""
        if self.damped:
            return np.asarray(z, complex)
        root = np.sqrt(-np.asarray(z, complex))
        return np.where(root.imag < 0, -root, root) + 0j

    def root_slopes(self, z: Complexes, slopes: Complexes) -> Complexes:
        """Return derivatives of lambda from those of z; infinite or NaN at a coalescence."""
        if self.damped:
            return slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            return -slopes / (2 * self.roots(z))

    def growth(self, z: Complexes) -> Floats:
        """Return growth rates (1/s) minus the level; of a kappa that of its growing root."""
        growth = self.roots(z).real
        return (growth if self.damped else np.abs(growth)) - self.level

    def doubts(self, z: Complexes, errors: Floats) -> Floats:
        """Return errors of lambda (1/s) from errors of z."""
        return errors if self.damped else uncertainties_of(self.roots(z), errors)

    def far(self, z: Complexes, part: float = 1.0) -> NDArray[np.bool_]:
        """Return which z lie beyond ``part`` of the end, or decay faster than the window allows."""
        roots = self.roots(z)
        return (np.abs(roots.imag) > part * self.end) | (roots.real < -self.decay)


@dataclass(frozen=True)
class ReducedSpectrum:
    """Eigenvalues of a window and its margin, sorted by frequency, with error bounds.

    ``errors`` bound each z, ``means`` the mean of its cluster (of one or more), and ``reduction``
    is the part of the latter without rounding. ``clusters`` are numbers of clusters, ``overlaps``
    are y^H P'(z) x. ``z`` is kappa (1/s^2), or lambda (1/s) with damping; ``right`` and ``left``
    are coordinates of vectors of M-norm one.
    """

    errors: Floats
    means: Floats
    reduction: Floats
    clusters: Ints
    overlaps: Complexes
    z: Complexes
    right: Complexes
    left: Complexes
    looked_at: Window

    def __len__(self) -> int:
        return len(self.z)

    def __getitem__(self, modes: Ints) -> "ReducedSpectrum":
        arrays = {each.name: getattr(self, each.name)[..., modes] for each in fields(self)[:-1]}
        return replace(self, **arrays)

    @property
    def eigenvalues(self) -> Complexes:
        """Lambda with Im lambda >= 0 (1/s), shape (n,)."""
        return self.looked_at.roots(self.z)

    @property
    def window(self) -> "ReducedSpectrum":
        """The eigenvalues of the window, without its margin."""
        return self[np.flatnonzero(self.inside)]

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Whether each eigenvalue is in the window, shape (n,)."""
        return ~self.looked_at.far(self.z)

    @property
    def speeds(self) -> Floats:
        """Reference values of relative errors (1/s): abs(lambda), at least a tenth of the end."""
        return np.maximum(np.abs(self.eigenvalues), SLOW * self.looked_at.end)

    @property
    def uncertainties(self) -> Floats:
        """Error bounds of lambda (1/s), shape (n,)."""
        return self.looked_at.doubts(self.z, self.errors)

    @property
    def mean_errors(self) -> Floats:
        """Error bounds of the mean of each cluster in lambda, relative to ``speeds``, (n,)."""
        return self._relative(self.means)

    @property
    def conditions(self) -> Floats:
        """Condition numbers of kappa in the M-norm, shape (n,)."""
        slopes = 1 / np.maximum(np.abs(self.overlaps), np.finfo(float).tiny)
        if self.looked_at.damped:
            return np.maximum(2 * np.abs(self.z) * slopes, 1.0)
        return slopes

    @property
    def worst(self) -> float:
        """Largest bound as in ``bound``, without rounding, which a larger basis cannot reduce."""
        return float(self._relative(self.reduction)[self.inside].max(initial=0.0))

    @property
    def bound(self) -> float:
        """Largest relative error bound of the mean of a cluster in the window, in lambda."""
        return float(self.mean_errors[self.inside].max(initial=0.0))

    def _relative(self, errors: Floats) -> Floats:
        """Return relative errors of lambda from errors of z."""
        return errors / (self.speeds if self.looked_at.damped else 2 * self.speeds**2)

    def words(self, threshold: float | None) -> list[Word]:
        """Classify each mode by its error bound, with a threshold of growth rates (1/s)."""
        values, bounds = self.eigenvalues, self.uncertainties
        bounded = np.zeros(len(values), dtype=bool)
        if not self.looked_at.damped:
            bounded = cannot_grow(self.z, self.errors, symmetric=False)
        limits, rigid = thresholds(values, threshold), np.abs(values) <= bounds
        return classify(values.real, bounds, limits, bounded, rigid)


def _pairs(
    terms: Sequence[Term], forces: NDArray[np.bool_], window: Window, energy_shift: float
) -> Pairs:
    """Return eigenpairs by the inverse of P(shift): of K + s M, or of the companion form."""
    end, damped = window.end, window.damped
    shift = np.sqrt(energy_shift) if damped else -energy_shift
    scale = end if damped else 1.0
    own = ~forces
    squares = {each.power: each.square[np.ix_(own, own)] for each in terms}
    root = np.linalg.cholesky(squares[max(squares)])
    shifted = np.sum([e.factor * shift**e.power * e.square for e in terms], axis=0)
    factors, k = lu_factor(shifted), len(root)

    def balanced(loads: Floats, *, left: bool = False) -> Floats:
        """Return displacements and contact forces under loads."""
        rows = np.zeros((len(forces), loads.shape[1]))
        rows[own] = loads
        found: Floats = lu_solve(factors, rows, trans=int(left))
        return found

    if not damped:
        operator = root.T @ balanced(root)[own]
    else:
        one, half = np.eye(k), solve_triangular(root, squares[1], lower=True)
        drag = solve_triangular(root, half.T, lower=True).T  # L^-1 D L^-T
        inverse = root.T @ balanced(root @ np.hstack([drag + shift * one, one]))[own]
        of_motion, of_speed = -inverse[:, :k], -scale * inverse[:, k:]
        operator = np.block(
            [[of_motion, of_speed], [(one + shift * of_motion) / scale, shift * of_speed / scale]]
        )
    theta, duals, states = eig(operator, left=True, right=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = shift + 1 / theta
    speeds = window.roots(values)
    order = np.lexsort((speeds.real, speeds.imag))
    inside = (speeds.imag >= -_BELOW * end) & (speeds.imag <= MARGIN * end)
    inside &= (np.abs(speeds) < _INFINITE * end) & (speeds.real >= -window.reach)
    order = order[inside[order]]
    values, states, duals = values[order], states[:, order], duals[:, order]
    states = states / np.linalg.norm(states[:k], axis=0)
    duals = duals / np.linalg.norm(duals[-k:], axis=0)
    vectors = []
    for left, side, z in ((False, states[:k], values), (True, duals[-k:], values.conj())):
        motion = solve_triangular(root, side, lower=True, trans="T")
        # The contact forces are those under the loads (P(shift) - P(z)) x.
        moved = [(e.power, e.factor * squares[e.power]) for e in terms if e.power]
        turned = [(p, A.T if left else A) for p, A in moved]
        loads = sum(real_product(A.dot, motion) * (shift**p - z**p) for p, A in turned)
        vectors.append(real_product(partial(balanced, left=left), loads))
        vectors[-1][own] = motion
    return Pairs(terms, values, vectors[0], vectors[1], states, duals, operator, shift, scale)


def spectrum_of(
    terms: Sequence[Term],
    forces: NDArray[np.bool_],
    window: Window,
    energy_shift: float,
    safety: float,
) -> ReducedSpectrum:
    """Return the eigenvalues of P(z) on a basis in the window and its margin, with error bounds.

    ``forces`` marks basis vectors of contact forces; ``energy_shift`` is s (1/s^2) of the energy
    norm; ``safety`` is a factor on the inverse of the pencil outside the basis.
    """
    pairs = _pairs(terms, forces, window, energy_shift)
    outside = safety * _outside(pairs.values, window, energy_shift)
    bounds = pairs.bounds(outside, damped=window.damped)
    z, right, left = pairs.values, pairs.right, pairs.left
    found = ReducedSpectrum(**bounds, z=z, right=right, left=left, looked_at=window)
    return found[np.flatnonzero(z.imag >= 0)] if window.damped else found


def _outside(z: Complexes, window: Window, energy_shift: float) -> Floats:
    """Return the factor g for the inverse of the pencil outside the basis, shape (n,).

    Assuming that no eigenvalue outside the basis lies below the end kappa_m of the margin,
    g = safety (kappa_m + s) / (kappa_m - Re kappa). Friction increases that inverse by an amount
    not known in advance, so full solves test g. Modes that decay faster than those of the basis are
    outside too: where one has the frequency of an eigenvalue, P on it is about 2 |lambda| times
    their distance.
    """
    kappa = -(z**2) if window.damped else z
    top = (MARGIN * window.end) ** 2
    of_margin = (top + energy_shift) / (top - np.minimum(kappa.real, window.end**2))
    if not window.damped:
        return of_margin
    speeds, room = np.abs(z), window.reach + np.maximum(z.real, -window.decay)
    decaying = (speeds**2 + energy_shift) / np.maximum(2 * speeds, SLOW * window.end) / room
    return np.maximum(of_margin, decaying)
