"""Derivatives of eigenvalues against finite differences, and the left vectors they rest on."""

import numpy as np
import pytest
import scipy.linalg
from blocks import assemble, coarse, two_blocks
from covering import covering
from petsc_matrices import FRICTION, sliding_pencil, to_numpy
from reference_data import COALESCENCES
from sweep_cases import MU, P, driver_of_blocks

from cea.eigen.driver import EigenSolver, solve_modes
from cea.errors import InputError
from cea.reduced.full_solves import first_threshold


def followed(modes, eigenvalues):
    """The modes that continue given eigenvalues, which a small step leaves apart."""
    distance = np.abs(modes.eigenvalues - np.asarray(eigenvalues)[:, None])
    chosen = distance.argmin(axis=1)
    assert len(set(chosen)) == len(chosen)
    return modes.eigenvalues[chosen]


def finite_differences(driver, modes, name, chosen, relative_step, max_frequency):
    """Central differences of order four."""
    value, weights = modes.values[name], {1: 2 / 3, 2: -1 / 12}
    step, slope = relative_step * value, 0.0
    for k, weight in weights.items():
        ends = [
            followed(
                driver.solve(max_frequency, {name: value + sign * k * step}),
                modes.eigenvalues[chosen],
            )
            for sign in (1, -1)
        ]
        slope = slope + weight * (ends[0] - ends[1])
    return slope / step


NAMES = [MU, P, "bodies.upper.material.E", "bodies.lower.material.rho"]


@pytest.mark.parametrize(
    ("backend", "form"), covering(["fe", "iga"], ["penalty", "saddle"], strength=1)
)
def test_derivatives_in_every_kind_of_parameter(backend, form):
    """To 1e-6 of the larger of themselves and a thousandth of abs(lambda) / t."""
    data = coarse(two_blocks(backend, {"method": "gpts", "points": 4}, held=True))
    data["contacts"]["interface"]["form"] = form
    data["bodies"]["upper"]["springs"] = [{"surface": "x_min", "stiffness": [0.3, 0.2, 0.1]}]
    top = 0.62
    with EigenSolver(assemble(data).pencil()) as driver:
        modes = driver.solve(top, left=True)
        chosen = np.flatnonzero(modes.frequencies < top / 1.02)
        assert len(chosen) > 3
        for name in NAMES:
            expected = finite_differences(driver, modes, name, chosen, 2e-4, top)
            found = modes.sensitivity(name)[chosen]
            natural = np.abs(modes.eigenvalues[chosen]) / modes.values[name]
            scale = np.maximum(np.abs(expected), 1e-3 * natural)
            assert (np.abs(found - expected) <= 1e-6 * scale).all(), name


@pytest.mark.parametrize(("backend", "distance"), covering(["fe", "iga"], [1e-2, 1e-4], strength=1))
def test_derivatives_of_the_blocks_near_coalescence(backend, distance):
    """Members part like square roots of the distance; steps must stay well below it."""
    p, mu_c, omega = COALESCENCES[0]
    top = 0.53
    with driver_of_blocks(backend, p) as driver:
        threshold = first_threshold(
            driver, MU, 0.9 * mu_c, 1.1 * mu_c, max_frequency=top, frequency=omega / (2 * np.pi)
        )
        for side in (-1, 1):
            at = {MU: threshold.value * (1 + side * distance)}
            modes = driver.solve(top, at, left=True)
            pair = np.argsort(np.abs(modes.eigenvalues - threshold.eigenvalue))[:2]
            found = modes.sensitivity(MU)[pair]
            expected = finite_differences(driver, modes, MU, pair, distance / 50, top)
            assert np.abs(found - expected).max() <= 1e-6 * np.abs(expected).max()
            # Of the mean of lambda^2 nothing grows.
            means = [(modes.eigenvalues[pair] * slope).sum() for slope in (found, expected)]
            assert abs(means[0] - means[1]) <= 1e-6 * np.abs(expected).max()


@pytest.fixture
def random_pencil():
    rng = np.random.default_rng(11)
    n = 40
    spread = rng.normal(size=(n, n)) / np.sqrt(n)
    stiffness = np.diag(np.linspace(1.0, 30.0, n)) + 0.05 * (spread + spread.T)
    mass = np.eye(n) + 0.1 * (spread @ spread.T)
    return stiffness, mass, 2.0 * rng.normal(size=(n, n)) / np.sqrt(n)


def test_condition_numbers_are_those_of_a_dense_solver(random_pencil):
    stiffness, mass, friction = random_pencil
    modes = solve_modes(sliding_pencil(*random_pencil), 0.75, left=True)
    assert len(modes) > 15
    root = scipy.linalg.sqrtm(mass)
    standard = np.linalg.solve(root, np.linalg.solve(root, (stiffness - friction).T).T)
    dense, left, right = scipy.linalg.eig(standard, left=True, right=True)
    exact = 1 / np.abs(np.einsum("ij,ij->j", left.conj(), right))
    nearest = np.abs(dense + modes.eigenvalues[:, None] ** 2).argmin(axis=1)
    assert modes.conditions == pytest.approx(exact[nearest], rel=1e-7)


def test_a_multiple_eigenvalue_moves_as_it_splits():
    """Kappa = 4 twice; a friction that is symmetric on its space splits it along 0.3 and -0.2."""
    n = 30
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(n, n)))[0]
    stiffness = turn @ np.diag(np.r_[4.0, 4.0, np.linspace(9, 90, n - 2)]) @ turn.T
    change = np.zeros((n, n))
    change[0, 0], change[1, 1], change[5, 2], change[0, 7] = 0.3, -0.2, 4.0, 2.0
    friction = turn @ change @ turn.T
    pencil = sliding_pencil(0.5 * (stiffness + stiffness.T), np.eye(n), friction)
    modes = solve_modes(pencil, 1.0, {FRICTION: 1e-13}, left=True)
    assert modes.eigenvalues[:2].imag == pytest.approx([2.0, 2.0])
    found = np.sort(modes.sensitivity(FRICTION)[:2].imag)
    assert found == pytest.approx(np.array([-0.3, 0.2]) / 4, rel=1e-6)  # d kappa = 2 w dw


def test_what_was_not_asked_for_is_told(random_pencil):
    pencil = sliding_pencil(*random_pencil)
    modes = solve_modes(pencil, 0.5)
    with pytest.raises(InputError, match="left"):
        modes.sensitivity(FRICTION)
    with pytest.raises(InputError, match="one of friction"):
        modes.sensitivity("mu")


@pytest.mark.parametrize("top", [0.05, 1.0])
def test_left_vectors_of_rigid_motions_are_a_dual_basis(top):
    """Alone in the window, and beside modes: their kappa is rounding, which is no measure."""
    pencil = assemble(coarse(two_blocks("iga", {"method": "gpts", "points": 3}))).pencil()
    mass = to_numpy(pencil.at(pencil.values({})).mass)
    modes = solve_modes(pencil, top, left=True)
    assert np.count_nonzero(np.abs(modes.eigenvalues) < 1e-5) > 3
    overlap = modes.left.vectors.conj().T @ mass @ modes.vectors
    np.testing.assert_allclose(overlap, np.eye(len(modes)), atol=1e-7)
