"""Errors estimated in a richer space against true ones."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from blocks import alone, scene_body
from covering import covering
from mpi import on_ranks
from petsc_matrices import dense_pencil, quadratic_eigenvalues
from reference_data import COALESCENCES, exact, plane_meshes, whole_ring

from cea.eigen.matching import assign
from cea.errors import InputError
from comparisons.converge.bars import splitting
from exact_cea.reference import exact_eigenvalues
from scenes import run_modes
from scenes.running.run import estimate_errors
from scenes.spec.reading import load_scene, read_scene
from scenes.spec.refinement import richer_scene

BACKENDS = ("iga", "fe")
FEW = {"upper": [6, 2], "lower": [5, 3]}
HIGHEST = {"drum": 2.0, "blocks": 2.9}
MESHES = {
    ("drum", "fe"): {"outer": [4, 24], "inner": [8, 16]},
    ("drum", "iga"): {"outer": [4, 48], "inner": [8, 40]},
    ("blocks", "fe"): {"upper": [12, 3], "lower": [8, 4]},
    ("blocks", "iga"): {"upper": [15, 3], "lower": [10, 5]},
}
CRITICAL, DOUBLE = COALESCENCES[0][1], COALESCENCES[0][2] ** 2
"""Friction at which modes of the blocks first coalesce, and -lambda^2 of both."""


def coarse_scene(name, backend, degree, highest, overrides=(), elements=None):
    """A plane scene up to a highest Im lambda (rad/s)."""
    meshes = plane_meshes(backend, degree, elements or MESHES[name, backend])
    window = f"analysis.max_frequency={highest / (2 * np.pi)!r}"
    return load_scene(Path(name), [*meshes, window, *overrides], backend)


def coarse_modes(*arguments, **options):
    """Its modes with left vectors."""
    return run_modes(coarse_scene(*arguments, **options), left=True)


def paired(values, others):
    """Of each value the one among others that it stands for."""
    return others[assign(np.abs(values[:, None] - others))[1]]


def apart_from_richer(estimate, coarse):
    """Distances of corrected eigenvalues from those of the richer space, less dense rounding."""
    M, D, K = dense_pencil(run_modes(richer_scene(coarse.scene)).system.pencil().at())
    values, rounding = quadratic_eigenvalues(M, D, K), 1e-14 * np.abs(np.linalg.solve(M, K)).max()
    apart = np.abs(estimate.corrected - paired(estimate.corrected, values))
    return np.maximum(apart - rounding / np.abs(estimate.corrected), 0.0)


@pytest.mark.parametrize(
    ("backend", "by", "degree", "name"),
    covering(BACKENDS, ("bisection", "degree"), (2, 3), ("blocks", "drum"), strength=1),
)
def test_estimates_are_nearly_the_true_errors(backend, by, degree, name):
    """Bisection leaves 2^-2q of the error, a degree more less."""
    coarse = coarse_modes(name, backend, degree, HIGHEST[name])
    estimate = estimate_errors(coarse, richer_scene(coarse.scene, by))
    values = paired(coarse.eigenvalues, exact(name, HIGHEST[name]))
    inside = values.imag < HIGHEST[name]
    true = np.abs(coarse.eigenvalues - values)[inside]
    effectivity = estimate.errors[inside] / true
    expected = 1 - 2.0 ** (-2 * degree) if by == "bisection" else 1.0
    assert np.abs(effectivity - expected).max() < 0.015
    left = np.abs(estimate.corrected - values)[inside] / true
    assert left.max() < 1.05 * (1 - expected) + 0.015


@pytest.mark.slow
def test_estimates_of_a_solid_ring(backend):
    """Clamped edges and rollers on curved rims, which no space holds as another does."""
    mesh = {"fe": {"cell": "hexahedron", "degree": 2}, "iga": {"degree": [2, 2, 2]}}[backend]
    mesh["elements"], highest = [3, 20, 2], 9e4
    changes = {f"bodies.{body}.mesh.{backend}": mesh for body in ("pad", "disc")}
    changes["analysis.max_frequency"] = highest / (2 * np.pi)
    coarse = run_modes(load_scene("ring", backend=backend).change(changes), left=True)
    estimate = estimate_errors(coarse)
    values = paired(coarse.eigenvalues, np.concatenate([[0j], whole_ring()]))
    inside = (values.imag > 1) & (values.imag < highest)
    effectivity = (estimate.errors / np.abs(coarse.eigenvalues - values))[inside]
    assert np.median(effectivity) == pytest.approx(1, abs=0.03)
    assert np.abs(effectivity - 1).max() < 0.12


RULES = ("method='gpts', points=3", "method='segments'")


@pytest.mark.parametrize(("backend", "formulation"), covering(BACKENDS, RULES, strength=1))
def test_rules_of_contact_may_differ(backend, formulation):
    """The richer scene takes the exact integral: what a rule of points errs by is in the error."""
    contact = [f"contacts.interface.formulation={{{formulation}}}"]
    coarse = coarse_modes("blocks", backend, 2, 2.9, contact)
    estimate = estimate_errors(coarse, richer_scene(coarse_scene("blocks", backend, 2, 2.9)))
    values = paired(coarse.eigenvalues, exact("blocks", 2.9))
    effectivity = estimate.errors / np.abs(coarse.eigenvalues - values)
    assert np.abs(effectivity - 1).max() < 0.06


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


def mu_of(value):
    return [f'contacts.interface.mu="{value!r}*sin(pi*x/2)"']


@pytest.mark.parametrize(
    ("backend", "factor"),
    [*product(BACKENDS, [1.0]), slow("iga", 1.02), slow("fe", 0.98)],
)
def test_near_a_coalescence_mean_and_splitting_are_corrected(backend, factor):
    mu = factor * CRITICAL
    estimate = estimate_errors(coarse_modes("blocks", backend, 2, 3.2, mu_of(mu)))
    true = np.full(2, DOUBLE)
    if factor != 1:
        kappa = -(exact_eigenvalues("blocks", max_frequency=3.4, mu=mu) ** 2)
        true = kappa[np.argsort(np.abs(kappa - DOUBLE))[:2]]
    every = -(estimate.eigenvalues**2), -(estimate.corrected**2)
    coarse, corrected = (kappa[np.argsort(np.abs(kappa - DOUBLE))[:2]] for kappa in every)
    for of_pair, rel in ((np.mean, 0.02), (splitting, 0.08)):
        error, left = (abs(of_pair(pair) - of_pair(true)) for pair in (coarse, corrected))
        assert left < rel * error


DAMPED = ["bodies.upper.damping={alpha=0.02,beta=0.01}", "bodies.lower.damping={beta=0.02}"]
STIFF = (
    ["contacts.interface.p=1e9", "contacts.interface.form='penalty'"],
    ["contacts.interface.p=inf"],
    ["contacts.interface.p=inf", "contacts.interface.mu=0.0"],
)


@pytest.mark.parametrize(("backend", "changes"), covering(BACKENDS, STIFF, strength=1))
def test_estimates_are_what_a_search_in_the_richer_space_finds(backend, changes):
    """Tied, stiff, without friction: one step lands on the eigenvalues of that space."""
    coarse = coarse_modes("blocks", backend, 2, 2.9, changes, FEW)
    richer = richer_scene(coarse.scene)
    estimate = estimate_errors(coarse, richer)
    searched = paired(estimate.corrected, run_modes(richer).eigenvalues)
    apart = np.abs(estimate.corrected - searched)
    assert (apart < 0.02 * estimate.errors).all()
    assert (apart <= estimate.remaining + 1e-12).all()


def mass_damping(alpha):
    return [f"bodies.{body}.damping={{alpha={alpha}}}" for body in ("upper", "lower")]


SEEN = (
    [],
    DAMPED,
    mu_of(0.0) + mass_damping(1.0),
    mu_of(CRITICAL),
    mu_of(1.02 * CRITICAL) + mass_damping(0.1),
)


@pytest.mark.parametrize(("backend", "changes"), covering(BACKENDS, SEEN, strength=1))
def test_what_remains_is_less_than_what_the_last_step_changed(backend, changes):
    """Distances from dense eigenvalues of the richer space, on a mesh so coarse that it is seen."""
    window = ["analysis.min_growth=-5.8"] if "damping" in str(changes) else []
    elements = {"upper": [4, 1], "lower": [3, 2]}
    coarse = coarse_modes("blocks", backend, 2, 2.9, changes + window, elements)
    one, two = (estimate_errors(coarse, steps=steps) for steps in (2, 3))
    before, after = (apart_from_richer(each, coarse) for each in (one, two))
    assert (before <= one.remaining + one.uncertainties).all()
    assert (after <= two.remaining + two.uncertainties).all()
    assert after.max() < 0.2 * before.max() + two.uncertainties.max()
    assert (before <= 0.2 * one.errors).all()


@pytest.mark.grid(quick=1)
def test_what_remains_where_a_ring_rotates(backend):
    """With gyroscopic forces, and damping that rotates."""
    ring = scene_body(
        backend,
        {"shape": "ring", "inner_radius": 0.08, "outer_radius": 0.1},
        [1, {"fe": 10, "iga": 12}[backend]],
        material={"E": 2e11, "nu": 0.3, "rho": 7800.0},
        damping={"beta": 1e-6},
        rotation={"rate": 2000.0, "convective_stiffness": True, "coriolis": True},
    )
    data = alone(ring, 5000.0)
    data["analysis"]["min_growth"] = -20000.0
    coarse = run_modes(read_scene(data), left=True)
    estimate = estimate_errors(coarse)
    waves = np.abs(estimate.corrected) > 10.0
    assert waves.sum() >= 4
    assert (apart_from_richer(estimate, coarse) <= estimate.remaining)[waves].all()


def test_the_richer_scene_keeps_all_but_the_spaces():
    scene = load_scene(Path("disc_pad"))
    for by in ("degree", "bisection", "smooth"):
        richer = richer_scene(scene, by)
        bodies = {
            name: replace(richer.bodies[name], mesh=b.mesh) for name, b in scene.bodies.items()
        }
        assert replace(richer, bodies=bodies) == scene != richer


@pytest.mark.grid(quick=1)
def test_errors_of_a_result_without_left_vectors_are_those_with_them(backend):
    scene = coarse_scene("blocks", backend, 2, 2.0, elements=FEW)
    plain, with_left = run_modes(scene), run_modes(scene, left=True)
    assert plain.modes.left is None
    found, expected = estimate_errors(plain), estimate_errors(with_left)
    assert found.corrected == pytest.approx(expected.corrected, rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "by", "told"),
    [
        ([], "smooth", "by = 'smooth': 'degree' or 'bisection' for Lagrange"),
        (["bodies.upper.mesh.fe.degree=4"], "degree", r"upper.mesh.degree = 4: below 4"),
        (
            ["bodies.upper.mesh.fe={cell='triangle', degree=1, size=0.5}"],
            "bisection",
            r"upper.mesh.fe.size = 0.5: left out",
        ),
    ],
)
def test_scenes_that_cannot_be_richer_are_refused(changes, by, told):
    with pytest.raises(InputError, match=told):
        richer_scene(load_scene(Path("blocks"), changes, "fe"), by)


def test_estimates_of_other_scenes_are_refused():
    coarse = coarse_modes("blocks", "fe", 2, 2.0, elements={"upper": [3, 1], "lower": [2, 1]})
    for other, options, told in (
        (None, {"steps": 0}, "steps = 0: 1 or more"),
        (coarse.scene.on("iga"), {}, r"upper.backend = .*one backend for both"),
        (load_scene("drum", [], "fe"), {}, r"bodies = .*those of the coarse scene: upper, lower"),
    ):
        with pytest.raises(InputError, match=told):
            estimate_errors(coarse, other, **options)


def parallel_numbers(backend, by):
    """Corrected eigenvalues and estimates."""
    elements = {"fe": {"upper": [5, 2], "lower": [4, 2]}, "iga": {"upper": [4, 2], "lower": [3, 2]}}
    coarse = coarse_modes("blocks", backend, 2, 3.2, elements=elements[backend])
    estimate = estimate_errors(coarse, richer_scene(coarse.scene, by))
    corrected = [estimate.corrected.real, estimate.corrected.imag]
    return np.concatenate([*corrected, estimate.errors]).tolist()


@pytest.mark.mpi
@pytest.mark.parametrize(("backend", "by"), [("fe", "bisection"), ("iga", "degree")])
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_the_same_on_any_ranks(ranks, backend, by):
    one, other = (on_ranks(n, parallel_numbers, backend, by) for n in (1, ranks))
    np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-10)
