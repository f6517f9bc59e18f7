"""Bounds on the errors of eigenvalues of a reduced model, of one and of several together.

With z = kappa of an undamped pencil and z = lambda of a damped one,

    P(z) = K - z M,    P(z) = K + z D + z^2 M,

right and left vectors x and y of M-norm one, and their residuals r = P x and s = P^H y,

    |z - z_pencil| <= (g |r| |s| + u) / |y^H P'(z) x|,

norms in X^-1. It is of second order because r and s vanish on the basis (Galerkin). The factor g
stands for the inverse of the pencil outside of the basis (:class:`Settings`), u is rounding.

Where eigenvalues nearly coalesce, bounds of one mean little: their condition grows without limit.
With a basis Q of an invariant subspace of the linearised problem, its dual, the displacements X and
Y of both and the block B of p eigenvalues, the residuals K X + D X B + M X B^2 (or K X - M X B) and
those of Y bound the error of the block by e = g |R| |S|. The mean of the cluster then is off by no
more than e, and its members by

    (2 |B - mean| + e)^(1 - 1/p) e^(1/p)

(L. Elsner, An optimal bound for the spectral variation of two matrices, Linear Algebra Appl. 71
(1985)).

Rounding: entries of the reduced matrices are off relative to their parts, and by what is seen where
both V^T (A V) and (A^T V)^T V are computed. Errors E move an eigenvalue of k unknowns and condition
c by c sqrt(k) |y|^T E |x| (componentwise backward error; N. J. Higham,
T. Mary, SIAM J. Sci. Comput. 41 (2019)).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import connected
from cea.eigen.pencil import POWERS, Role

_TOUCH = 10.0
"""Bound of an eigenvalue, in its distance from the next, from the inverse of which on they are
judged together."""


def real_times(matrix: Floats, vectors: NDArray[np.inexact]) -> Complexes:
    """A x in real arithmetic: imaginary parts of those columns alone that have one."""
    turning = np.flatnonzero(vectors.imag.any(axis=0))
    image = matrix @ np.hstack([vectors.real, vectors.imag[:, turning]])
    columns = vectors.shape[1]
    result = image[:, :columns].astype(complex)
    result.imag[:, turning] = image[:, columns:]
    return result


@dataclass(frozen=True)
class Residuals:
    """K, D or M on a basis V of states.

    V^T A V; coordinates of what its images A V and A^T V cause; norm of what these leave out.
    """

    square: Floats
    right: Floats
    left: Floats
    lost: float


@dataclass(frozen=True)
class Rounding:
    """Errors of the entries of reduced matrices, by role."""

    entries: Mapping[Role, Floats]

    def of_pairs(self, left: Complexes, right: Complexes, speeds: Floats) -> Floats:
        """What they do to y^H P x of pairs (1/s^2), with abs(lambda) (1/s), shape (n,)."""
        y, x = np.abs(left), np.abs(right)
        works = np.zeros(len(speeds))
        for role, entries in self.entries.items():
            works += speeds ** POWERS[role] * np.einsum("ij,ij->j", y, entries @ x)
        return np.sqrt(len(y)) * works

    def of_block(self, left: Complexes, right: Complexes, speed: float) -> float:
        """Norm of the perturbation of the block of a cluster (1/s^2)."""
        y, x = np.abs(left), np.abs(right)
        block = np.zeros((y.shape[1], x.shape[1]))
        for role, entries in self.entries.items():
            block += speed ** POWERS[role] * (y.T @ entries @ x)
        return float(np.sqrt(len(y)) * np.linalg.norm(block, 2))


@dataclass(frozen=True)
class Pairs:
    """Eigenpairs of a linearised problem T q = q / (z - shift).

    z; x and y of M-norm one with their contact forces below, shape (k + m, n); right and left
    vectors of T whose displacements have M-norm one, shape (k or 2 k, n); T and the shift.
    """

    values: Complexes
    right: Complexes
    left: Complexes
    states: Complexes
    duals: Complexes
    operator: Floats
    shift: float

    def __getitem__(self, modes: Ints) -> "Pairs":
        names = ("values", "right", "left", "states", "duals")
        return replace(self, **{name: getattr(self, name)[..., modes] for name in names})


@dataclass(frozen=True)
class Certificate:
    """Bounds on errors of eigenvalues z, each of shape (n,).

    Of each; of the mean of its cluster, or of itself where it is alone; what the basis makes of the
    latter, without rounding; number of the cluster; 1 / abs(y^H P'(z) x).
    """

    errors: Floats
    means: Floats
    reduction: Floats
    clusters: Ints
    slopes: Floats


@dataclass(frozen=True)
class Certifier:
    """What bounds are made of: reduced matrices with contact forces as unknowns, and rounding.

    Speeds in states of a damped pencil are divided by ``scale`` (1/s).
    """

    stiffness: Residuals
    damping: Residuals | None
    mass: Residuals
    rounding: Rounding
    scale: float

    def certificate(self, pairs: Pairs, outside: Floats) -> Certificate:
        """Bounds of eigenpairs, with the factor g of each, shape (n,)."""
        values, damped = pairs.values, self.damping is not None
        slopes = 1 / np.maximum(self._overlap(pairs), np.finfo(float).tiny)
        r, s = self._residuals(
            pairs.right, pairs.left, lambda image: image * values, lambda y: y * values.conj()
        )
        sizes = [
            np.linalg.norm(defect, axis=0)
            + self._lost(np.abs(values)) * np.linalg.norm(vectors, axis=0)
            for defect, vectors in ((r, pairs.right), (s, pairs.left))
        ]
        speeds = np.abs(values) if damped else np.sqrt(np.abs(values))
        reduction = slopes * outside * sizes[0] * sizes[1]
        errors = reduction + slopes * self.rounding.of_pairs(pairs.left, pairs.right, speeds)
        means, clusters = errors.copy(), np.arange(len(values))
        near = np.abs(values[:, None] - values) <= _TOUCH * np.minimum(errors[:, None], errors)
        for number, members in enumerate(connected(near)):
            clusters[members] = number
            if len(members) > 1:
                own, doubt, spread = self._together(pairs[members], float(outside[members].max()))
                e, p = own + doubt, len(members)
                reduction[members], means[members] = own, e
                errors[members] = (2 * spread + e) ** (1 - 1 / p) * e ** (1 / p)
                if damped and (values[members].imag < 0).any():  # only a part of them is told
                    means[members] = reduction[members] = errors[members]
        return Certificate(errors, means, reduction, clusters, slopes)

    def _overlap(self, pairs: Pairs) -> Floats:
        """abs(y^H P'(z) x)."""
        turned = real_times(self.mass.square, pairs.right)
        if self.damping is not None:
            turned = turned * (2 * pairs.values) + real_times(self.damping.square, pairs.right)
        return np.abs(np.einsum("ij,ij->j", pairs.left.conj(), turned))

    def _residuals(
        self,
        x: Complexes,
        y: Complexes,
        times: Callable[[Complexes], Complexes],
        back: Callable[[Complexes], Complexes],
    ) -> list[Complexes]:
        """Coordinates of the residuals of right and left vectors, which z multiplies."""
        found = []
        for side, vectors, z in (("right", x, times), ("left", y, back)):
            of_k, of_m = (
                real_times(getattr(each, side), vectors) for each in (self.stiffness, self.mass)
            )
            if self.damping is None:
                found.append(of_k - z(of_m))
            else:
                of_d = real_times(getattr(self.damping, side), vectors)
                found.append(of_k + z(of_d) + z(z(of_m)))
        return found

    def _lost[T: (float, Floats)](self, size: T) -> T:
        """Norm of what coordinates of residuals leave out at |z|."""
        if self.damping is None:
            return self.stiffness.lost + size * self.mass.lost
        return self.stiffness.lost + size * self.damping.lost + size**2 * self.mass.lost

    def _together(self, pairs: Pairs, outside: float) -> tuple[float, float, float]:
        """Error of the block of a cluster, rounding of it, distance from a multiple of one."""
        q, q_sizes, q_axes = np.linalg.svd(pairs.states, full_matrices=False)
        d, d_sizes, d_axes = np.linalg.svd(pairs.duals, full_matrices=False)
        x, y = pairs.right @ q_axes.conj().T / q_sizes, pairs.left @ d_axes.conj().T / d_sizes
        try:
            turned = np.linalg.inv(d.conj().T @ q).conj().T / self.scale
            inverse = self.scale * turned.conj().T @ d.conj().T @ (pairs.operator @ q)
            block = np.linalg.inv(inverse) + pairs.shift * np.eye(len(inverse))
        except np.linalg.LinAlgError:
            return np.inf, np.inf, np.inf
        y = y @ turned
        r, s = self._residuals(x, y, lambda v: v @ block, lambda v: v @ block.conj().T)
        size = float(np.linalg.norm(block, 2))
        lengths = [
            float(np.linalg.norm(defect, 2) + self._lost(size) * np.linalg.norm(vectors, 2))
            for defect, vectors in ((r, x), (s, y))
        ]
        mean = np.trace(block) / len(block)
        spread = float(np.linalg.norm(block - mean * np.eye(len(block)), 2))
        doubt = self.rounding.of_block(
            y, x, size if self.damping is not None else float(np.sqrt(size))
        )
        return outside * lengths[0] * lengths[1], doubt, spread
