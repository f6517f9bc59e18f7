"""Error bounds of the eigenvalues of a reduced model, single ones and clusters.

With z = kappa of an undamped pencil and z = lambda of a damped one,

    P(z) = K - z M,    P(z) = K + z D + z^2 M,

right and left vectors x and y of M-norm one, and their residuals r = P x and s = P^H y,

    |z - z_pencil| <= (g |r| |s| + u) / |y^H P'(z) x|,

norms in X^-1. The bound is of second order because r and s vanish on the basis (Galerkin). The
factor g estimates the inverse of the pencil outside the basis (:mod:`cea.reduced.spectrum`), and u
is rounding.

Near a coalescence bounds of single eigenvalues are useless, since their condition numbers grow
without limit. With a basis Q of an invariant subspace of the linearised problem, its dual, the
displacements X and Y of both and the block B of p eigenvalues, the residuals K X + D X B + M X B^2
(or K X - M X B) and those of Y bound the error of the block by e = g |R| |S|. The error of the mean
of the cluster is then at most e, and that of its members at most

    (2 |B - mean| + e)^(1 - 1/p) e^(1/p)

(L. Elsner, An optimal bound for the spectral variation of two matrices, Linear Algebra Appl. 71
(1985)).

Rounding errors E of the entries of the reduced matrices are relative to their size, plus the
observed difference of V^T (A V) and (A^T V)^T V. They move an eigenvalue of k unknowns and
condition number c by c sqrt(k) |y|^T E |x| (componentwise backward error; N. J. Higham, T. Mary,
SIAM J. Sci. Comput. 41 (2019)).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats, Ints, real_product
from cea.eigen.matching import connected

_TOUCH = 10.0
"""Distance of two eigenvalues, in multiples of the smaller error bound, up to which they are
treated as one cluster."""
_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Term:
    """A term f z^p A of P(z) on a basis V of states.

    ``square`` is V^T A V; ``right`` and ``left`` are coordinates of the Riesz representatives of
    A V and A^T V, ``lost`` the norm of the part outside their basis; ``rounding`` are rounding
    errors of the entries of V^T A V.
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
        """Return the sum of terms of equal power with coefficients."""
        first = parts[0][1]
        arrays = [sum(c * getattr(t, n) for c, t in parts) for n in ("square", "right", "left")]
        errors = [sum(abs(c) * getattr(t, n) for c, t in parts) for n in ("lost", "rounding")]
        return cls(first.factor, first.power, *arrays, *errors)

    def on(self, part: Floats) -> "Term":
        """Return the term on a part of the basis, orthonormal columns; rounding adds up at random.

        Errors of different entries are independent, so their squares are added.
        """
        square, right = part.T @ self.square @ part, self.right @ part
        left = right if self.left is self.right else self.left @ part
        moved = np.sqrt((part**2).T @ self.rounding**2 @ part**2)
        rounding = moved + np.finfo(float).eps * np.abs(square)
        return replace(self, square=square, right=right, left=left, rounding=rounding)


@dataclass(frozen=True)
class Pairs:
    """Eigenpairs of P(z) on a basis, computed by a linearised problem T q = q / (z - shift).

    ``terms`` are those of P, with contact forces among their unknowns. ``values`` are z; ``right``
    and ``left`` are x and y of M-norm one, followed by contact forces, shape (k + m, n); ``states``
    and ``duals`` are right and left vectors of T whose displacements have M-norm one, shape (k or
    2 k, n); ``operator`` is T. ``scale`` (1/s) divides velocities in states of a damped pencil.
    """

    terms: Sequence[Term]
    values: Complexes
    right: Complexes
    left: Complexes
    states: Complexes
    duals: Complexes
    operator: Floats
    shift: float
    scale: float

    def bounds(self, outside: Floats, *, damped: bool) -> dict[str, Any]:
        """Return the error bounds of eigenpairs; ``outside`` is the factor g of each, shape (n,).

        Keys are names of fields of :class:`cea.reduced.spectrum.ReducedSpectrum`.
        """
        values, overlaps = self.values, self._overlaps()
        slopes = 1 / np.maximum(np.abs(overlaps), _TINY)
        residuals, rounding = self._defects(self.right, self.left, values)
        reduction = slopes * outside * residuals
        errors = reduction + slopes * rounding
        means, clusters = errors.copy(), np.arange(len(values))
        near = np.abs(values[:, None] - values) <= _TOUCH * np.minimum(errors[:, None], errors)
        for number, members in enumerate(connected(near)):
            clusters[members] = number
            if len(members) > 1:
                residual, doubt, spread = self._together(members)
                own = float(outside[members].max()) * residual
                e, p = own + doubt, len(members)
                reduction[members], means[members] = own, e
                errors[members] = (2 * spread + e) ** (1 - 1 / p) * e ** (1 / p)
                if damped and (values[members].imag < 0).any():  # conjugates are not listed
                    means[members] = reduction[members] = errors[members]
        bounds = {"errors": errors, "means": means, "reduction": reduction}
        return bounds | {"clusters": clusters, "overlaps": overlaps}

    def _overlaps(self) -> Complexes:
        """Return y^H P'(z) x."""
        total = np.zeros(len(self.values), dtype=complex)
        for each in self.terms:
            if each.power:
                speeds = each.factor * each.power * self.values ** (each.power - 1)
                image = real_product(each.square.dot, self.right)
                total += speeds * np.einsum("ij,ij->j", self.left.conj(), image)
        return total

    def _defects(self, x: Complexes, y: Complexes, z: Complexes) -> tuple[Any, Any]:
        """Return the product of the residual norms of right and left vectors, and rounding.

        For each vector, or for all together where z is a block that multiplies them.
        """
        single = z.ndim == 1
        norm = partial(np.linalg.norm, axis=0) if single else partial(np.linalg.norm, ord=2)
        block = np.diag(z) if single else z
        size = norm(block)
        lost = sum(each.lost * size**each.power for each in self.terms)
        residuals: Any = 1.0
        for side, vectors, own in (("right", x, block), ("left", y, block.conj().T)):
            defect: Any = 0.0
            for each in self.terms:
                image = each.factor * real_product(getattr(each, side).dot, vectors)
                defect = defect + image @ np.linalg.matrix_power(own, each.power)
            residuals = residuals * (norm(defect) + lost * norm(vectors))
        entries: Any = 0.0
        for each in self.terms:
            moved = size**each.power * (each.rounding @ np.abs(x))
            entries = entries + np.abs(y).T @ moved
        return residuals, np.sqrt(len(y)) * (np.diag(entries) if single else norm(entries))

    def _together(self, members: Ints) -> tuple[float, float, float]:
        """Return residuals and rounding of the block of a cluster, and norm(B - mean)."""
        q, q_sizes, q_axes = np.linalg.svd(self.states[:, members], full_matrices=False)
        d, d_sizes, d_axes = np.linalg.svd(self.duals[:, members], full_matrices=False)
        x = self.right[:, members] @ q_axes.conj().T / q_sizes
        y = self.left[:, members] @ d_axes.conj().T / d_sizes
        try:
            turned = np.linalg.inv(d.conj().T @ q).conj().T / self.scale
            inverse = self.scale * turned.conj().T @ d.conj().T @ (self.operator @ q)
            block = np.linalg.inv(inverse) + self.shift * np.eye(len(inverse))
        except np.linalg.LinAlgError:
            return np.inf, np.inf, np.inf
        spread = np.linalg.norm(block - np.trace(block) / len(block) * np.eye(len(block)), 2)
        residuals, rounding = self._defects(x, y @ turned, block)
        return float(residuals), float(rounding), float(spread)
