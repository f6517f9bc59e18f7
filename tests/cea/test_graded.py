"""Matrices whose rows and columns are scaled far apart, and others whose norms say little."""

import numpy as np
import pytest
from eigen_numbers import graded
from mpi import on_ranks
from random_pencils import POWERS, pencil_of, random_graded, random_graded_damped, sheared

from cea.eigen.driver import solve_modes
from cea.errors import ConvergenceError


def test_what_no_scaling_mends_is_owned_to():
    """Eigenvalues are whole numbers, and known to what the result says, or it is refused."""
    known = 0
    for seed in range(60):
        matrix, kappa = sheared(seed)
        try:
            pencil = pencil_of(np.eye(len(matrix)), None, matrix, graded=True)
            modes = solve_modes(pencil, float(np.sqrt(kappa.max() + 0.5)) / (2 * np.pi))
        except ConvergenceError:
            continue
        values = modes.eigenvalues
        error = np.abs(values[:, None] - 1j * np.concatenate([-np.sqrt(kappa), np.sqrt(kappa)]))
        assert (error.min(axis=1) <= modes.growth_uncertainties + 1e-14).all()
        assert "unstable" not in modes.verdicts()
        known += 1
    assert known > 30


@pytest.mark.parametrize("power", POWERS)
def test_eigenvectors_are_those_of_the_unknowns_as_given(power):
    for problem in (random_graded(0, power), random_graded(1, power)):
        modes = solve_modes(problem.pencil(), problem.max_frequency, left=True)
        K, M = problem.scaled(problem.stiffness), problem.scaled(problem.mass)
        x, y = modes.vectors, modes.left.vectors
        assert np.einsum("ij,ij->j", x.conj(), M @ x).real == pytest.approx(np.ones(len(modes)))
        right = K @ x + M @ x * modes.eigenvalues**2
        left = K.T @ y + M @ y * modes.eigenvalues.conj() ** 2
        assert (np.abs(right) <= 1e-9 * (np.abs(K) @ np.abs(x))).all()
        assert (np.abs(left) <= 1e-9 * (np.abs(K.T) @ np.abs(y))).all()
        overlap = y.conj().T @ (M @ x)
        size = np.abs(y).T @ (np.abs(M) @ np.abs(x))
        assert (np.abs(overlap - np.eye(len(modes))) <= 1e-9 * size).all()


def test_left_vectors_of_damped_ones():
    problem = random_graded_damped(1, 20)
    modes = solve_modes(problem.pencil(), problem.max_frequency, left=True)
    M, D, K = (
        problem.scaled(matrix) for matrix in (problem.mass, problem.damping, problem.stiffness)
    )
    value, x, y = modes.eigenvalues, modes.vectors, modes.left.vectors
    defect = K.T @ y + D.T @ y * value.conj() + M @ y * value.conj() ** 2
    assert len(modes)
    assert (np.abs(defect) <= 1e-9 * (np.abs(K.T) @ np.abs(y))).all()
    turned = np.einsum("ij,ij->j", y.conj(), 2 * value * (M @ x) + D @ x)
    assert turned == pytest.approx(2 * value)


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("seed", "damped"), [(5, False), (1, True)])
def test_ranks_agree(ranks, seed, damped):
    alone = graded(seed, damped)
    several = on_ranks(ranks, "eigen_numbers.graded", seed, damped)
    assert len(alone["im"]) > 1
    assert several["verdicts"] == alone["verdicts"]
    for part in ("re", "im"):
        assert several[part] == pytest.approx(alone[part], rel=1e-8, abs=1e-10)
