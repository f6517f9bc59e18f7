"""Study of the crowned pad: points of comparison, closures, what is kept."""

import numpy as np
import pytest

from cea.contact.formulations import GaussPointToSurface, Grid
from comparisons.paper import crowned_pad
from comparisons.paper.crowned_pad import CONTACT, PAD, crowned_scene
from comparisons.paper.figure import midpoints
from scenes import run_modes

COARSE = {
    "fe": {"pad": [2, 6, 1], "disc": [4, 12, 1]},
    "iga": {"pad": [3, 7, 1], "disc": [5, 16, 1]},
}


@pytest.fixture(scope="module", params=["NURBS", "hexahedra"])
def run(request):
    """A coarse run of each backend, with 4 x 4 Gauss points."""
    scene = crowned_scene(request.param, GaussPointToSurface(4), 1e6)
    backend = scene.bodies[PAD].backend
    changes = {f"bodies.{n}.mesh.{backend}.elements": e for n, e in COARSE[backend].items()}
    return run_modes(scene.change(changes | {"analysis.max_frequency": 1500.0}))


def test_common_points_lie_on_the_crowned_face():
    pad = crowned_scene("NURBS", Grid(4), 1e6).bodies[PAD].geometry
    r, theta = midpoints(0.09, 0.14, crowned_pad.RADII), midpoints(25.0, 65.0, crowned_pad.ANGLES)
    x = crowned_pad.common_points(pad).reshape(len(r), len(theta), 3)
    np.testing.assert_allclose(np.hypot(x[..., 0], x[..., 1]), r[:, None] + 0 * theta, rtol=1e-14)
    chord = 2 * r[:, None] * np.sin(np.deg2rad(theta - 45.0) / 2)
    np.testing.assert_allclose(x[..., 2] - 0.012, chord**2 / (2 * 20.0), atol=1e-16)


def test_closures_are_those_that_the_contact_meets(run):
    """At the points of the contact itself, which the law met."""
    points = run.interfaces[CONTACT].points
    state = run.steady.contacts[CONTACT]
    found = crowned_pad.closures(run, points.x)
    np.testing.assert_allclose(found, state.closure, rtol=0, atol=1e-8 * np.abs(found).max())


def test_pressures_kept_add_up_to_the_force(run):
    """Their mean is that of the load on the pad's back, as nearly as few midpoints sum it."""
    kept, pressure, stiffness = crowned_pad.state(run)
    assert pressure.shape == (crowned_pad.RADII, crowned_pad.ANGLES)
    r = midpoints(0.09, 0.14, crowned_pad.RADII)
    mean = (pressure.mean(axis=1) * r).sum() / r.sum()
    assert mean == pytest.approx(1e6, rel=0.02)
    assert kept["force"] == pytest.approx(1e6 * run.bodies[PAD].surfaces["top"].area, rel=1e-3)
    assert 0.5 < kept["closed"] < 0.9
    law = run.scene.contacts[CONTACT].law
    np.testing.assert_allclose(stiffness**2, law.m**2 * law.c * pressure, rtol=1e-10)


def test_distances_from_the_exact_integration():
    exact, pressure = {"P": 2.0, "growth": 50.0}, np.array([3.0, 4.0])
    found = crowned_pad.off(
        {"P": 2.2, "growth": 54.0}, pressure + np.array([0.0, 0.5]), exact, pressure
    )
    assert found == pytest.approx({"pressure_off": 0.1, "P_off": 0.1, "growth_off": 4.0})
