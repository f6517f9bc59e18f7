"""Bounds on what remains of corrected eigenvalues, beside dense ones of the richer space."""

import numpy as np
import pytest
from covering import covering
from mpi import on_ranks
from nested_scenes import coarse_modes
from reference_data import stored
from richer_truth import apart_from_richer

from scenes import run_modes
from scenes.running.nested import estimate_errors
from scenes.spec.reading import read_scene

BACKENDS = ("fe", "iga")
MODAL = {"modal": {"max_frequency": 30000.0, "ratio": 0.5}}
LIGHT = ({"alpha": 1e-3}, {"alpha": 3e4}, {"beta": 1e-7}, {"beta": 1e-6}, MODAL)
HEAVY = ({"alpha": 9e4}, {"beta": 5e-6}, {"beta": 5e-5})
CRITICAL = float(stored("blocks_sine_mu_thresholds")[0]["mu_c"])


def bar(backend, damping, elements=(3, 1), held=True):
    """Modes of a bar of E = 1e10 Pa in the plane, with left vectors."""
    body = {
        "backend": backend,
        "geometry": {"shape": "rectangle", "size": [0.1, 0.02], "origin": [0.0, 0.0]},
        "material": {"E": 1e10, "nu": 0.3, "rho": 2500.0},
        "supports": [{"surface": "x_min"}] if held else [],
        "damping": damping,
        "mesh": {
            "fe": {"cell": "quadrilateral", "degree": 2, "elements": list(elements)},
            "iga": {"degree": [2, 2], "elements": list(elements)},
        },
    }
    window = {"kind": "cea", "max_frequency": 20000.0}
    if damping is not None:
        window["min_growth"] = -2.5e5
    return modes({"name": "bar", "bodies": {"bar": body}, "contacts": {}, "analysis": window})


def modes(data):
    return run_modes(read_scene(data), left=True)


@pytest.mark.parametrize(
    ("backend", "damping"), covering(BACKENDS, (None, *LIGHT, *HEAVY), strength=2)
)
def test_what_remains_is_bounded_with_any_damping(backend, damping):
    coarse = bar(backend, damping)
    estimate = estimate_errors(coarse)
    assert (apart_from_richer(estimate, coarse) <= estimate.remaining).all()


@pytest.mark.parametrize(("backend", "damping"), covering(BACKENDS, (None, *LIGHT), strength=1))
def test_bounds_are_small_where_solutions_are_smooth(backend, damping):
    """A fifth of the errors, most of them, on a mesh that is not the very coarsest."""
    coarse = bar(backend, damping, elements=(6, 2))
    estimate = estimate_errors(coarse)
    assert (apart_from_richer(estimate, coarse) <= estimate.remaining).all()
    assert np.median(estimate.remaining / estimate.errors) < 0.2


def test_what_damps_too_much_is_not_bounded(backend):
    """Steps leave abs(lambda) beta of what is rough: from 1 on they do not converge."""
    estimate = estimate_errors(bar(backend, {"beta": 5e-6}))
    much = np.abs(estimate.corrected) * 5e-6 > 1.05
    assert 0 < much.sum() < len(much)
    assert np.isinf(estimate.remaining[much]).all()
    assert np.isfinite(estimate.remaining[~much]).any()
    assert {estimate.verdicts[mode] for mode in np.flatnonzero(much)} == {"undecided"}


@pytest.mark.parametrize("damping", [None, {"alpha": 2000.0}, {"beta": 1e-6}])
def test_rigid_motions_are_bounded_by_rounding(backend, damping):
    """Lambda is 0, and -alpha once more."""
    estimate = estimate_errors(bar(backend, damping, held=False))
    alpha = 0.0 if damping is None else damping.get("alpha", 0.0)
    rigid = np.flatnonzero(estimate.eigenvalues.real**2 + estimate.eigenvalues.imag**2 < 5e6)
    assert len(rigid) >= 3
    found = estimate.corrected[rigid]
    apart = np.minimum(np.abs(found), np.abs(found + alpha))
    assert (apart <= estimate.remaining[rigid]).all()
    assert (estimate.remaining[rigid] < 1.0).all()


RUBBING = (
    [{}, {}],
    [{"alpha": 1e-4}, {}],
    [{"alpha": 0.02, "beta": 0.01}, {"beta": 0.02}],
    [{"alpha": 1.0}, {"alpha": 1.0}],
    [{"beta": 0.3}, {"beta": 0.1}],
)


def blocks(backend, mu, damping, elements):
    """Modes of the blocks with friction."""
    changes = [f'contacts.interface.mu="{mu!r}*sin(pi*x/2)"']
    for name, each in zip(("upper", "lower"), damping, strict=True):
        inside = ", ".join(f"{factor}={value!r}" for factor, value in each.items())
        changes += [f"bodies.{name}.damping={{{inside}}}"] if each else []
    if any(damping):
        changes.append("analysis.min_growth=-5.8")
    return coarse_modes("blocks", backend, 2, 2.9, changes, elements)


@pytest.mark.parametrize(
    ("backend", "mu", "damping"), covering(BACKENDS, (0.0, 0.3, 0.6), RUBBING, strength=1)
)
def test_what_remains_is_bounded_with_friction(backend, mu, damping):
    coarse = blocks(backend, mu, damping, {"upper": [4, 2], "lower": [3, 2]})
    estimate = estimate_errors(coarse)
    assert (apart_from_richer(estimate, coarse) <= estimate.remaining).all()


@pytest.mark.parametrize(
    ("backend", "factor", "alpha"),
    covering(BACKENDS, (0.98, 1.0, 1.02), (0.0, 1e-3, 0.1), strength=1),
)
def test_bounds_widen_where_modes_coalesce(backend, factor, alpha):
    """Damping by the mass alone leaves -lambda^2 - alpha lambda, so that modes meet at one mu."""
    damping = [{"alpha": alpha} if alpha else {}] * 2
    coarse = blocks(backend, factor * CRITICAL, damping, {"upper": [5, 2], "lower": [4, 2]})
    estimate = estimate_errors(coarse)
    assert (apart_from_richer(estimate, coarse) <= estimate.remaining).all()


@pytest.mark.parametrize("coriolis", [False, True])
def test_what_remains_is_bounded_where_a_ring_rotates(backend, coriolis):
    """With gyroscopic forces, and damping that rotates."""
    ring = {
        "backend": backend,
        "geometry": {"shape": "ring", "inner_radius": 0.08, "outer_radius": 0.1},
        "material": {"E": 2e11, "nu": 0.3, "rho": 7800.0},
        "damping": {"beta": 1e-6},
        "rotation": {"rate": 2000.0, "convective_stiffness": True, "coriolis": coriolis},
        "mesh": {
            "fe": {"cell": "quadrilateral", "degree": 2, "elements": [1, 10]},
            "iga": {"degree": [2, 2], "elements": [1, 12]},
        },
    }
    window = {"kind": "cea", "max_frequency": 5000.0, "min_growth": -20000.0}
    coarse = modes({"name": "ring", "bodies": {"ring": ring}, "contacts": {}, "analysis": window})
    estimate = estimate_errors(coarse)
    waves = np.abs(estimate.corrected) > 10.0
    assert waves.sum() >= 4
    assert (apart_from_richer(estimate, coarse) <= estimate.remaining)[waves].all()


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_bounds_are_the_same_on_any_ranks(ranks, backend):
    one, other = (on_ranks(n, "nested_scenes.parallel_remaining", backend) for n in (1, ranks))
    np.testing.assert_allclose(other["corrected"], one["corrected"], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(other["remaining"], one["remaining"], rtol=1e-3)
