"""Random pencils whose unknowns and equations are scaled far apart, of known eigenvalues.

A matrix is as well determined by its entries as it was before its rows and columns were multiplied
by powers of two, which rounds nothing: eigenvalues are those of the matrices before. Damping,
rotation, friction and pairs next to defective are among them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from dense_reference import Dense, dense_quadratic
from petsc_matrices import to_petsc
from scipy.linalg import cholesky, eig, solve_triangular

from cea.eigen.pencil import Pencil, Term

_EPS = np.finfo(float).eps
POWERS = (5, 10, 20, 30, 40)
"""Unknowns are scaled by powers of two up to these, up and down."""


@dataclass(frozen=True)
class Plain:
    """Matrices of lambda^2 M + lambda D + K that are scaled well, dense; D is None without."""

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray | None = None


@dataclass(frozen=True)
class Graded:
    """A graded pencil, and what it is made of.

    Parameters
    ----------
    name
        Kind and size of the grading.
    plain
        The matrices before rows and columns were scaled.
    left, right
        Factors of rows and columns, powers of two.
    max_frequency
        End of the window (Hz).
    """

    name: str
    plain: Plain
    left: np.ndarray
    right: np.ndarray
    max_frequency: float

    def scaled(self, matrix: np.ndarray) -> np.ndarray:
        """A matrix with its rows and columns scaled."""
        return self.left[:, None] * matrix * self.right

    def pencil(self) -> Pencil:
        """The pencil: entries that equal their mirror images, and the rest, to the last bit."""
        terms = [Term("mass", to_petsc(self.scaled(self.plain.mass)))]
        terms += _terms("stiffness", self.scaled(self.plain.stiffness))
        if self.plain.damping is not None:
            terms += _terms("damping", self.scaled(self.plain.damping))
        return Pencil(terms)

    def dense(self) -> Dense:
        """All eigenvalues kappa of an undamped one."""
        root = cholesky(self.plain.mass, lower=True)
        half = solve_triangular(root, self.plain.stiffness, lower=True)
        A = solve_triangular(root, half.T, lower=True).T
        kappa, left, right = eig(A, left=True, right=True)
        overlap = np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), _EPS)
        spread = np.linalg.cond(self.plain.mass)
        error = 4 * np.sqrt(len(A)) * _EPS * np.linalg.norm(A, 2) * spread / overlap
        return Dense(kappa, error, symmetric=False)

    def dense_quadratic(self) -> tuple[np.ndarray, np.ndarray]:
        """All eigenvalues lambda of a damped one, and their errors."""
        plain, end = self.plain, 2 * np.pi * self.max_frequency
        return dense_quadratic(plain.mass, plain.damping, plain.stiffness, end)


def _terms(role, matrix) -> list[Term]:
    equal = np.where(matrix == matrix.T, matrix, 0.0)
    terms = [Term(role, to_petsc(equal))]
    if (matrix != equal).any():
        terms.append(Term(role, to_petsc(matrix - equal), symmetric=False))
    return terms


def random_graded(seed: int, power: int | None = None) -> Graded:
    """A graded pencil of 2 to 60 unknowns.

    Parameters
    ----------
    seed
        Of the random numbers.
    power
        Largest power of two; None draws one.
    """
    return _drawn(_KINDS, np.random.default_rng([seed, 7]), seed, power)


def _drawn(kinds, rng, seed, power) -> Graded:
    drawn = int(rng.choice(POWERS))
    return kinds[seed % len(kinds)](rng, drawn if power is None else power)


def _size(rng) -> int:
    return int(rng.integers(2, 9) if rng.random() < 0.7 else rng.integers(9, 61))


def _powers(rng, n, power) -> np.ndarray:
    """Random ones, or rising with the unknowns, or of two units."""
    kind = rng.integers(3)
    if kind == 0:
        return 2.0 ** rng.integers(-power, power + 1, n)
    if kind == 1:
        return 2.0 ** np.round(np.linspace(-power, power, n))
    return np.where(np.arange(n) < n // 2, 2.0**power, 2.0**-power)


def _matrix(rng, n) -> np.ndarray:
    """An unsymmetric matrix with eigenvalues about one, or anywhere."""
    if rng.random() < 0.7:
        return np.diag(rng.uniform(0.5, 1.5, n)) + 0.3 * rng.standard_normal((n, n)) / np.sqrt(n)
    return rng.standard_normal((n, n)) / np.sqrt(n) + 0.5 * np.eye(n)


def _mass(rng, n) -> np.ndarray:
    """A symmetric positive definite one."""
    half = np.eye(n) + 0.3 * rng.standard_normal((n, n)) / np.sqrt(n)
    whole = half @ half.T
    return 0.5 * (whole + whole.T)


def _window(rng) -> float:
    return float(rng.uniform(0.6, 1.6) / (2 * np.pi))


def _similar(rng, power) -> Graded:
    n = _size(rng)
    scale = _powers(rng, n, power)
    plain = Plain(np.eye(n), _matrix(rng, n))
    return Graded(f"D A D^-1, 2^{power}", plain, scale, 1 / scale, _window(rng))


def _two_sided(rng, power) -> Graded:
    n = _size(rng)
    plain = Plain(np.diag(rng.uniform(0.3, 3.0, n)), _matrix(rng, n))
    left, right = _powers(rng, n, power), _powers(rng, n, power)
    return Graded(f"D1 A D2, M = D1 M0 D2, 2^{power}", plain, left, right, _window(rng))


def _congruent(rng, power) -> Graded:
    n = _size(rng)
    scale = _powers(rng, n, power)
    plain = Plain(_mass(rng, n), _matrix(rng, n))
    return Graded(f"D A D, dense D M D, 2^{power}", plain, scale, scale, _window(rng))


def _units(rng, power) -> Graded:
    """Unknowns of two units, and equations of two, beside a mass that couples none of different."""
    n = max(_size(rng), 4)
    mass = np.zeros((n, n))
    first = slice(0, n // 2), slice(n // 2, n)
    for part in first:
        mass[part, part] = _mass(rng, part.stop - part.start)
    scales = []
    for _ in range(2):
        low, high = 2.0 ** rng.integers(-power, power + 1, 2)
        scales.append(np.where(np.arange(n) < n // 2, low, high))
    plain = Plain(mass, _matrix(rng, n))
    return Graded(f"two units, 2^{power}", plain, *scales, _window(rng))


def _defective(rng, power) -> Graded:
    """A pair of eigenvalues that meet, or nearly so."""
    n = max(_size(rng), 3)
    A = np.diag(rng.uniform(0.5, 1.5, n))
    A[0, 0] = A[1, 1] = 1.0
    A[0, 1], A[1, 0] = 0.5, rng.choice([0.0, 1e-4, -1e-4, 1e-8, -1e-8, 1e-12])
    A[:, 2:] += 0.2 * rng.standard_normal((n, n - 2)) / np.sqrt(n) * (np.arange(n) > 1)[:, None]
    scale = _powers(rng, n, power)
    return Graded(f"near a Jordan block, 2^{power}", Plain(np.eye(n), A), scale, 1 / scale, 0.25)


def sheared(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Integers that no scaling makes well-conditioned, shape (n, n), and eigenvalues, exact.

    P diag(kappa) P^-1 with whole numbers throughout: P is a product of triangular matrices with
    ones on the diagonal.
    """
    rng = np.random.default_rng([seed, 9])
    n = int(rng.integers(2, 6))
    size = int(rng.integers(1, {2: 3000, 3: 60, 4: 12, 5: 6}[n]))
    low = np.tril(rng.integers(-size, size + 1, (n, n)), -1) + np.eye(n, dtype=int)
    high = np.triu(rng.integers(-size, size + 1, (n, n)), 1) + np.eye(n, dtype=int)
    kappa = rng.permutation(np.arange(1, 2 * n + 1))[:n]
    there = (low @ high).astype(object)
    back = np.eye(n, dtype=object)
    for factor in (low, high):  # of whole numbers, by substitution
        back = _inverse(factor.astype(object)) @ back
    whole = there @ np.diag(kappa).astype(object) @ back
    assert max(abs(entry) for entry in whole.flat) < 2**53
    return whole.astype(float), kappa.astype(float)


