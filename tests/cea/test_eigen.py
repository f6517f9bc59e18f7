"""The eigenvalue driver against dense solvers."""

import numpy as np
import pytest
import scipy.linalg
from petsc_matrices import sliding_pencil, to_petsc
from scipy.sparse import csr_array, diags_array, eye_array, random_array

from cea.eigen.driver import solve_modes
from cea.eigen.krylov_schur import KrylovOptions
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.errors import ConvergenceError

SIZE = 120


def pencil(stiffness, mass, friction=None):
    """Pencil of matrices, with friction or without."""
    if friction is None:
        return Pencil.of(to_petsc(stiffness), to_petsc(mass))
    return sliding_pencil(stiffness, mass, friction)


@pytest.fixture
def chain():
    """Chain of unequal springs and masses, and an unsymmetric coupling that makes it flutter."""
    rng = np.random.default_rng(7)
    springs = rng.uniform(0.5, 2.0, SIZE + 1) * SIZE**2
    stiffness = diags_array(
        [springs[:-1] + springs[1:], -springs[1:-1], -springs[1:-1]], offsets=[0, 1, -1]
    )
    mass = diags_array(rng.uniform(0.5, 2.0, SIZE)) + 0.1 * eye_array(SIZE)
    friction = random_array((SIZE, SIZE), density=0.05, rng=rng) * SIZE
    return csr_array(stiffness), csr_array(mass), csr_array(friction)


def dense_eigenvalues(operator, mass, max_frequency):
    kappa = scipy.linalg.eigvals(operator.toarray(), mass.toarray())
    values = np.sqrt(-kappa.astype(complex))
    values = np.where(values.imag < 0, -values, values)
    return values[values.imag <= 2 * np.pi * max_frequency]


def assert_same_set(found, expected, tolerance):
    assert len(found) == len(expected)
    distance = np.abs(found[:, None] - expected[None, :])
    assert (distance.min(axis=0) <= tolerance * np.abs(expected)).all()
    assert (distance.min(axis=1) <= tolerance * np.abs(found)).all()


@pytest.mark.parametrize("max_frequency", [3.0, 12.0])
@pytest.mark.parametrize("has_friction", [False, True])
def test_window_is_complete_with_true_vectors(chain, has_friction, max_frequency):
    stiffness, mass, friction = chain
    friction = has_friction * friction
    parts = (stiffness, mass, friction) if has_friction else (stiffness, mass)
    modes = solve_modes(pencil(*parts), max_frequency=max_frequency)
    expected = dense_eigenvalues(stiffness - friction, mass, max_frequency)
    assert (expected.real > 1e-6).any() == has_friction, "it must flutter to test anything"
    assert_same_set(modes.eigenvalues, expected, 1e-8 if has_friction else 1e-10)
    assert modes.unstable(1e-3).sum() == np.sum(expected.real > 1e-3)
    assert modes.residuals.max() < 1e-8
    assert (np.diff(modes.frequencies) >= 0).all()
    for i, value in enumerate(modes.eigenvalues):
        x = modes.vectors[:, i]
        defect = value**2 * (mass @ x) + (stiffness - friction) @ x
        assert np.linalg.norm(defect) <= 1e-8 * np.linalg.norm(value**2 * (mass @ x))
        assert np.vdot(x, mass @ x) == pytest.approx(1.0)
    if not has_friction:
        assert modes.window.found_below == modes.window.symmetric_count
        assert (modes.conditions == 1).all()


@pytest.mark.parametrize("coupling", [1e3, 1e4])
def test_errors_count_left_vectors_that_reach_out_of_the_window(coupling):
    """A triangular system, turned: modes beyond the window make its left vectors long."""
    inside, outside = np.linspace(1, 10, 10), np.linspace(20, 40, 50)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        turn = np.linalg.qr(rng.standard_normal((60, 60)))[0]
        coupled = np.zeros((60, 60))
        coupled[:10, 10:] = coupling * rng.standard_normal((10, 50)) / np.sqrt(60)
        stiffness = turn @ np.diag(np.r_[inside, outside]) @ turn.T
        matrices = (0.5 * (stiffness + stiffness.T), np.eye(60), -turn @ coupled @ turn.T)
        modes = solve_modes(pencil(*map(csr_array, matrices)), max_frequency=0.55)
        assert len(modes) == 10
        true = 1j * np.sqrt(inside)
        distance = np.abs(modes.eigenvalues[:, None] - true).min(axis=1)
        assert (distance <= modes.growth_uncertainties).all()


def test_eigenvalues_that_friction_moves_out_are_told_from_missed_ones():
    """The symmetric part has one more than there is; a search beside those found finds no other."""
    stiffness = np.diag(np.r_[np.arange(1.0, 30.0), 40.0, np.arange(60.0, 400.0)])
    coupling = np.zeros((370, 370))
    coupling[29, 30], coupling[30, 29] = 30.0, -30.0
    modes = solve_modes(pencil(stiffness, eye_array(370), coupling), 6.6 / (2 * np.pi))
    assert modes.window.complete
    assert modes.window.found_below == 29
    assert modes.verdict() == "stable"
    assert (-(modes.eigenvalues**2)).real == pytest.approx(np.arange(1.0, 30.0))


def test_failed_convergence_carries_the_best_answer():
    stiffness, friction = np.diag(np.arange(1.0, 501.0)), np.diag(np.full(499, 0.1), 1)
    with pytest.raises(ConvergenceError) as caught:
        solve_modes(
            pencil(stiffness, np.eye(500), friction),
            max_frequency=0.5,
            options=KrylovOptions(tolerance=1e-300, max_restarts=1, dense_limit=0),
        )
    assert isinstance(caught.value.best, Modes)
