"""Random pencils of known eigenvalues: multiple ones, friction, damping, rotation, graded ones.

A matrix is as well determined by its entries as it was before its rows and columns were multiplied
by powers of two, which rounds nothing: eigenvalues of a graded pencil are those of the matrices
before.
"""

from dataclasses import dataclass, replace

import numpy as np
from dense_reference import dense_linear, dense_quadratic
from scipy.linalg import eigh
from scipy.sparse import csr_array

from cea.eigen.pencil import Pencil, Term
from cea.eigen.unformed import LowRank, UnformedTerm
from cea.matrices import distributed
from cea.petsc import MPI
from cea.ranks import local_rows

POWERS = (5, 10, 20, 30, 40)
"""Unknowns are scaled by powers of two up to these, up and down."""


@dataclass(frozen=True)
class RandomPencil:
    """Dense matrices of lambda^2 M + lambda D + K, and a window of it."""

    name: str
    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray | None
    max_frequency: float  # end of the window (Hz)
    min_growth: float | None = None  # lower end of Re lambda (1/s); None leaves it to the driver
    low_rank: tuple[np.ndarray, np.ndarray] | None = None  # W and d of W diag(d) W^T, beside D
    friction: np.ndarray | None = None  # K_f of K - K_f, unsymmetric and of few ranks: one term
    # factors of rows and columns by which the pencil is graded
    scales: tuple[np.ndarray, np.ndarray] | None = None

    def scaled(self, matrix):
        """A matrix with its rows and columns scaled."""
        if self.scales is None:
            return matrix
        return self.scales[0][:, None] * matrix * self.scales[1]

    def pencil(self) -> Pencil:
        """The pencil, on all ranks."""
        scaled = [
            None if each is None else self.scaled(each)
            for each in (self.mass, self.damping, self.stiffness)
        ]
        made = pencil_of(*scaled, self.low_rank, graded=self.scales is not None)
        if self.friction is None:
            return made
        friction = Term("stiffness", on_all_ranks(-self.friction), symmetric=False)
        return Pencil([*made.terms, friction])

    def dense(self):
        """All eigenvalues kappa of an undamped one, or lambda and their errors of a damped one."""
        D, end = self.damping, 2 * np.pi * self.max_frequency
        if self.low_rank is not None:
            W, d = self.low_rank
            D = (W * d) @ W.T + (0 if D is None else D)
        if D is None:
            friction = 0.0 if self.friction is None else self.friction
            return dense_linear(self.mass, self.stiffness - friction)
        return dense_quadratic(self.mass, D, self.stiffness, end)


def pencil_of(mass, damping, stiffness, low_rank=None, *, graded=False) -> Pencil:
    """A pencil of dense matrices, symmetric parts and the rest, and of a piece of low rank.

    Of graded ones symmetric are the entries that equal their mirror images.
    """
    terms = []
    for role, matrix in (("mass", mass), ("stiffness", stiffness), ("damping", damping)):
        if matrix is None:
            continue
        half = np.where(matrix == matrix.T, matrix, 0.0) if graded else _symmetric(matrix)
        if half.any() or role != "damping":
            terms.append(Term(role, on_all_ranks(half)))
        if (matrix != half).any():
            terms.append(Term(role, on_all_ranks(matrix - half), symmetric=False))
    pieces = [] if low_rank is None else [UnformedTerm(LowRank(*low_rank))]
    return Pencil(terms, low_rank=pieces)


def on_all_ranks(matrix):
    """A dense matrix as PETSc AIJ, each rank with its rows."""
    first, last = local_rows(len(matrix), MPI.COMM_WORLD)
    return distributed(csr_array(matrix[first:last]), (last - first, len(matrix)), MPI.COMM_WORLD)


def random_linear(seed: int) -> RandomPencil:
    """A pencil with eigenvalues of multiplicity 2 to 30, with and without friction.

    Without friction its kappa are zero or positive. Friction has few ranks: it moves as many copies
    of an eigenvalue and leaves the others, wherever it is not kept to a few eigenspaces.
    """
    rng = np.random.default_rng(seed)
    kappa = _with_copies(rng)
    n = len(kappa)
    basis, root = np.eye(n), np.eye(n)  # copies equal to the last bit
    if rng.random() < 0.6:  # or but for rounding
        basis = np.linalg.qr(rng.standard_normal((n, n)))[0]
    if rng.random() < 0.5:  # a mass that is not the identity
        root = np.linalg.qr(rng.standard_normal((n, n)))[0] * np.geomspace(1, 30, n) ** 0.5
    half = root @ basis
    stiffness, mass = _symmetric((half * kappa) @ half.T), _symmetric(root @ root.T)
    friction = half @ _of_few_ranks(rng, kappa) @ half.T if rng.random() < 0.7 else None
    low = kappa[(kappa > 0) & (kappa <= np.quantile(kappa, rng.choice([0.3, 0.6, 1.0])))]
    end = rng.choice(low if len(low) else kappa[kappa > 0]) * rng.choice([0.97, 1.03, 1.5])
    end = float(np.sqrt(end) / (2 * np.pi))
    return RandomPencil(f"linear {seed}", mass, stiffness, None, end, friction=friction)


