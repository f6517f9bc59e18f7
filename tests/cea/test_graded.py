"""Matrices whose rows and columns are scaled far apart, and others whose norms say little."""

import time

import numpy as np
import pytest
from blocks import assemble, two_blocks
from graded_numbers import graded_numbers
from mpi import on_ranks
from petsc_matrices import to_petsc
from random_graded import POWERS, random_graded, random_graded_damped, sheared
from random_runs import graded_damped_outcome, graded_outcome, statistics, tell
from scipy.sparse import csr_array

from cea.eigen.balance import balance_of, osborne
from cea.eigen.krylov_schur import solve_modes
from cea.eigen.pencil import Pencil
from cea.errors import ConvergenceError


def _judged(seeds, outcome_of):
    begin = time.process_time()
    outcomes = [outcome_of(seed) for seed in seeds]
    seconds = time.process_time() - begin
    told = f"{len(seeds)} graded pencils, {seeds}, in {seconds:.1f} s\n{statistics(outcomes)}"
    tell(told)
    wrong = [str(outcome) for outcome in outcomes if outcome.faults]
    assert not wrong, "\n".join([told, *wrong])
    assert sum(outcome.modes for outcome in outcomes) > len(seeds)
    known = [o for o in outcomes if o.refused is None and o.complete and not o.undecided]
    return len(known) / len(outcomes)


def test_graded_pencils():
    assert _judged(range(40), graded_outcome) > 0.95


def test_graded_damped_pencils():
    assert _judged(range(12), graded_damped_outcome) > 0.95


@pytest.mark.slow
def test_a_thousand_graded_pencils():
    assert _judged(range(1000), graded_outcome) > 0.95


@pytest.mark.slow
def test_three_hundred_graded_damped_pencils():
    assert _judged(range(300), graded_damped_outcome) > 0.95


def _given(matrix):
    equal = np.where(matrix == matrix.T, matrix, 0.0)
    mass = to_petsc(np.eye(len(matrix)))
    return Pencil.of(to_petsc(equal), mass, to_petsc(equal - matrix))


def test_what_no_scaling_mends_is_owned_to():
    """Eigenvalues are whole numbers, and known to what the result says, or it is refused."""
    known = 0
    for seed in range(60):
        matrix, kappa = sheared(seed)
        try:
            modes = solve_modes(_given(matrix), float(np.sqrt(kappa.max() + 0.5)) / (2 * np.pi))
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
        K, M = problem.scaled(problem.plain.stiffness), problem.scaled(problem.plain.mass)
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
    problem = random_graded_damped(0, 20)
    modes = solve_modes(problem.pencil(), problem.max_frequency, left=True)
    M, D, K = (
        problem.scaled(matrix)
        for matrix in (problem.plain.mass, problem.plain.damping, problem.plain.stiffness)
    )
    value, x, y = modes.eigenvalues, modes.vectors, modes.left.vectors
    defect = K.T @ y + D.T @ y * value.conj() + M @ y * value.conj() ** 2
    assert len(modes)
    assert (np.abs(defect) <= 1e-9 * (np.abs(K.T) @ np.abs(y))).all()
    turned = np.einsum("ij,ij->j", y.conj(), 2 * value * (M @ x) + D @ x)
    assert turned == pytest.approx(2 * value)


def test_balance_takes_a_grading_out_to_the_bit():
    rng = np.random.default_rng(4)
    plain = 1 + rng.random((30, 30))
    scale = 2.0 ** rng.integers(-30, 31, 30)
    found = osborne(csr_array(scale[:, None] * plain / scale), csr_array(np.eye(30)))
    assert np.ptp(np.log2(found / scale)) <= 1
    assert (np.log2(found) == np.round(np.log2(found))).all()
    coupled = np.kron(np.eye(15), np.ones((2, 2)))
    pairs = osborne(csr_array(scale[:, None] * plain / scale), csr_array(coupled))
    assert (pairs[::2] == pairs[1::2]).all()


@pytest.mark.parametrize("stiffness", [1e2, 1e8, 1e14])
def test_friction_of_stiff_contacts_is_no_grading(backend, stiffness):
    problem = two_blocks(backend, {"method": "gpts", "points": 3}, P=stiffness)
    problem["contacts"]["interface"]["form"] = "penalty"
    matrices = assemble(problem).pencil().at()
    assert matrices.unsymmetric is not None
    assert balance_of(matrices, 1.4) is None


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("seed", "damped"), [(5, False), (15, True)])
def test_ranks_agree(ranks, seed, damped):
    alone = graded_numbers(seed, damped)
    several = on_ranks(ranks, "graded_numbers.graded_numbers", seed, damped)
    assert len(alone["im"]) > 1
    assert several["verdicts"] == alone["verdicts"]
    for part in ("re", "im"):
        assert several[part] == pytest.approx(alone[part], rel=1e-8, abs=1e-10)
