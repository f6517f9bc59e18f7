"""Thresholds along a parameter beside dense eigenvalues at very many values."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.linalg import eig, eigvals, qr

from cea.reduced.following import Sample
from cea.reduced.spectrum import MARGIN, Window
from cea.reduced.thresholds import thresholds_along

EPS = np.finfo(float).eps


@dataclass
class DenseLine:
    """Spectra of (lambda^2 M + lambda C + K) x = 0 with matrices that depend on one parameter.

    Each is told by coefficient, its derivative and the matrix of each term.
    """

    stiffness: list
    mass: list
    damping: list | None
    end: float
    level: float = 0.0

    @property
    def window(self):
        """What is looked at."""
        return Window(self.end, self.damping is not None, self.level)

    def matrices(self, t):
        """The standard form A w = z w and its derivative."""

        def summed(pieces):
            return (sum(each[i](t) * each[2] for each in pieces) for i in (0, 1))

        (K, dK), (M, dM) = summed(self.stiffness), summed(self.mass)
        n, inverse = len(M), np.linalg.inv(M)
        if self.damping is None:
            A = inverse @ K
            return A, inverse @ (dK - dM @ A)
        C, dC = summed(self.damping)
        low = -inverse @ np.hstack([K, C])
        A = np.vstack([np.eye(n, 2 * n, n), low])
        return A, np.vstack([np.zeros((n, 2 * n)), -inverse @ (np.hstack([dK, dC]) + dM @ low)])

    def at(self, value):
        """The spectrum at a value."""
        A, dA = self.matrices(value)
        z, left, right = eig(A, left=True, right=True)
        overlap = np.einsum("ij,ij->j", left.conj(), right)
        overlap = np.where(overlap == 0, 1e-300, overlap)
        slopes = np.einsum("ij,ij->j", left.conj(), dA @ right) / overlap
        errors = 8 * EPS * np.linalg.norm(A) * np.minimum(1 / np.abs(overlap), 1e16)
        if self.damping is None:
            slopes = np.where(z.imag == 0, slopes.real, slopes)
        kept = np.abs(self.window.roots(z).imag) <= MARGIN * self.end
        kept &= (z.imag >= 0) | (self.damping is None)
        numbers = np.arange(int(kept.sum()))
        bounds = errors[kept], errors[kept], numbers
        return Sample(value, z[kept], slopes[kept], *bounds, right[:, kept])


def constant(matrix):
    return [(lambda t: 1.0, lambda t: 0.0, matrix)]


def linear(first, second):
    """A + t B."""
    return [*constant(first), (lambda t: t, lambda t: 1.0, second)]


def random_line(seed, *, damping=None, level=0.0, nonlinear=False):
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


def coupled_pairs(pairs, *, end, damping=None, singles=()):
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
    return DenseLine(stiffness, constant(np.eye(n)), damped, end)


def scan(line, values):
    """Number of growing eigenvalues of both half planes at values, by dense eigenvalues."""
    numbers, window = [], line.window
    for value in values:
        z = eigvals(line.matrices(float(value))[0])
        least = 0.0 if window.damped else 1e-7 * np.abs(window.roots(z)) + 1e-9
        numbers.append(int(((window.growth(z) > least) & ~window.far(z)).sum()))
    return np.array(numbers)


def disagreements(found, values, numbers, slack=2e-6):
    """Values at which thresholds foresee another number of growing eigenvalues than a scan has."""
    places = np.array([each.value for each in found.thresholds])
    changes = np.array([each.change for each in found.thresholds])
    foreseen = [changes[(places > values[0]) & (places <= value)].sum() for value in values]
    wrong = np.array(foreseen) + numbers[0] != numbers
    for value in places:
        wrong &= np.abs(values - value) > slack
    for each in found.unresolved:
        wrong &= (values < each.low - slack) | (values > each.high + slack)
    return np.flatnonzero(wrong)


def check(line, values, dense=None):
    """Thresholds, none of which is missing, and none of which is one too many."""
    dense = np.linspace(0, 1, 251) if dense is None else dense
    found = thresholds_along(line, list(values))
    numbers = scan(line, dense)
    wrong = disagreements(found, dense, numbers)
    assert not len(wrong), f"at {dense[wrong[:4]]}: {found.thresholds}"
    return found


SYSTEMS = [
    {},
    {"damping": 1.0},
    {"damping": 1e-4},
    {"level": 0.05},
    {"damping": 1.0, "level": 0.05},
    {"nonlinear": True},  # M(t) and sines
    {"damping": 1.0, "nonlinear": True},
]
HUNDREDS = [pytest.param(range(k, k + 100), marks=pytest.mark.slow) for k in range(1, 1001, 100)]


@pytest.mark.parametrize("seeds", [range(4, 11), *HUNDREDS])
def test_random_systems_have_the_thresholds_of_a_scan(seeds):
    """No threshold is missing in silence, none is one too many, few intervals are unresolved."""
    unresolved = intervals = 0
    for seed in seeds:
        values = np.linspace(0, 1, (3, 5, 11, 41)[seed % 4])
        line = random_line(seed, **SYSTEMS[seed % len(SYSTEMS)])
        dense = np.linspace(0, 1, 1001 if len(seeds) == 100 else 251)
        unresolved += len(check(line, values, dense).unresolved)
        intervals += len(values) - 1
    assert unresolved <= 0.01 * intervals


DAMPINGS = [None, 1e-6, pytest.param(1e-3, marks=pytest.mark.slow)]


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize(
    "where",
    [
        [(1.0, 0.5, 0.31, 2.0), (4.0, 0.5, 0.3101, 2.0)],
        [(1.0, 0.5, 0.31, 2.0), (4.0, 0.5, 0.31, 2.0)],
        [(1.0, 0.5, 0.52, 0.520001)],
        [(1.0, 0.5, 0.5, 2.0)],
        [(1.0, 0.5, -1.0, 0.25), (1.3, 0.5, 0.75, 2.0)],
    ],
    ids=["1e-4 apart", "two alike", "a dip of 1e-6", "on a sample", "ends and begins"],
)
def test_constructed_pairs_begin_where_they_were_made_to(where, damping):
    line = coupled_pairs(where, end=3.0, damping=damping)
    found = check(line, np.linspace(0, 1, 11))
    assert not found.unresolved
    if damping is None:
        for _, _, t0, t1 in where:
            for t in (t0, t1):
                near = [each for each in found.thresholds if abs(each.value - t) <= 1e-7]
                assert near or not 0 < t < 1


@pytest.mark.parametrize("count", [2, 3, 11])
def test_growth_of_nothing_but_rounding_before_a_coalescence_is_not_lost(count):
    """Damped by nothing, no sign of growth tells where flutter begins."""
    line = coupled_pairs([(1.0, 0.5, 0.31, 2.0)], end=3.0, damping=0.0)
    found = thresholds_along(line, list(np.linspace(0, 1, count)))
    places = [(each.value, each.value) for each in found.thresholds]
    places += [(each.low, each.high) for each in found.unresolved]
    assert any(low - 1e-6 <= 0.31 <= high + 1e-6 for low, high in places)


@pytest.mark.parametrize("count", [2, 5])
def test_thresholds_of_decades_have_the_same_digits(count):
    line = coupled_pairs([(9.0, 0.02, 0.03, 40.0)], end=4.0)
    found = thresholds_along(line, np.geomspace(1e-2, 1e2, count).tolist(), logarithmic=True)
    assert not found.unresolved
    assert found.spectra < 60
    assert [each.value for each in found.thresholds] == pytest.approx([0.03, 40.0], rel=1e-9)


@pytest.mark.parametrize("damping", DAMPINGS)
def test_modes_that_diverge_are_told_apart_from_flutter(damping):
    line = coupled_pairs([(1.0, 0.3, 5.0, 6.0)], end=3.0, singles=[(0.4, -1.0)], damping=damping)
    found = check(line, np.linspace(0, 1, 4))
    (only,) = found.thresholds
    assert only.kind == "divergence"
    assert only.value == pytest.approx(0.4, abs=1e-9)
    assert abs(only.eigenvalue) < 1e-4


def test_modes_that_enter_the_window_growing_are_told():
    line = coupled_pairs([(8.0, 1.0, -1.0, 2.0)], end=3.0, singles=[])
    line.stiffness = [*line.stiffness, (lambda t: 4 * t, lambda t: 4.0, np.eye(2))]
    found = check(line, np.linspace(0, 1, 6))
    (only,) = found.thresholds
    assert (only.kind, only.change) == ("window", -2)
    assert only.eigenvalue.imag == pytest.approx(3.0, rel=1e-9)


def test_a_brief_flutter_between_far_samples_is_found():
    """A hardly damped pair grows from 0.012 to 0.018 only: beside that its growth is flat."""
    line = random_line(695, damping=1e-6, nonlinear=True)
    (*linear_terms, (wave, slope, matrix)), (constant_mass, _) = line.stiffness, line.mass
    line.stiffness, line.mass = [*linear_terms, (wave, slope, 1.4 * matrix)], [constant_mass]
    ((*_, C),) = line.damping
    line.damping = [*line.damping, (lambda t: t**2 - t, lambda t: 2 * t - 1, 2 * C)]
    found = check(line, [0.0, 0.5, 1.0])
    assert not found.unresolved
    brief = [each for each in found.thresholds if 0.01 < each.value < 0.02]
    assert [each.change > 0 for each in brief] == [True, False]


@pytest.mark.parametrize("bound", [1e-4, 1e-2, 0.1, 0.5])
def test_bounds_that_are_too_large_leave_intervals_unresolved(bound):
    """As those of a poor basis do: a threshold is told or lies in an unresolved interval."""
    line = coupled_pairs([(4.0, 0.8, 0.2, 0.8)], end=4.0)
    exact = line.at

    def poor(value):
        sample = exact(value)
        errors = np.full(len(sample.z), bound)
        return replace(sample, errors=errors, means=errors)

    line.at = poor
    found = thresholds_along(line, np.linspace(0, 1, 5).tolist())
    assert found.spectra < 200  # of 300 that it may take: further ones have the same bounds
    for value in (0.2, 0.8):
        known = any(abs(each.value - value) <= each.error + 1e-12 for each in found.thresholds)
        left = any(each.low <= value <= each.high for each in found.unresolved)
        assert known or left
