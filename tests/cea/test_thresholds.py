"""Thresholds of flutter found on matrices, against closed forms and the exact blocks."""

from pathlib import Path

import numpy as np
import pytest
from petsc4py import PETSc
from reference_data import plane_meshes, stored

from cea.eigen.thresholds import FrictionFamily, flutter_threshold
from cea.errors import ConvergenceError, InputError
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from scenes.build import build_bodies, build_interfaces, build_system
from scenes.read import load_scene

MESHES = {
    "fe": lambda n: {"upper": [8 * n, 2 * n], "lower": [5 * n, 3 * n]},
    "iga": lambda n: {"upper": [10 * n, 2 * n], "lower": [7 * n, 3 * n]},
}


def aij(array):
    n = len(array)
    matrix = PETSc.Mat().createAIJ((n, n), comm=PETSc.COMM_SELF)
    matrix.setUp()
    matrix.setValues(range(n), range(n), np.asarray(array, dtype=float))
    matrix.assemble()
    return matrix


def lumped(coupling, others=12):
    """Two masses of kappa 1 and 2 that friction couples with the sign of flutter, and others.

    kappa^2 - 3 kappa + 2 + (s coupling)^2 = 0, with a double root at s = 1 / (2 coupling).
    """
    n = 2 + others
    stiffness, friction = np.diag(np.r_[1.0, 2.0, np.linspace(3, 9, others)]), np.zeros((n, n))
    friction[0, 1], friction[1, 0] = -coupling, coupling
    mass = np.diag(np.linspace(1, 2, n))
    root = np.sqrt(mass)
    return FrictionFamily(
        aij(root @ stiffness @ root), aij(mass), aij(root @ friction @ root), 2.5 / (2 * np.pi)
    )


def blocks(backend, degree, n, p, max_frequency=0.62):
    """The blocks with friction sin(pi x / 2), to be multiplied by mu0."""
    overrides = [
        "contacts.interface.mu='sin(pi*x/2)'",
        f"contacts.interface.p={float(p)}",
        *plane_meshes(backend, degree, MESHES[backend](n)),
    ]
    scene, timer = load_scene(Path("blocks"), overrides, backend), StageTimer()
    bodies = build_bodies(scene, timer)
    interfaces = build_interfaces(scene, bodies, timer)
    return FrictionFamily.of(build_system(scene, bodies, interfaces, timer), max_frequency)


def exact_points():
    """p, mu_c and omega of the stored thresholds."""
    return [
        (entry["p"], float(entry["mu_c"]), float(entry["omega"]))
        for entry in stored("blocks_sine_mu_thresholds")
    ]


def found_at(family, mu_c, omega, spread=0.05):
    return flutter_threshold(
        family, (1 - spread) * mu_c, (1 + spread) * mu_c, frequency=omega / (2 * np.pi)
    )


@pytest.mark.parametrize("coupling", [0.3, 2.0])
def test_two_coupled_masses_to_round_off(coupling):
    threshold = flutter_threshold(lumped(coupling), 0.0, 0.9 / coupling)
    assert threshold.factor == pytest.approx(0.5 / coupling, rel=1e-12)
    # The mean of the pair keeps its digits where each member loses half of them.
    assert threshold.eigenvalue == pytest.approx(1j * np.sqrt(1.5), rel=1e-12)
    assert threshold.solves < 20


def test_flutter_that_ends_as_friction_rises():
    """Two contacts that work against each other: S - F - s (-F) comes to rest at s = 0.5."""
    family = lumped(1.0)
    stiffness, friction = family.stiffness.copy(), family.friction.copy()
    stiffness.axpy(-1.0, family.friction)
    friction.scale(-1.0)
    opposed = FrictionFamily(stiffness, family.mass, friction, family.max_frequency)
    threshold = flutter_threshold(opposed, real=0.9, flutter=0.1)
    assert threshold.factor == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize(
    ("real", "flutter", "field"), [(0.0, 0.2, "flutter"), (0.9, 0.8, "real"), (-0.1, 0.8, "real")]
)
def test_factors_that_do_not_enclose_a_threshold_are_refused(real, flutter, field):
    with pytest.raises(InputError) as refused:
        flutter_threshold(lumped(1.0), real, flutter)
    assert refused.value.field == field


def test_a_pair_that_leaves_the_window_is_told():
    family = lumped(1.0)
    with pytest.raises(ConvergenceError, match="lost"):
        flutter_threshold(
            FrictionFamily(family.stiffness, family.mass, family.friction, 1.3 / (2 * np.pi)),
            0.0,
            0.6,
        )


def test_without_friction_there_is_no_family():
    nothing = CoupledSystem({}, aij(np.eye(2)), aij(np.eye(2)), None, (), {})
    with pytest.raises(InputError, match="mu"):
        FrictionFamily.of(nothing, 1.0)


@pytest.mark.parametrize(("backend", "degree", "n"), [("fe", 4, 1), ("iga", 4, 2)])
@pytest.mark.parametrize("i", [0, 3])
def test_first_thresholds_of_the_blocks_on_coarse_meshes(backend, degree, n, i):
    p, mu_c, omega = exact_points()[i]
    threshold = found_at(blocks(backend, degree, n, p, 0.53), mu_c, omega)
    assert threshold.factor == pytest.approx(mu_c, abs=1e-4)
    assert threshold.eigenvalue == pytest.approx(1j * omega, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "degree", "n"), [("fe", 4, 3), ("iga", 4, 4)])
@pytest.mark.parametrize("p", ["1", "10"])
def test_every_threshold_of_the_blocks_to_six_digits(backend, degree, n, p):
    family = blocks(backend, degree, n, p)
    for stiffness, mu_c, omega in exact_points():
        if stiffness == p:
            threshold = found_at(family, mu_c, omega, spread=0.02)
            assert threshold.factor == pytest.approx(mu_c, abs=1e-6)
            assert threshold.eigenvalue == pytest.approx(1j * omega, rel=1e-7)


@pytest.mark.parametrize("backend", ["fe", "iga"])
def test_at_the_threshold_the_mean_keeps_twice_the_order_of_its_members(backend):
    """Quadratic elements: the mean converges like h^4, the members part from it like h^2."""
    p, mu_c, omega = exact_points()[0]
    refinements, errors = (3, 4, 6), []
    for n in refinements:
        values = blocks(backend, 2, n, p, 0.53).modes(mu_c).eigenvalues
        pair = values[np.argsort(np.abs(values - 1j * omega))[:2]]
        mean = 1j * np.sqrt(-(pair**2).mean())
        errors.append([abs(pair[0] - pair[1]) / 2, abs(mean - 1j * omega)])
    members, means = -np.polyfit(np.log(refinements), np.log(errors), 1)[0]
    assert members == pytest.approx(2, abs=0.2)
    assert means == pytest.approx(4, abs=0.2)
