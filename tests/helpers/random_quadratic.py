"""Random damped, rotating pencils, with friction, with clusters and defective pairs among them."""

from dataclasses import dataclass, replace

import numpy as np
from petsc_matrices import to_petsc
from scipy.linalg import eigh

from cea.eigen.pencil import Pencil, Term
from cea.eigen.unformed import LowRank, UnformedTerm


@dataclass(frozen=True)
class RandomQuadratic:
    """Matrices of lambda^2 M + lambda D + K, and a window of it.

    Parameters
    ----------
    mass, damping, stiffness
        M, D and K, dense.
    max_frequency
        End of the window (Hz).
    min_growth
        Its lower end of Re lambda (1/s); None leaves it to the driver.
    low_rank
        W and d of W diag(d) W^T, beside D, that is kept as a piece of low rank.
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    max_frequency: float
    min_growth: float | None
    low_rank: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def whole_damping(self) -> np.ndarray:
        """D with what is of low rank."""
        if self.low_rank is None:
            return self.damping
        W, d = self.low_rank
        return self.damping + (W * d) @ W.T

    def pencil(self) -> Pencil:
        """The pencil, symmetric and skew parts as pieces of their own."""
        return pencil_of(self.mass, self.damping, self.stiffness, self.low_rank)


def pencil_of(mass, damping, stiffness, low_rank=None) -> Pencil:
    """A pencil of dense matrices, and of a piece of low rank."""
    terms = [Term("mass", to_petsc(mass)), Term("stiffness", to_petsc(_symmetric(stiffness)))]
    rest = stiffness - _symmetric(stiffness)
    if rest.any():
        terms.append(Term("stiffness", to_petsc(rest), symmetric=False))
    drag, turn = _symmetric(damping), damping - _symmetric(damping)
    if drag.any():
        terms.append(Term("damping", to_petsc(drag)))
    if turn.any():
        terms.append(Term("damping", to_petsc(turn), symmetric=False))
    if low_rank is None:
        return Pencil(terms)
    return Pencil(terms, low_rank=[UnformedTerm(LowRank(*low_rank))])


def random_quadratic(seed: int) -> RandomQuadratic:
    """A pencil of up to 60 unknowns: damping from 1e-12 to beyond critical, rotation, friction."""
    rng = np.random.default_rng(seed)
    kappa, blocks = _spectrum(rng), _special(rng)
    n = len(kappa) + 2 * len(blocks)
    speed = float(np.sqrt(np.median(kappa[kappa > 0])))
    K, D = np.zeros((n, n)), np.zeros((n, n))
    first = len(kappa)
    K[:first, :first], D[:first, :first] = _coupled(rng, kappa, speed)
    for i, (damping, stiffness) in enumerate(blocks):
        part = slice(first + 2 * i, first + 2 * i + 2)
        K[part, part], D[part, part] = stiffness * speed**2, damping * speed
    M = np.eye(n)
    if rng.random() < 0.7:
        turn = np.linalg.qr(rng.standard_normal((n, n)))[0]
        if rng.random() < 0.6:
            turn = turn * np.geomspace(1, 10, n) ** 0.5
        M, D, K = (turn @ each @ turn.T for each in (M, D, K))
    unit = 10.0 ** rng.integers(-2, 5)
    speeds = np.sqrt(kappa[kappa > 0])
    end = rng.choice(speeds[: max(2, int(len(speeds) * rng.choice([0.2, 0.5, 1.0])))])
    end *= unit * rng.choice([0.97, 1.03, 1.5])
    down = rng.choice([np.nan, 0.0, 0.01, 0.5, 2.0]) * end
    return RandomQuadratic(
        _symmetric(M),
        D * unit,
        K * unit**2,
        float(end / (2 * np.pi)),
        None if np.isnan(down) else float(-down),
    )


def random_low_rank(seed: int) -> RandomQuadratic:
    """The same with damping of low rank: of modes, from 1e-12 to next to critical, or of any few.

    Half of them have no other.
    """
    problem, rng = random_quadratic(seed), np.random.default_rng([seed, 1])
    M, n = problem.mass, len(problem.mass)
    values, vectors = eigh(_symmetric(problem.stiffness), M)
    elastic = np.flatnonzero(values > 1e-8 * values[-1])
    damped = elastic[: int(rng.integers(1, 1 + len(elastic)))]
    W = M @ vectors[:, damped]
    ratios = 10.0 ** rng.uniform(-12, 0) * np.ones(len(damped))
    if rng.random() < 0.5:
        ratios = rng.choice([1e-12, 1e-6, 1e-2, 0.3, 0.999], len(damped))
    d = 2 * ratios * np.sqrt(values[damped])
    if rng.random() < 0.2:
        W = rng.standard_normal((n, int(rng.integers(1, 4))))
        d = d[: W.shape[1]] * 10.0 ** rng.uniform(-3, 0)
        W, d = W[:, : len(d)], d
    other = problem.damping if rng.random() < 0.5 else np.zeros((n, n))
    return replace(problem, damping=other, low_rank=(W, d))


def _spectrum(rng) -> np.ndarray:
    values = [np.geomspace(0.05, 300.0, rng.integers(4, 30)) * rng.uniform(0.8, 1.2)]
    for _ in range(rng.integers(0, 4)):
        value = 0.0 if rng.random() < 0.2 else rng.uniform(0.1, 20.0)
        values.append(np.full(rng.integers(2, 7), value))
    return np.sort(np.concatenate(values))


def _special(rng) -> list[tuple[np.ndarray, np.ndarray]]:
    """Damping and stiffness of two-by-two pencils at which two eigenvalues meet."""
    kinds = [
        (np.diag([2.0, 0.0]), np.diag([1.0, 0.7])),  # critically damped
        (np.zeros((2, 2)), np.array([[2.5, -0.125], [0.5, 2.0]])),  # mode coupling at its threshold
        (0.04 * np.eye(2), np.array([[2.5, -0.125], [0.5, 2.0]])),  # the same, damped alike
        (np.array([[0.0, -2.0], [2.0, 0.0]]), -np.eye(2)),  # held by rotation, just
        (np.array([[0.02, -0.4], [0.4, 0.02]]), np.array([[1.0, -0.3], [0.3, 1.0]])),
    ]
    number = int(rng.choice([0, 0, 1, 2]))
    return [kinds[int(rng.integers(len(kinds)))] for _ in range(number)]


def _coupled(rng, kappa, speed) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and damping: friction, damping of several kinds, rotation."""
    n = len(kappa)
    K, D = np.diag(kappa), np.zeros((n, n))
    if rng.random() < 0.6:
        left, right = rng.standard_normal((2, n, int(rng.integers(1, 4))))
        K = K + left @ right.T * speed**2 * 10.0 ** rng.uniform(-4, 0) / n
    size = 10.0 ** rng.uniform(-12, 0.7)
    kind = rng.choice(["none", "mass", "stiffness", "modal", "few", "negative"])
    if kind == "mass":
        D = D + size * speed * np.eye(n)
    elif kind == "stiffness":
        D = D + np.diag(size * kappa / speed)
    elif kind == "modal":
        D = D + np.diag(2 * size * np.sqrt(kappa))
    elif kind == "few":
        where = rng.standard_normal((n, int(rng.integers(1, 4))))
        D = D + size * speed * where @ where.T
    elif kind == "negative":
        where = rng.standard_normal((n, 1))
        D = D + 1e-2 * speed * np.eye(n) - min(size, 0.3) * speed * where @ where.T / n
    if rng.random() < 0.5 or kind == "none":
        skew = rng.standard_normal((n, n))
        D = D + (skew - skew.T) * speed * 10.0 ** rng.uniform(-6, 0.3) / np.sqrt(n)
    return K, D


def _symmetric(matrix) -> np.ndarray:
    return 0.5 * (matrix + matrix.T)
