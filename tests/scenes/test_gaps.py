"""Gaps of contacts: sides touch or say how far apart they are; curved ones are those of the shapes.

Truths are Lame's rings in closed form, distances between circles, and NURBS, whose surfaces are
those of the shapes.
"""

import gmsh
import numpy as np
import pytest
from blocks import scene_body
from gmsh_models import gmsh_model

from cea.errors import InputError
from cea.timing import StageTimer
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from scenes import load_scene, read_scene, run_static
from scenes.building.build import build_bodies, build_contacts

pytestmark = pytest.mark.usefixtures("files_read_here")
MORTAR, SEGMENTS = {"method": "mortar"}, {"method": "segments"}


def interface(scene):
    """The one contact of a scene, matched."""
    (found,) = build_contacts(scene, build_bodies(scene, StageTimer()), StageTimer())
    return found.interface


@pytest.mark.grid
@pytest.mark.parametrize("formulation", [{"method": "gpts", "points": 4}, MORTAR])
@pytest.mark.parametrize("gap", [0.02, 0.24, -0.02])
def test_bodies_apart_are_refused_unless_reach_allows(gap, formulation, backend):
    """Meshes as coarse as these look for a partner within 0.33 m."""
    coarse = {f"bodies.{name}.mesh.{backend}.elements": [3, 2] for name in ("upper", "lower")}
    coarse["contacts.interface.formulation"] = formulation
    scene = load_scene("blocks", backend=backend).change(coarse)
    apart, near = (scene.change("bodies.upper.geometry.origin", [0.0, y]) for y in (gap, 1e-9))
    told = f"{abs(gap)} m {'apart' if gap > 0 else 'inside each other'}"
    with pytest.raises(InputError, match=rf"contacts.interface.reach = None: .* {told}, "):
        interface(apart)
    allowed = interface(apart.change("contacts.interface.reach", 0.3))
    assert allowed.largest_distance == pytest.approx(abs(gap), rel=1e-9)
    assert interface(near).largest_distance < 2e-9


E, NU, SPRINGS, PRESSURE = 1e9, 0.3, 1e10, 1e4
INNER, MIDDLE, OUTER = 0.05, 0.07, 0.1
"""Radii (m) of the inner ring, of the contact, and of the outer ring."""


def static(bodies, load, **contact):
    """A static scene of two bodies that touch."""
    return {
        "name": "curved",
        "bodies": bodies,
        "contacts": {"s": {"formulation": MORTAR, "c_n": 1e12} | contact},
        "loads": [load],
        "analysis": {"kind": "static"},
    }


def rings(degree, elements, backends=("fe", "fe"), formulation=MORTAR):
    """A ring pressed into another by an inner pressure; springs hold both."""
    radii = {"inner": (INNER, MIDDLE), "outer": (MIDDLE, OUTER)}
    bodies = {}
    for (name, (low, high)), backend, each in zip(radii.items(), backends, elements, strict=True):
        geometry = {"shape": "ring", "inner_radius": low, "outer_radius": high}
        springs = [{"surface": name, "stiffness": [SPRINGS, SPRINGS]}]
        material = {"E": E, "nu": NU}
        bodies[name] = scene_body(
            backend, geometry, list(each), degree, material=material, springs=springs
        )
    load = {"surface": "inner.inner", "pressure": PRESSURE}
    around = {"circumferential_about": [0.0, 0.0, 1.0]}
    sides = {"a": "inner.outer", "b": "outer.inner", "reach": 4e-3, "formulation": formulation}
    return static(bodies, load, mu=0.2, friction_direction_on_a=around, **sides)


def lame(c_n=1e12):
    """Contact pressure (N/m^2) of the rings in closed form.

    u = A r + B / r in each; what the law takes, q / c_n, is the closure u_i - u_o.
    """
    first = E / ((1 + NU) * (1 - 2 * NU))

    def u(r):
        return np.array([r, 1 / r])

    def sigma(r):
        return first * np.array([1, -(1 - 2 * NU) / r**2])

    matrix, right = np.zeros((5, 5)), np.zeros(5)
    matrix[0, :2], right[0] = sigma(INNER) - SPRINGS * u(INNER), -PRESSURE
    matrix[1, :2] = sigma(MIDDLE)
    matrix[2, 2:4] = sigma(MIDDLE)
    matrix[1:3, 4] = 1
    matrix[3, 2:4] = sigma(OUTER) + SPRINGS * u(OUTER)
    matrix[4] = [*u(MIDDLE), *-u(MIDDLE), -1 / c_n]
    return float(np.linalg.solve(matrix, right)[4])


NORMAL_FORCE = 2 * np.pi * MIDDLE * lame()
"""Of a uniform pressure around the contact of the rings (N/m)."""


