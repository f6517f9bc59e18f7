"""Bounds on the errors of eigenvalues of a reduced model, of one and of several together.

With z = kappa of an undamped pencil and z = lambda of a damped one,

    P(z) = K - z M,    P(z) = K + z D + z^2 M,

right and left vectors x and y of M-norm one, and their residuals r = P x and s = P^H y,

    |z - z_pencil| <= (g |r| |s| + u) / |y^H P'(z) x|,

norms in X^-1. It is of second order because r and s vanish on the basis (Galerkin). The factor g
stands for the inverse of the pencil outside of the basis (:mod:`cea.reduced.spectrum`), u is
rounding.

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

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.matching import connected

_TOUCH = 10.0
"""Bound of an eigenvalue, in its distance from the next, from the inverse of which on they are
judged together."""
_TINY = float(np.finfo(float).tiny)


def real_times(matrix: Floats, vectors: NDArray[np.inexact]) -> Complexes:
    """A x in real arithmetic: imaginary parts of those columns alone that have one."""
    turning = np.flatnonzero(vectors.imag.any(axis=0))
    image = matrix @ np.hstack([vectors.real, vectors.imag[:, turning]])
    columns = vectors.shape[1]
    result = image[:, :columns].astype(complex)
    result.imag[:, turning] = image[:, columns:]
    return result


@dataclass(frozen=True)
class Term:
    """A term f z^p A of P(z) on a basis V of states.

    V^T A V; coordinates of what its images A V and A^T V cause; norm of what these leave out;
    errors of the entries of V^T A V by rounding.
    """

    factor: float
    power: int
    square: Floats
    right: Floats
    left: Floats
    lost: float
    rounding: Floats

    @classmethod
    def summed(cls, parts: Sequence[tuple[float, "Term"]]) -> "Term":
        """The sum of terms of one power with coefficients."""
        first = parts[0][1]
        arrays = [sum(c * getattr(t, n) for c, t in parts) for n in ("square", "right", "left")]
        errors = [sum(abs(c) * getattr(t, n) for c, t in parts) for n in ("lost", "rounding")]
        return cls(first.factor, first.power, *arrays, *errors)


@dataclass(frozen=True)
class Pairs:
    """Eigenpairs of a linearised problem T q = q / (z - shift).

    z; x and y of M-norm one with their contact forces below, shape (k + m, n); right and left
    vectors of T whose displacements have M-norm one, shape (k or 2 k, n); T and the shift; what
    speeds in states of a damped pencil are divided by (1/s).
    """

    values: Complexes
    right: Complexes
    left: Complexes
    states: Complexes
    duals: Complexes
    operator: Floats
    shift: float
    scale: float

    def __getitem__(self, modes: Ints) -> "Pairs":
        names = ("values", "right", "left", "states", "duals")
        return replace(self, **{name: getattr(self, name)[..., modes] for name in names})


@dataclass(frozen=True)
class Polynomial:
    """P(z) on a basis, contact forces among its unknowns: what is solved, and what bounds it."""

    terms: tuple[Term, ...]

    @property
    def damped(self) -> bool:
        """Whether z is lambda rather than kappa."""
        return any(each.power == 2 for each in self.terms)

    def at(self, z: float) -> Floats:
        """P(z)."""
        total: Floats = np.sum([e.factor * z**e.power * e.square for e in self.terms], axis=0)
        return total

    def bounds(self, pairs: Pairs, outside: Floats) -> dict[str, Any]:
        """Bounds of eigenpairs, with the factor g of each, shape (n,).

        Those of :class:`cea.reduced.spectrum.ReducedSpectrum` by their names.
        """
        values, overlaps = pairs.values, self._overlaps(pairs)
        slopes = 1 / np.maximum(np.abs(overlaps), _TINY)
        residuals, rounding = self._defects(pairs.right, pairs.left, values)
        reduction = slopes * outside * residuals
        errors = reduction + slopes * rounding
        means, clusters = errors.copy(), np.arange(len(values))
        near = np.abs(values[:, None] - values) <= _TOUCH * np.minimum(errors[:, None], errors)
        for number, members in enumerate(connected(near)):
            clusters[members] = number
            if len(members) > 1:
                residual, doubt, spread = self._together(pairs[members])
                own = float(outside[members].max()) * residual
                e, p = own + doubt, len(members)
                reduction[members], means[members] = own, e
                errors[members] = (2 * spread + e) ** (1 - 1 / p) * e ** (1 / p)
                if self.damped and (values[members].imag < 0).any():  # only a part is told
                    means[members] = reduction[members] = errors[members]
        bounds = {"errors": errors, "means": means, "reduction": reduction}
        return bounds | {"clusters": clusters, "overlaps": overlaps}

    def _overlaps(self, pairs: Pairs) -> Complexes:
        """y^H P'(z) x."""
        total = np.zeros(len(pairs.values), dtype=complex)
        for each in self.terms:
            if each.power:
                projected = real_times(each.square, pairs.right)
                speeds = each.factor * each.power * pairs.values ** (each.power - 1)
                total += speeds * np.einsum("ij,ij->j", pairs.left.conj(), projected)
        return total

    def _defects(self, x: Complexes, y: Complexes, z: Complexes) -> tuple[Any, Any]:
        """Products of the norms of residuals of right and left vectors, and rounding.

        Of each vector, or of all together where z is a block that multiplies them.
        """
        single = z.ndim == 1
        norm = partial(np.linalg.norm, axis=0) if single else partial(np.linalg.norm, ord=2)
        size = np.abs(z) if single else norm(z)
        lost = sum(each.lost * size**each.power for each in self.terms)
        residuals: Any = 1.0
        entries: Any = 0.0
        for side, vectors, block in (("right", x, z), ("left", y, z.conj().T)):
            defect: Any = 0.0
            for each in self.terms:
                image = each.factor * real_times(getattr(each, side), vectors)
                power = block**each.power if single else np.linalg.matrix_power(block, each.power)
                defect = defect + (image * power if single else image @ power)
            residuals = residuals * (norm(defect) + lost * norm(vectors))
        for each in self.terms:
            moved = size**each.power * (each.rounding @ np.abs(x))
            entries = entries + ((np.abs(y) * moved).sum(axis=0) if single else np.abs(y).T @ moved)
        return residuals, np.sqrt(len(y)) * (entries if single else norm(entries))

    def _together(self, pairs: Pairs) -> tuple[float, float, float]:
        """Residuals and rounding of the block of a cluster, distance from a multiple of one."""
        q, q_sizes, q_axes = np.linalg.svd(pairs.states, full_matrices=False)
        d, d_sizes, d_axes = np.linalg.svd(pairs.duals, full_matrices=False)
        x, y = pairs.right @ q_axes.conj().T / q_sizes, pairs.left @ d_axes.conj().T / d_sizes
        try:
            turned = np.linalg.inv(d.conj().T @ q).conj().T / pairs.scale
            inverse = pairs.scale * turned.conj().T @ d.conj().T @ (pairs.operator @ q)
            block = np.linalg.inv(inverse) + pairs.shift * np.eye(len(inverse))
        except np.linalg.LinAlgError:
            return np.inf, np.inf, np.inf
        spread = np.linalg.norm(block - np.trace(block) / len(block) * np.eye(len(block)), 2)
        residuals, rounding = self._defects(x, y @ turned, block)
        return float(residuals), float(rounding), float(spread)