def _inverse(unit: np.ndarray) -> np.ndarray:
    """Of a triangular matrix with ones on the diagonal: 1 - N + N^2 and so on."""
    nilpotent = unit - np.eye(len(unit), dtype=object)
    total, power = np.eye(len(unit), dtype=object), np.eye(len(unit), dtype=object)
    for _ in range(len(unit) - 1):
        power = -power @ nilpotent
        total = total + power
    return total


def _damping(rng, n) -> np.ndarray:
    """Damping, rotation, or both; unsymmetric now and then."""
    half = rng.standard_normal((n, n)) / np.sqrt(n)
    size = 10.0 ** rng.uniform(-3, 0)
    kind = rng.integers(4)
    if kind == 0:
        return size * np.diag(rng.uniform(0.2, 1.0, n))
    if kind == 1:
        return size * half @ half.T
    if kind == 2:
        return size * (half - half.T)
    return size * (half + np.eye(n))


def _damped(of: Callable) -> Callable:
    def made(rng, power) -> Graded:
        before = of(rng, power)
        plain = before.plain
        damping = _damping(rng, len(plain.mass))
        return Graded(
            f"damped, {before.name}",
            Plain(plain.mass, plain.stiffness, damping),
            before.left,
            before.right,
            before.max_frequency,
        )

    return made


def _hidden(rng, power) -> Graded:
    """A stiffness far beyond all other entries, that hides how they are graded."""
    before = _similar(rng, min(power, 20))
    stiffness = before.plain.stiffness.copy()
    stiffness[0, 0] = 2.0 ** (power + rng.integers(0, 5))
    plain = Plain(before.plain.mass, stiffness)
    name = f"beside a large entry, {before.name}"
    return Graded(name, plain, before.left, before.right, before.max_frequency)


_KINDS = (_similar, _two_sided, _congruent, _units, _defective, _hidden)
_DAMPED = tuple(_damped(kind) for kind in _KINDS[:-1])


def random_graded_damped(seed: int, power: int | None = None) -> Graded:
    """A damped or rotating one.

    Parameters
    ----------
    seed
        Of the random numbers.
    power
        Largest power of two; None draws one.
    """
    return _drawn(_DAMPED, np.random.default_rng([seed, 8]), seed, power)