def _with_copies(rng) -> np.ndarray:
    """Some of multiplicity 2 to 30, zero now and then among them, and many single ones above."""
    values = [20.0 * np.geomspace(0.02, 1e3, rng.integers(40, 160)) * rng.uniform(0.9, 1.1)]
    for _ in range(rng.integers(1, 5)):
        value = 0.0 if rng.random() < 0.3 else rng.uniform(0.5, 20.0)
        values.append(np.full(rng.integers(2, 31), value))
    return np.sort(np.concatenate(values)) * 10.0 ** rng.integers(-3, 9)


def _of_few_ranks(rng, kappa) -> np.ndarray:
    """An unsymmetric matrix of one to three ranks, as large as a part of the eigenvalues."""
    n, ranks = len(kappa), int(rng.integers(1, 4))
    left, right = rng.standard_normal((2, n, ranks))
    if rng.random() < 0.4:  # it acts on the eigenspaces of two eigenvalues only
        acts = np.isin(kappa, rng.choice(np.unique(kappa), 2))
        left, right = left * acts[:, None], right * acts[:, None]
    return left @ right.T * np.median(kappa) * 10.0 ** rng.uniform(-4, 0) / n


def random_quadratic(seed: int) -> RandomPencil:
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
    least = None if np.isnan(down) else float(-down)
    end = float(end / (2 * np.pi))
    return RandomPencil(f"damped {seed}", _symmetric(M), K * unit**2, D * unit, end, least)


def random_low_rank(seed: int) -> RandomPencil:
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
    other = problem.damping if rng.random() < 0.5 else None
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


_KINDS = ("similar", "two-sided", "congruent", "two units", "near defective", "beside a large one")


def random_graded(seed: int, power: int | None = None, *, damped: bool = False) -> RandomPencil:
    """A graded pencil of 4 to 60 unknowns, of a largest power of two, or one that is drawn.

    With damping or rotation where it is damped.
    """
    rng, kind = np.random.default_rng([seed, 8 if damped else 7]), _KINDS[seed % (6 - damped)]
    drawn = int(rng.choice(POWERS))
    power = drawn if power is None else power
    n = int(rng.integers(4, 9) if rng.random() < 0.7 else rng.integers(9, 61))
    M, A = np.eye(n), _unsymmetric(rng, n)
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
            left = np.where(first, *2.0 ** rng.integers(-power, power + 1, 2))
            right = np.where(first, *2.0 ** rng.integers(-power, power + 1, 2))
        case "near defective":
            A = np.diag(rng.uniform(0.5, 1.5, n))
            A[0, 0] = A[1, 1] = 1.0
            A[0, 1], A[1, 0] = 0.5, rng.choice([0.0, 1e-4, -1e-4, 1e-8, -1e-8, 1e-12])
            A[2:, 2:] += 0.2 * rng.standard_normal((n - 2, n - 2)) / np.sqrt(n)
        case "beside a large one":  # which hides how the others are graded
            A[0, 0] = 2.0 ** (power + rng.integers(0, 5))
    end = float(rng.uniform(0.6, 1.6) / (2 * np.pi))
    D, name = _damping(rng, n) if damped else None, f"graded {seed}: {kind}, 2^{power}"
    return RandomPencil(name, M, A, D, end, scales=(left, right))


def _powers(rng, n, power) -> np.ndarray:
    """Random ones, or rising with the unknowns, or of two units."""
    kind = rng.integers(3)
    if kind == 0:
        return 2.0 ** rng.integers(-power, power + 1, n)
    if kind == 1:
        return 2.0 ** np.round(np.linspace(-power, power, n))
    return np.where(np.arange(n) < n // 2, 2.0**power, 2.0**-power)


def _unsymmetric(rng, n) -> np.ndarray:
    """An unsymmetric matrix with eigenvalues about one, or anywhere."""
    if rng.random() < 0.7:
        return np.diag(rng.uniform(0.5, 1.5, n)) + 0.3 * rng.standard_normal((n, n)) / np.sqrt(n)
    return rng.standard_normal((n, n)) / np.sqrt(n) + 0.5 * np.eye(n)


def _mass(rng, n) -> np.ndarray:
    """A symmetric positive definite one."""
    half = np.eye(n) + 0.3 * rng.standard_normal((n, n)) / np.sqrt(n)
    return _symmetric(half @ half.T)


def _damping(rng, n) -> np.ndarray:
    """Damping, rotation, or both; unsymmetric now and then."""
    half = rng.standard_normal((n, n)) / np.sqrt(n)
    size, kind = 10.0 ** rng.uniform(-3, 0), rng.integers(4)
    kinds = [
        np.diag(rng.uniform(0.2, 1.0, n)),
        half @ half.T,
        half - half.T,
        half + np.eye(n),
    ]
    return size * kinds[kind]


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
    # triangular with ones on the diagonal: inverses are whole too
    of_low, of_high = (np.rint(np.linalg.inv(each)).astype(int) for each in (low, high))
    whole = low @ high @ np.diag(kappa) @ of_high @ of_low
    assert np.abs(whole).max() < 2**53
    return whole.astype(float), kappa.astype(float)


def _symmetric(matrix) -> np.ndarray:
    return 0.5 * (matrix + matrix.T)
