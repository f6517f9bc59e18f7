"""Eigenvalues of a reduced model with damping or rotation, with bounds on their errors.

    P(lambda) = lambda^2 M + lambda D + K

Outside of the basis P acts as its Schur complement does: to first order an eigenvalue is off by

    |lambda - lambda_pencil| <= g |r| |s| / |y^H (2 lambda M + D) x|,

r = P x and s = P^H y in the norm of X^-1 (:mod:`cea.reduced.spectrum` for the undamped problem).
Eigenvalues that nearly coalesce are judged together. With the invariant subspace Q of their
companion form, its dual Z and the block B, X the displacements of Q, Y those that Z is loaded by,

    R = K X + D X B + M X B^2,    S^H = Y^H K + B Y^H D + B^2 Y^H M,

the block is off by e = g |R| |S| at most, its mean by no more, its members as
:mod:`cea.reduced.certificate` says.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, solve_triangular

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import connected
from cea.reduced.certificate import TOUCH, Certificate
from cea.reduced.products import real_times
from cea.reduced.residuals import Residuals
from cea.reduced.rounding import Rounding
from cea.reduced.saddle import Inverse, Saddle
from cea.reduced.spectrum import MARGIN, ReducedSpectrum, Settings, without_a_basis

_BELOW = 0.05
"""Part of the window below the real axis whose eigenvalues help to judge those next to it."""


@dataclass(frozen=True)
class _Pairs:
    """Eigenpairs of a window and around it.

    Parameters
    ----------
    values
        lambda (1/s), shape (n,).
    right, left
        Coordinates of x and y, of M-norm one, with those of their contact forces below, shape
        (k + m, n).
    states, duals
        Right and left vectors of the companion form on an M-orthonormal basis, shape (2 k, n).
    """

    values: Complexes
    right: Complexes
    left: Complexes
    states: Complexes
    duals: Complexes

    def __getitem__(self, modes: Ints) -> "_Pairs":
        return _Pairs(
            self.values[modes],
            self.right[:, modes],
            self.left[:, modes],
            self.states[:, modes],
            self.duals[:, modes],
        )


def quadratic_spectrum(
    stiffness: Residuals,
    damping: Residuals,
    mass: Residuals,
    settings: Settings,
    rounding: Rounding,
    saddle: Saddle | None,
) -> ReducedSpectrum:
    """Eigenvalues of a window and its margin.

    Parameters
    ----------
    stiffness, damping, mass
        The reduced matrices.
    settings
        What bounds are made with.
    rounding
        What rounding does to eigenvalues.
    saddle
        Contacts whose forces are unknowns.
    """
    k = len(mass.square)
    if not k:
        return without_a_basis(settings)
    root = np.linalg.cholesky(mass.square)
    pairs = _pairs(stiffness.square, damping.square, mass.square, root, settings, saddle)
    if saddle is not None:
        stiffness = saddle.with_stiffness(stiffness)
        damping, mass = saddle.beside(damping), saddle.beside(mass)
    judged = _Judged(stiffness, damping, mass, root, settings, rounding)
    certificate = judged.certificate(pairs)
    upper = np.flatnonzero(pairs.values.imag >= 0)
    values = pairs.values[upper]
    return ReducedSpectrum(
        -(values**2),
        values,
        pairs.right[:k, upper],
        pairs.left[:k, upper],
        certificate[upper],
        settings,
        pairs.right[k:, upper],
        pairs.left[k:, upper],
    )


def _pairs(
    K: Floats, D: Floats, M: Floats, root: Floats, settings: Settings, saddle: Saddle | None
) -> _Pairs:
    """Eigenpairs by the companion form, inverted about a real shift of growth."""
    k, shift, gamma = len(K), np.sqrt(settings.shift), settings.end
    inverse_of = Inverse(shift**2 * M + shift * D + K, saddle)
    one, drag = np.eye(k), _between(root, D)
    inverse = root.T @ inverse_of(root @ np.hstack([drag + shift * one, one]))
    of_motion, of_speed = -inverse[:, :k], -gamma * inverse[:, k:]
    inverted = np.block(
        [[of_motion, of_speed], [(one + shift * of_motion) / gamma, shift * of_speed / gamma]]
    )
    mu, duals, states = eig(inverted, left=True, right=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = shift + 1 / mu
    order = np.lexsort((values.real, values.imag))
    inside = (values.imag >= -_BELOW * gamma) & (values.imag <= MARGIN * gamma)
    inside &= np.isfinite(values) & (values.real >= -settings.reach)
    order = order[inside[order]]
    values, states, duals = values[order], states[:, order], duals[:, order]
    x, y = states[:k], duals[k:]
    sizes = [np.linalg.norm(each, axis=0) for each in (x, y)]
    x, y = x / sizes[0], y / sizes[1]
    right = solve_triangular(root, x, lower=True, trans="T")
    left = solve_triangular(root, y, lower=True, trans="T")
    back = values.conj()
    load = M @ right * (shift**2 - values**2) + D @ right * (shift - values)
    left_load = M @ left * (shift**2 - back**2) + D.T @ left * (shift - back)
    right, left = inverse_of.extended(right, load), inverse_of.extended_left(left, left_load)
    return _Pairs(values, right, left, states / sizes[0], duals / sizes[1])


@dataclass(frozen=True)
class _Judged:
    """What bounds of eigenpairs are made of; parameters as of :func:`quadratic_spectrum`."""

    stiffness: Residuals
    damping: Residuals
    mass: Residuals
    root: Floats
    settings: Settings
    rounding: Rounding

    def certificate(self, pairs: _Pairs) -> Certificate:
        """Bounds for lambda^2 that are those for lambda: e becomes e (2 |lambda| + e)."""
        values, outside = pairs.values, self.settings.outside_damped(pairs.values)
        turned = real_times(self.mass.square, pairs.right) * (2 * values)
        turned += real_times(self.damping.square, pairs.right)
        overlap = np.abs(np.einsum("ij,ij->j", pairs.left.conj(), turned))
        slopes = 1 / np.maximum(overlap, np.finfo(float).tiny)
        lengths = self._lengths(pairs)
        reduction = slopes * outside * lengths[0] * lengths[1]
        rounding = self.rounding.of_pairs(pairs.left, pairs.right, np.abs(values))
        errors = reduction + slopes * rounding
        means, clusters = errors.copy(), np.arange(len(values))
        near = np.abs(values[:, None] - values) <= TOUCH * np.minimum(errors[:, None], errors)
        for number, members in enumerate(connected(near)):
            clusters[members] = number
            if len(members) > 1:
                own, doubt, spread = self._together(pairs[members], float(outside[members].max()))
                e, p = own + doubt, len(members)
                reduction[members], means[members] = own, e
                errors[members] = (2 * spread + e) ** (1 - 1 / p) * e ** (1 / p)
                if (values[members].imag < 0).any():  # the mean is told of a part of them
                    means[members] = reduction[members] = errors[members]
        speeds = 2 * np.abs(values)
        return Certificate(
            errors * (speeds + errors),
            means * (speeds + means),
            reduction * (speeds + reduction),
            clusters,
            np.maximum(speeds * slopes, 1.0),
        )

    def _lengths(self, pairs: _Pairs) -> list[Floats]:
        """Norms of the residuals of right and left vectors, shape (n,) each."""
        K, D, M = self.stiffness, self.damping, self.mass
        values, speeds = pairs.values, np.abs(pairs.values)
        lost = K.lost + speeds * D.lost + speeds**2 * M.lost
        x, y, back = pairs.right, pairs.left, values.conj()
        of_k, of_d, of_m = (real_times(each.right, x) for each in (K, D, M))
        r = of_k + of_d * values + of_m * values**2
        of_k, of_d, of_m = (real_times(each.left, y) for each in (K, D, M))
        s = of_k + of_d * back + of_m * back**2
        return [
            np.linalg.norm(K.measured(defect), axis=0) + lost * np.linalg.norm(vectors, axis=0)
            for defect, vectors in ((r, x), (s, y))
        ]

    def _together(self, pairs: _Pairs, outside: float) -> tuple[float, float, float]:
        """Error of the block of a cluster, rounding of it, distance from a multiple of one."""
        k, gamma = len(self.root), self.settings.end
        q, q_sizes, q_axes = np.linalg.svd(pairs.states, full_matrices=False)
        z, z_sizes, z_axes = np.linalg.svd(pairs.duals, full_matrices=False)
        # States and their duals have displacements of M-norm one, as pairs have.
        x, y = pairs.right @ q_axes.conj().T / q_sizes, pairs.left @ z_axes.conj().T / z_sizes
        try:
            turned = np.linalg.inv(z.conj().T @ q).conj().T
            # The block in coordinates of q: its vectors are combinations of the pairs'.
            within = q.conj().T @ pairs.states
            block = within @ np.diag(pairs.values) @ np.linalg.inv(within)
        except np.linalg.LinAlgError:
            return np.inf, np.inf, np.inf
        y = y @ turned / gamma
        sizes = [float(np.linalg.norm(each, 2)) for each in (q[:k], z[k:] @ turned / gamma)]
        K, D, M, back = self.stiffness, self.damping, self.mass, block.conj().T
        of_k, of_d, of_m = (real_times(each.right, x) for each in (K, D, M))
        r = of_k + of_d @ block + of_m @ block @ block
        of_k, of_d, of_m = (real_times(each.left, y) for each in (K, D, M))
        s = of_k + of_d @ back + of_m @ back @ back
        speed = float(np.linalg.norm(block, 2))
        lost = K.lost + speed * D.lost + speed**2 * M.lost
        lengths = [
            float(np.linalg.norm(K.measured(defect), 2) + lost * np.linalg.norm(vectors, 2))
            for defect, vectors in ((r, x), (s, y))
        ]
        mean = np.trace(block) / len(block)
        spread = float(np.linalg.norm(block - mean * np.eye(len(block)), 2))
        doubt = self.rounding.solves * sizes[0] * sizes[1] + self.rounding.of_block(y, x, speed)
        return outside * lengths[0] * lengths[1], doubt, spread


def _between(root: Floats, matrix: Floats) -> Floats:
    """L^-1 A L^-T."""
    half = solve_triangular(root, matrix, lower=True)
    return solve_triangular(root, half.T, lower=True).T
