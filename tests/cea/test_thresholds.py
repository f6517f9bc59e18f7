"""Thresholds of flutter found on matrices, against closed forms and the exact blocks."""

import numpy as np
import pytest
from petsc_matrices import FRICTION, sliding_pencil
from reference_data import COALESCENCES
from sweep_cases import MU, driver_of_blocks

from cea.eigen.driver import EigenSolver
from cea.errors import InputError
from cea.reduced.full_solves import first_threshold

TOP = 2.5 / (2 * np.pi)
SLOW = pytest.mark.slow


def driver_of(stiffness, friction, mass=None):
    mass = np.eye(len(stiffness)) if mass is None else mass
    return EigenSolver(sliding_pencil(stiffness, mass, friction))


def lumped(coupling, others=12):
    """Two masses of kappa 1 and 2 that friction couples with the sign of flutter, and others.

    kappa^2 - 3 kappa + 2 + (s coupling)^2 = 0, with a double root at s = 1 / (2 coupling).
    """
    n = 2 + others
    stiffness, friction = np.diag(np.r_[1.0, 2.0, np.linspace(3, 9, others)]), np.zeros((n, n))
    friction[0, 1], friction[1, 0] = -coupling, coupling
    mass = np.diag(np.linspace(1, 2, n))
    root = np.sqrt(mass)
    return driver_of(root @ stiffness @ root, root @ friction @ root, mass)


@pytest.mark.parametrize("coupling", [0.3, 2.0])
def test_two_coupled_masses_to_round_off(coupling):
    driver = lumped(coupling)
    threshold = first_threshold(driver, FRICTION, 0.0, 0.9 / coupling, max_frequency=TOP)
    assert threshold.value == pytest.approx(0.5 / coupling, rel=1e-12)
    # The mean of the pair keeps its digits where each member loses half of them.
    assert threshold.eigenvalue == pytest.approx(1j * np.sqrt(1.5), rel=1e-12)
    assert threshold.parameter == FRICTION


@pytest.mark.parametrize(("real", "flutter"), [(0.0, 0.2), (0.9, 0.8), (0.3, 0.3)])
def test_values_that_do_not_enclose_a_threshold_are_refused(real, flutter):
    with pytest.raises(InputError) as refused:
        first_threshold(lumped(1.0), FRICTION, real, flutter, max_frequency=TOP)
    assert refused.value.field == "flutter"


def test_the_first_threshold_is_found_though_another_pair_grows_faster_at_the_end():
    """Pairs that begin to flutter at 0.25 and, faster in the end, at 0.5."""
    stiffness = np.diag([1.0, 1.1, 2.0, 3.0])
    friction = np.zeros((4, 4))
    friction[0, 1], friction[1, 0] = -0.2, 0.2
    friction[2, 3], friction[3, 2] = -1.0, 1.0
    driver = driver_of(stiffness, friction)
    for frequency, value in ((None, 0.25), (np.sqrt(1.05) / (2 * np.pi), 0.25), (0.25, 0.5)):
        found = first_threshold(driver, FRICTION, 0.0, 2.0, max_frequency=TOP, frequency=frequency)
        assert found.value == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("soft", [0.05, -0.05])
def test_divergence_is_no_flutter(soft):
    """A mode that grows without oscillation is passed over; the pair beside it is followed."""
    stiffness, friction = np.diag(np.r_[1.0, 2.0, soft, 3.0, 4, 5, 6, 7]), np.zeros((8, 8))
    friction[0, 1], friction[1, 0] = -0.6, 0.6
    friction[2, 3], friction[3, 2] = 1.0, 0.16
    driver = driver_of(stiffness, friction)
    modes = driver.solve(TOP)
    assert modes.unstable(0.0)[modes.eigenvalues.imag == 0].any()
    threshold = first_threshold(driver, FRICTION, 0.0, 1.0, max_frequency=TOP, frequency=0.0)
    assert threshold.value == pytest.approx(0.5 / 0.6, rel=1e-12)


@pytest.mark.parametrize(
    ("backend", "i"),
    [("fe", 0), ("iga", 3), *(pytest.param(*row, marks=SLOW) for row in (("fe", 3), ("iga", 0)))],
)
def test_first_thresholds_of_the_blocks_on_coarse_meshes(backend, i):
    p, mu_c, omega = COALESCENCES[i]
    near, frequency = (0.95 * mu_c, 1.05 * mu_c), omega / (2 * np.pi)
    mesh = {"degree": 6}
    if backend == "fe":
        mesh = {"degree": 4, "elements": {"upper": [4, 2], "lower": [3, 2]} if i == 0 else None}
    driver = driver_of_blocks(backend, p, **mesh)
    threshold = first_threshold(driver, MU, *near, max_frequency=0.53, frequency=frequency)
    assert threshold.value == pytest.approx(mu_c, abs=1e-4)
    assert threshold.eigenvalue == pytest.approx(1j * omega, rel=1e-5)


@pytest.mark.convergence
@pytest.mark.parametrize("backend", [pytest.param("fe", marks=SLOW), "iga"])
def test_at_the_threshold_the_mean_keeps_twice_the_order_of_its_members(backend):
    """Quadratic elements: the mean converges like h^4, the members part from it like h^2."""
    p, mu_c, omega = COALESCENCES[0]
    refinements, errors = (3, 6), []
    for n in refinements:
        values = driver_of_blocks(backend, p, finer=n).solve(0.53, {MU: mu_c}).eigenvalues
        pair = values[np.argsort(np.abs(values - 1j * omega))[:2]]
        mean = 1j * np.sqrt(-(pair**2).mean())
        errors.append([abs(pair[0] - pair[1]) / 2, abs(mean - 1j * omega)])
    members, means = -np.polyfit(np.log(refinements), np.log(errors), 1)[0]
    assert members == pytest.approx(2, abs=0.2)
    assert means == pytest.approx(4, abs=0.2)
