"""Random and graded pencils beside dense eigenvalues."""

from functools import partial

import numpy as np
import pytest
from mpi import on_ranks
from random_pencils import (
    POWERS,
    pencil_of,
    random_graded,
    random_linear,
    random_low_rank,
    random_quadratic,
    sheared,
)
from random_runs import judged, pencil_outcome

from cea.eigen import driver
from cea.eigen.driver import solve_modes
from cea.eigen.krylov_schur import KrylovOptions
from cea.errors import ConvergenceError

PENCILS = {
    "linear": random_linear,
    "quadratic": random_quadratic,
    "low_rank": random_low_rank,
    "graded": random_graded,
    "graded_damped": partial(random_graded, damped=True),
}


def check(kind, seeds, refused=0.0):
    """Nothing is wrong, little but of graded pencils is refused or left open."""
    outcomes = judged(seeds, lambda seed: pencil_outcome(PENCILS[kind](seed)))
    assert sum(outcome.modes for outcome in outcomes) > len(seeds)
    graded = kind.startswith("graded")
    assert graded or sum(bool(o.refused) for o in outcomes) <= refused * len(outcomes)
    known = [o for o in outcomes if o.refused is None and o.complete and not o.undecided]
    assert not graded or len(known) > 0.95 * len(outcomes)


slow = partial(pytest.param, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("kind", "seeds"),
    [
        ("linear", range(4)),
        ("linear", (556,)),  # where the faster driver of singular values fails
        ("quadratic", range(12)),
        ("quadratic", (226, 496, 939)),  # lambda of free motions is zero to the last digit
        ("low_rank", range(8)),
        ("graded", range(20)),
        ("graded_damped", range(6)),
        slow("linear", range(1000)),
        slow("quadratic", range(1000)),
        slow("low_rank", range(500)),
        slow("graded", range(1000)),
        slow("graded_damped", range(300)),
    ],
)
def test_lapack_tells_all_of_small_ones(kind, seeds):
    check(kind, seeds)


@pytest.mark.parametrize(
    ("kind", "seeds"),
    [
        ("linear", (19, 59)),  # more copies than a block has columns
        ("quadratic", range(4)),
        slow("linear", (*range(300), 410, 516)),
        slow("quadratic", range(300)),
        slow("low_rank", range(150)),
    ],
)
def test_krylov_spaces_find_all_of_them_too(kind, seeds, monkeypatch):
    """Searched as large systems are."""
    monkeypatch.setattr(driver, "KrylovOptions", lambda: KrylovOptions(dense_limit=0))
    check(kind, seeds, refused=0.01)


def test_what_no_scaling_mends_is_owned_to():
    """Eigenvalues are whole numbers, and known to what the result says, or it is refused."""
    known = 0
    for seed in range(30):
        matrix, kappa = sheared(seed)
        try:
            pencil = pencil_of(np.eye(len(matrix)), None, matrix, graded=True)
            modes = solve_modes(pencil, float(np.sqrt(kappa.max() + 0.5)) / (2 * np.pi))
        except ConvergenceError:
            continue
        exact = 1j * np.concatenate([-np.sqrt(kappa), np.sqrt(kappa)])
        error = np.abs(modes.eigenvalues[:, None] - exact).min(axis=1)
        assert (error <= modes.growth_uncertainties + 1e-14).all()
        assert "unstable" not in modes.verdicts()
        known += 1
    assert known > 15


PROBLEMS = {f"{seed} {power}": random_graded(seed, power) for power in POWERS for seed in (0, 1)}
PROBLEMS |= {"damped": random_graded(1, 20, damped=True), "low rank": random_low_rank(3)}


@pytest.mark.parametrize("name", PROBLEMS)
def test_eigenvectors_are_those_of_the_unknowns_as_given(name):
    problem = PROBLEMS[name]
    modes = solve_modes(problem.pencil(), problem.max_frequency, left=True)
    assert len(modes)
    assert (np.diff(modes.frequencies) >= 0).all()
    K, M = problem.scaled(problem.stiffness), problem.scaled(problem.mass)
    D = 0 * M if problem.damping is None else problem.scaled(problem.damping)
    if problem.low_rank is not None:
        W, d = problem.low_rank
        D += (W * d) @ W.T
    value, x, y = modes.eigenvalues, modes.vectors, modes.left.vectors
    for A, B, z, vectors in ((K, D, value, x), (K.T, D.T, value.conj(), y)):
        rest = A @ vectors + B @ vectors * z + M @ vectors * z**2
        assert (np.abs(rest) <= 1e-9 * (np.abs(A) @ np.abs(vectors))).all()
    if D.any():
        turned = np.einsum("ij,ij->j", y.conj(), 2 * value * (M @ x) + D @ x)
        assert turned == pytest.approx(2 * value)
        return
    assert np.einsum("ij,ij->j", x.conj(), M @ x).real == pytest.approx(np.ones(len(modes)))
    overlap, size = y.conj().T @ (M @ x), np.abs(y).T @ (np.abs(M) @ np.abs(x))
    assert (np.abs(overlap - np.eye(len(modes))) <= 1e-9 * size).all()


def graded(seed, damped):
    """Eigenvalues and verdicts of a graded pencil, with left vectors."""
    problem = random_graded(seed, 20, damped=damped)
    modes = solve_modes(problem.pencil(), problem.max_frequency, left=True)
    return {
        "re": modes.growth_rates.tolist(),
        "im": modes.eigenvalues.imag.tolist(),
        "verdicts": modes.verdicts(),
    }


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("seed", "damped"), [(5, False), (1, True)])
def test_ranks_agree(ranks, seed, damped):
    alone = graded(seed, damped)
    several = on_ranks(ranks, graded, seed, damped)
    assert len(alone["im"]) > 1
    assert several["verdicts"] == alone["verdicts"]
    for part in ("re", "im"):
        assert several[part] == pytest.approx(alone[part], rel=1e-8, abs=1e-10)
