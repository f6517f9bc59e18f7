"""Random pencils along one parameter, small enough for dense eigenvalues at every value."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import eig, eigvals, qr

from cea.arrays import Floats, Ints
from cea.reduced.following import Sample
from cea.reduced.thresholds import Found
from cea.reduced.window import Window

MARGIN = 1.15
EPS = np.finfo(float).eps

Pieces = Sequence[tuple[Callable[[float], float], Callable[[float], float], Floats]]
"""Coefficient, its derivative and the matrix of each term."""


@dataclass
class DenseLine:
    """Spectra of (lambda^2 M + lambda C + K) x = 0 with matrices that depend on one parameter."""

    stiffness: Pieces
    mass: Pieces
    damping: Pieces | None
    end: float
    level: float = 0.0
    made: int = field(default=0, init=False)

    @property
    def window(self) -> Window:
        """What is looked at."""
        return Window(self.end, self.damping is not None, self.level)

    def matrices(self, t: float) -> tuple[Floats, Floats]:
        """The standard form A w = z w and its derivative: M^-1 (K, C) as L^-1 (.) L^-T."""
        K, dK = _sum(self.stiffness, t)
        M, dM = _sum(self.mass, t)
        if self.damping is None:
            inverse = np.linalg.inv(M)
            A = inverse @ K
            return A, inverse @ (dK - dM @ A)
        C, dC = _sum(self.damping, t)
        n, inverse = len(M), np.linalg.inv(M)
        zero, one = np.zeros((n, n)), np.eye(n)
        A = np.block([[zero, one], [-inverse @ K, -inverse @ C]])
        moved = np.hstack([dK, dC]) + np.hstack([-dM @ inverse @ K, -dM @ inverse @ C])
        return A, np.vstack([np.zeros((n, 2 * n)), -inverse @ moved])

    def at(self, value: float) -> Sample:
        """The spectrum at a value."""
        self.made += 1
        A, dA = self.matrices(value)
        z, left, right = eig(A, left=True, right=True)
        overlap = np.einsum("ij,ij->j", left.conj(), right)
        overlap = np.where(overlap == 0, 1e-300, overlap)
        slopes = np.einsum("ij,ij->j", left.conj(), dA @ right) / overlap
        condition = np.minimum(1 / np.abs(overlap), 1e16)
        errors = 8 * EPS * np.linalg.norm(A) * condition
        if self.damping is None:
            slopes = np.where(z.imag == 0, slopes.real, slopes)
        kept = np.abs(self.window.roots(z).imag) <= MARGIN * self.end
        numbers = np.arange(int(kept.sum()))
        return Sample(
            value, z[kept], slopes[kept], errors[kept], errors[kept], numbers, right[:, kept]
        )


def _sum(pieces: Pieces, t: float) -> tuple[Floats, Floats]:
    value = sum(c(t) * matrix for c, _, matrix in pieces)
    slope = sum(d(t) * matrix for _, d, matrix in pieces)
    return np.asarray(value), np.asarray(slope)


def constant(matrix: Floats) -> Pieces:
    return [(lambda t: 1.0, lambda t: 0.0, matrix)]


def linear(first: Floats, second: Floats) -> Pieces:
    """A + t B."""
    return [*constant(first), (lambda t: t, lambda t: 1.0, second)]


def random_line(
    seed: int, *, damping: float | None = None, level: float = 0.0, nonlinear: bool = False
) -> DenseLine:
    """A random pencil of 4, 6 or 10 unknowns; damping is a factor on a damping of about 2 %."""
    generator = np.random.default_rng(seed)
    n = int(generator.choice([4, 6, 10]))
    Q = generator.standard_normal((n, n))
    M = Q @ Q.T / n + np.eye(n)
    w = np.sort(generator.uniform(1, 6, n))
    V, _ = qr(generator.standard_normal((n, n)))
    L = np.linalg.cholesky(M)
    K = L @ ((V * w**2) @ V.T) @ L.T
    X = generator.standard_normal((n, n))
    A = L @ (X - generator.choice([0.2, 1.0]) * X.T) @ L.T * generator.choice([1.0, 3.0])
    Y = generator.standard_normal((n, n))
    C = L @ (0.02 * np.eye(n) + 0.02 * Y @ Y.T / n) @ L.T
    end = float(w[-1] * generator.choice([0.75, 1.3]))
    stiffness, mass = linear((K + K.T) / 2, A), constant((M + M.T) / 2)
    if nonlinear:
        Z = generator.standard_normal((n, n))
        wave = lambda t: np.sin(5 * t), lambda t: 5 * np.cos(5 * t)
        stiffness = [*stiffness, (*wave, 0.5 * L @ Z @ L.T)]
        mass = [*mass, (lambda t: t * t, lambda t: 2 * t, 0.3 * M)]
    damped = constant(damping * (C + C.T) / 2) if damping is not None else None
    return DenseLine(stiffness, mass, damped, end, level)


def coupled_pairs(
    pairs: Sequence[tuple[float, float, float, float]],
    *,
    end: float,
    damping: float | None = None,
    level: float = 0.0,
    singles: Sequence[tuple[float, float]] = (),
) -> DenseLine:
    """Pairs kappa = w +- c sqrt((t - t0) (t - t1)) and modes w + slope t, mixed.

    ``pairs`` has w, c, t0, t1 of each, ``singles`` w and the slope; a damping c is c times the
    unit matrix.
    """
    n = 2 * len(pairs) + len(singles)
    K, A = np.zeros((2, n, n))
    for number, (w, c, t0, t1) in enumerate(pairs):
        i, j = 2 * number, 2 * number + 1
        K[i, i] = K[j, j] = w
        K[i, j], A[i, j], K[j, i], A[j, i] = -c * t0, c, -c * t1, c
    for i, (w, slope) in enumerate(singles, 2 * len(pairs)):
        K[i, i], A[i, i] = w, slope
    Q, _ = qr(np.random.default_rng(0).standard_normal((n, n)))
    stiffness = linear(Q @ K @ Q.T, Q @ A @ Q.T)
    damped = constant(damping * np.eye(n)) if damping is not None else None
    return DenseLine(stiffness, constant(np.eye(n)), damped, end, level)


def scan(line: DenseLine, values: Floats) -> Ints:
    """Number of growing eigenvalues of both half planes at values, by dense eigenvalues."""
    numbers = []
    for value in values:
        z = eigvals(line.matrices(float(value))[0])
        window = line.window
        roots = window.roots(z)
        least = 0.0 if window.damped else 1e-7 * np.abs(roots) + 1e-9
        grows = (window.growth(z) > least) & ~window.far(z, 1.0)
        numbers.append(int(grows.sum()))
    return np.array(numbers)


def disagreements(found: Found, values: Floats, numbers: Ints, slack: float = 2e-6) -> Ints:
    """Values at which thresholds foresee another number of growing eigenvalues than a scan has."""
    places = np.array([each.value for each in found.thresholds])
    changes = np.array([each.change for each in found.thresholds])
    foreseen = np.array(
        [changes[(places > values[0]) & (places <= value)].sum() for value in values]
    )
    wrong = foreseen + numbers[0] != numbers
    for value in places:
        wrong &= np.abs(values - value) > slack
    for each in found.unresolved:
        wrong &= (values < each.low - slack) | (values > each.high + slack)
    return np.flatnonzero(wrong)
