"""Sides of a contact touch, or the scene says how far apart they are."""

import pytest

from cea.errors import InputError
from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_interfaces
from scenes.spec.reading import load_scene

LIFTED = "bodies.upper.geometry.origin=[0.0,{}]"
METHODS = {"gpts": "{method='gpts',points=4}", "mortar": "{method='mortar'}"}


def interface(scene):
    bodies = build_bodies(scene, StageTimer())
    return next(iter(build_interfaces(scene, bodies, StageTimer()).values()))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("gap", [0.02, 0.24, -0.02])
def test_bodies_apart_are_refused_unless_reach_allows(gap, method, backend):
    """Meshes as coarse as these look for a partner within 0.33 m."""
    coarse = [
        LIFTED.format(gap),
        f"contacts.interface.formulation={METHODS[method]}",
        *(f"bodies.{name}.mesh.iga.elements=[3,2]" for name in ("upper", "lower")),
        *(f"bodies.{name}.mesh.fe.elements=[3,2]" for name in ("upper", "lower")),
    ]
    told = "0.24 m apart" if gap > 0.1 else f"0.02 m {'apart' if gap > 0 else 'inside each other'}"
    with pytest.raises(InputError, match=rf"contacts.interface.reach = None: .* {told}, "):
        interface(load_scene("blocks", coarse, backend))
    allowed = load_scene("blocks", [*coarse, "contacts.interface.reach=0.3"], backend)
    assert interface(allowed).largest_distance == pytest.approx(abs(gap), rel=1e-9)
    coarse[0] = LIFTED.format(1e-9)
    assert interface(load_scene("blocks", coarse, backend)).largest_distance < 2e-9
