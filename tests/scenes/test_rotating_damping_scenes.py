"""Scenes of rotating bodies: rims that outrun waves, damping that cannot rotate."""

import numpy as np
import pytest
from damped_numbers import modally_damped_disc

from scenes import run_modes
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene


def steel_ring(backend, rate, degree=3):
    """A free ring of steel that rotates."""
    ring = {
        "backend": backend,
        "geometry": {"shape": "ring", "inner_radius": 0.09, "outer_radius": 0.1},
        "material": {"E": 2e11, "nu": 0.3, "rho": 7800.0},
        "rotation": {"rate": rate, "convective_stiffness": True, "coriolis": False},
        "mesh": {
            "fe": {"cell": "quadrilateral", "degree": degree, "elements": [1, 24]},
            "iga": {"degree": [degree] * 2, "elements": [1, 24]},
        },
    }
    window = {"kind": "cea", "max_frequency": 2500.0, "min_growth": -20000.0}
    return {"name": "ring", "bodies": {"ring": ring}, "contacts": {}, "analysis": window}


@pytest.mark.parametrize(("part", "told"), [(0.75, False), (1.2, True)])
def test_a_rim_that_outruns_surface_waves_is_warned_of(backend, part, told):
    """Waves of the mesh that the exact ring does not have grow beyond it; below none does."""
    scene = steel_ring(backend, part * np.sqrt(2e11 / 2.6 / 7800.0) / 0.1)
    result = run_modes(read_scene(scene))
    found = [each for each in result.warnings if each.kind == "faster-than-waves"]
    assert bool(found) == told
    assert (result.eigenvalues.real.max() > 1e3) == told
    if told:
        assert found[0].data["speed"] == pytest.approx(part * found[0].data["wave_speed"], rel=0.01)


HALF = [{"surface": "inner", "components": ["x"]}]
ASIDE = [HALF[0] | {"components": ["radial"], "axis": [0.0, 0.0, 1.0], "origin": [0.1, 0.0, 0.0]}]


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"bodies.disc.supports": HALF}, r"bodies\.disc\.supports\.0 = .*all round the axis"),
        ({"bodies.disc.supports": ASIDE}, r"bodies\.disc\.supports\.0 = .*all round the axis"),
        (
            {"bodies.disc.springs": [{"surface": "bottom", "stiffness": [0.1, 0.2, 0.0]}]},
            r"bodies\.disc\.springs\.0\.stiffness = .*all round the axis",
        ),
    ],
)
def test_damping_that_cannot_rotate_is_refused(change, named):
    """Supports that differ round the axis do not rotate with the body; without damping they may."""
    scene = read_scene(modally_damped_disc("iga"))
    with pytest.raises(SceneError, match=named):
        scene.change(change)
    scene.change(change | {"bodies.disc.damping": None})
    scene.change(change | {"bodies.disc.rotation": None})
