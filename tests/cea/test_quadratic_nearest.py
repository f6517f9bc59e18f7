"""The few eigenvalues of damped and rotating pencils nearest to a place, beside dense ones."""

import numpy as np
import pytest
from covering import covering
from dense_reference import dense_quadratic
from petsc_matrices import to_petsc
from random_pencils import pencil_of

from cea.eigen.driver import EigenSolver
from cea.eigen.pencil import Pencil
from cea.errors import InputError

N = 120
WANTED = 6


def matrices(seed=1, *, friction=0.3, turning=0.2, damping=0.02):
    """M, D, K of size N: stiff springs in a row, damped, rotating, with friction."""
    random = np.random.default_rng(seed)
    mass = np.diag(random.uniform(1.0, 2.0, N))
    stiffness = np.diag(np.linspace(1.0, 60.0, N) ** 2)
    coupling = 0.5 * np.diag(random.standard_normal(N - 1), 1)
    stiffness = stiffness + coupling + coupling.T + friction * np.diag(np.ones(N - 2), 2)
    skew = turning * np.diag(random.standard_normal(N - 1), 1)
    return mass, np.diag(damping * np.sqrt(np.diag(stiffness))) + skew - skew.T, stiffness


def in_upper_half(M, D, K, scale):
    values, _ = dense_quadratic(M, D, K, scale)
    return values[values.imag >= -1e-9 * scale]


def assert_nearest(modes, dense, place, wanted=WANTED):
    """As many as were wanted or a few more, each once, and none nearer was passed over."""
    found = modes.eigenvalues
    assert len(found) >= wanted
    expected = dense[np.argsort(np.abs(dense - place))[: len(found)]]
    distance = np.abs(found[:, None] - expected)
    error = 1e-9 * abs(place)
    assert distance.min(axis=0).max() < error
    assert distance.min(axis=1).max() < error


@pytest.mark.parametrize(
    ("low_rank", "place"),
    covering([False, True], [20j, 1 + 20j, -0.5 + 35j, 3 + 3j, 5.0, 1e-3 + 1j], strength=1),
)
def test_those_nearest_to_complex_and_real_places_are_found(place, low_rank):
    M, D, K = matrices()
    piece = None
    if low_rank:
        random = np.random.default_rng(2)
        piece = 0.1 * random.standard_normal((N, 3)), np.array([1.0, 2.0, 0.5])
    whole = D if piece is None else D + (piece[0] * piece[1]) @ piece[0].T
    dense = in_upper_half(M, whole, K, abs(place))
    with EigenSolver(pencil_of(M, D, K, piece)) as driver:
        modes = driver.nearest(-(place**2), WANTED)
        assert (driver.solves, driver.factorisations) == (1, 1)
    assert_nearest(modes, dense, place)
    assert modes.residuals.max() < 1e-11
    assert not modes.window.complete
    assert "nearest to" in modes.window.evidence


def test_overdamped_ones_next_to_a_real_place_are_real():
    M, _, K = matrices(friction=0.0, turning=0.0)
    D = 3 * np.sqrt(np.diag(np.diag(M) * np.diag(K)))  # each decays without swinging
    dense, _ = dense_quadratic(M, D, K, 1.0)
    assert np.abs(dense.imag).max() < 1e-6
    with EigenSolver(pencil_of(M, D, K)) as driver:
        modes = driver.nearest(-1.0, WANTED)
    assert_nearest(modes, dense, 1.0)
    assert (modes.eigenvalues.imag == 0).all()


def test_more_than_there_are_gives_all():
    M, D, K = np.eye(3), 0.1 * np.eye(3), np.diag([1.0, 4.0, 9.0])
    dense = in_upper_half(M, D, K, 1.0)
    with EigenSolver(pencil_of(M, D, K)) as driver:
        found = driver.nearest(2.0, 50).eigenvalues
    assert found == pytest.approx(dense[np.argsort(dense.imag)], rel=1e-12)


def test_what_cannot_be_a_place_is_refused():
    M, D, K = matrices()
    with EigenSolver(pencil_of(M, D, K)) as driver:
        for kappa in (0.0, np.nan, complex(1, np.inf)):
            with pytest.raises(InputError, match="not zero"):
                driver.nearest(kappa, 1)
        with pytest.raises(InputError, match="1 or more"):
            driver.nearest(1.0, 0)
    linear = EigenSolver(Pencil.of(to_petsc(K), to_petsc(M)))
    with linear, pytest.raises(InputError, match="real number"):
        linear.nearest(1 + 1j, 1)
