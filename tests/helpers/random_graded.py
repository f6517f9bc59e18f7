"""Random pencils whose unknowns and equations are scaled far apart, of known eigenvalues.

A matrix is as well determined by its entries as it was before its rows and columns were multiplied
by powers of two, which rounds nothing: eigenvalues are those of the matrices before. Damping,
rotation, friction and pairs next to defective are among them.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from dense_reference import dense_linear, dense_quadratic
from petsc_matrices import to_petsc

from cea.eigen.pencil import Pencil, Term

POWERS = (5, 10, 20, 30, 40)
"""Unknowns are scaled by powers of two up to these, up and down."""


class Plain(NamedTuple):
    """Matrices of lambda^2 M + lambda D + K that are scaled well, dense; D may be None."""

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray | None


@dataclass(frozen=True)
class Graded:
    """A pencil by its kind, the matrices before, factors of rows and columns, and a window (Hz)."""

    name: str
    plain: Plain
    left: np.ndarray
    right: np.ndarray
    max_frequency: float

    def scaled(self, matrix):
        """A matrix with its rows and columns scaled."""
        return self.left[:, None] * matrix * self.right

    def pencil(self) -> Pencil:
        """The pencil: entries that equal their mirror images, and the rest, to the last bit."""
        terms = []
        for role, matrix in zip(Plain._fields, self.plain, strict=True):
            if matrix is not None:
                whole = self.scaled(matrix)
                equal = np.where(whole == whole.T, whole, 0.0)
                terms.append(Term(role, to_petsc(equal)))
                if (whole != equal).any():
                    terms.append(Term(role, to_petsc(whole - equal), symmetric=False))
        return Pencil(terms)

    def dense(self):
        """All eigenvalues kappa of an undamped one."""
        return dense_linear(self.plain.mass, self.plain.stiffness)

    def dense_quadratic(self):
        """All eigenvalues lambda of a damped one, and their errors."""
        plain, end = self.plain, 2 * np.pi * self.max_frequency
        return dense_quadratic(plain.mass, plain.damping, plain.stiffness, end)


_KINDS = ("similar", "two-sided", "congruent", "two units", "near defective", "beside a large one")


def random_graded(seed: int, power: int | None = None) -> Graded:
    """A graded pencil of 4 to 60 unknowns, of a largest power of two, or one that is drawn."""
    return _drawn(np.random.default_rng([seed, 7]), _KINDS[seed % len(_KINDS)], power)


def random_graded_damped(seed: int, power: int | None = None) -> Graded:
    """A damped or rotating one."""
    rng = np.random.default_rng([seed, 8])
    return _drawn(rng, _KINDS[seed % (len(_KINDS) - 1)], power, _damping)


def _drawn(rng, kind, power, damping=lambda rng, n: None) -> Graded:
    drawn = int(rng.choice(POWERS))
    power = drawn if power is None else power
    n = int(rng.integers(4, 9) if rng.random() < 0.7 else rng.integers(9, 61))
    M, A = np.eye(n), _matrix(rng, n)
    left = _powers(rng, n, min(power, 20) if kind == "beside a large one" else power)
    right = 1 / left
    match kind:
        case "two-sided":
            M, right = np.diag(rng.uniform(0.3, 3.0, n)), _powers(rng, n, power)
        case "congruent":
            M, right = _mass(rng, n), left
        case "two units":  # of unknowns and of equations; the mass couples none of different
            first = np.arange(n) < n // 2
            M = _mass(rng, n) * (first == first[:, None])
            left, right = (np.where(first, *2.0 ** rng.integers(-power, power + 1, 2))
                           for _ in range(2))  # fmt: skip
        case "near defective":
            A = np.diag(rng.uniform(0.5, 1.5, n))
            A[0, 0] = A[1, 1] = 1.0
            A[0, 1], A[1, 0] = 0.5, rng.choice([0.0, 1e-4, -1e-4, 1e-8, -1e-8, 1e-12])
            A[2:, 2:] += 0.2 * rng.standard_normal((n - 2, n - 2)) / np.sqrt(n)
        case "beside a large one":  # which hides how the others are graded
            A[0, 0] = 2.0 ** (power + rng.integers(0, 5))
    end = float(rng.uniform(0.6, 1.6) / (2 * np.pi))
    return Graded(f"{kind}, 2^{power}", Plain(M, A, damping(rng, n)), left, right, end)


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