def shaft(degree, clearance=2e-5):
    """Part of a shaft that is pressed into a bore of a radius larger by a clearance (m)."""
    inner = {"inner_radius": 0.03, "outer_radius": 0.07 - clearance, "start": 210.0, "end": 330.0}
    outer = {"inner_radius": 0.07, "outer_radius": 0.1, "start": 195.0, "end": 345.0}
    sector, material = {"shape": "ring_sector"}, {"E": 2e10, "nu": NU}
    bodies = {
        name: scene_body("fe", sector | radii, elements, degree, material=material, **held)
        for name, radii, elements, held in (
            ("shaft", inner, [2, 9], {"springs": [{"surface": "inner", "stiffness": [1e6, 1e6]}]}),
            ("bore", outer, [2, 10], {"supports": [{"surface": "outer"}]}),
        )
    }
    load = {"surface": "shaft.inner", "force": [0.0, -2e4]}
    return static(bodies, load, a="shaft.outer", b="bore.inner", mu=0.0, reach=3e-3)


def in_files(data, folder):
    """The scene with its bodies from mesh files that gmsh writes."""
    for name, each in read_scene(data).bodies.items():
        fe, file = each.mesh.fe, folder / f"{name}.msh"
        breaks = breaks_of(each.geometry, fe.elements)
        with gmsh_model(shape_mesh(each.geometry, fe.cell, fe.degree, breaks=breaks)):
            gmsh.write(str(file))
        geometry = {"shape": "mesh_file", "file": str(file), "unit": "m"}
        data["bodies"][name] |= {"geometry": geometry, "mesh": {}}
    return data


def pressed(data):
    """State of the contact of a static scene, and data of its warnings by their kinds."""
    result = run_static(read_scene(data))
    (state,) = result.steady.contacts.values()
    return state, {warning.kind: warning.data for warning in result.warnings}


@pytest.mark.parametrize(
    ("degree", "backends", "facets"),
    [
        (1, ("fe", "fe"), 3e-4),
        (2, ("fe", "iga"), 3e-7),
        (3, ("iga", "fe"), 1e-8),
        (4, ("fe", "fe"), 3e-11),
    ],
)
def test_rings_that_touch_have_no_gap(degree, backends, facets):
    """However far their facets are apart."""
    data = rings(degree, ((1, 24), (1, 16)), backends)
    placed = {"axis": [0.0, 0.0, 1.0], "angle": 37.0, "translation": [0.3, -0.2, 0.0]}
    for each in data["bodies"].values():
        each["placement"] = placed
    found = interface(read_scene(data))
    assert np.abs(found.initial_gap).max() < 1e-15
    assert found.largest_distance > facets


@pytest.mark.parametrize("degree", [1, 3])
def test_a_shaft_keeps_its_clearance(degree):
    """The distance of two circles along the lines on which facets are searched."""
    clearance = 2e-5
    found = interface(read_scene(shaft(degree, clearance)))
    x, n = found.points.x, found.points.normal
    across = np.einsum("ij,ij->i", x, n)
    beyond = (x**2).sum(axis=1) - across**2
    ends = [np.sqrt(radius**2 - beyond) for radius in (0.07 - clearance, 0.07)]
    np.testing.assert_allclose(found.initial_gap, ends[1] - ends[0], rtol=0, atol=1e-15)
    assert found.initial_gap.min() == pytest.approx(clearance, rel=1e-5)


@pytest.mark.parametrize(
    ("degree", "elements", "formulation"),
    [
        (1, ((2, 80), (2, 68)), MORTAR),
        (2, ((2, 20), (2, 16)), SEGMENTS),
        (3, ((2, 20), (2, 16)), MORTAR),
    ],
)
def test_rings_meet_the_pressure_of_lame(degree, elements, formulation):
    """The normal force always; the peak to two per cent, or with a warning."""
    state, warned = pressed(rings(degree, elements, formulation=formulation))
    assert state.normal_force == pytest.approx(NORMAL_FORCE, rel=2e-3)
    if abs(state.pressure.max() / lame() - 1) > 0.02:
        assert warned["geometry-error"]["relative"] > 0.01
    else:
        assert warned == {}
        assert state.closed_fraction == 1


@pytest.mark.parametrize("degree", [1, 2])
def test_gaps_that_a_mesh_file_cannot_tell_count_as_zero(degree, tmp_path):
    """Rings touch; their normal force is right, and it is said that nobody knows that they do."""
    state, warned = pressed(in_files(rings(degree, ((2, 24), (2, 16))), tmp_path))
    assert state.normal_force == pytest.approx(NORMAL_FORCE, rel=5e-3)
    assert state.pressure.max() == pytest.approx(lame(), rel=0.02)
    zero, error = warned["gaps-as-zero"], warned["geometry-error"]
    assert zero["fraction"] == pytest.approx(1)
    assert 0 < zero["gap"] < zero["geometry_error"]
    assert error["geometry_error"] > error["closure"]


def test_a_clearance_below_the_error_of_a_mesh_file_is_told(tmp_path):
    _, warned = pressed(in_files(shaft(1), tmp_path))
    assert warned["gaps-as-zero"]["geometry_error"] > 2e-5
    assert warned["geometry-error"]["relative"] > 1
