"""Displacements that supports prescribe: exact fields, reactions, contacts they reach, refusals."""

import numpy as np
import pytest
from blocks import alone, scene_body, two_blocks
from covering import covering
from pressed import pressed_blocks

from cea.errors import InputError
from scenes import read_scene, run_scene
from scenes.spec.problems import SceneError

E, NU, STRETCH = 2.0, 0.3, 1e-3
SIZE = (1.0, 0.8, 0.5)
CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}
GPTS = {"method": "gpts", "points": 3}


def held(value, *, dim=3):
    """Supports that stretch a box along x, and leave it free to shrink across."""
    planes = [{"surface": f"{axis}_min", "components": [axis]} for axis in "xyz"[:dim]]
    return [*planes, {"surface": "x_max", "components": ["x"], "value": value}]


def box(backend, supports, *, dim=3, degree=2, cell=None, nu=NU, **body):
    """A static scene of one box with its corner at the origin."""
    geometry = {"shape": "box" if dim == 3 else "rectangle", "size": list(SIZE[:dim])}
    body |= {"supports": supports, "material": {"E": E, "nu": nu, "rho": 1.0}}
    section = scene_body(backend, geometry, [3, 2, 2][:dim], degree, **body)
    section["mesh"]["fe"]["cell"] = cell or CELLS[dim][0]
    return alone(section, None)


def solved(data):
    """The result, points all over its first body, and the displacements there."""
    result = run_scene(read_scene(data))
    name = next(iter(result.bodies))
    sample = result.bodies[name].space.volume_cells().straight()
    return result, sample.points, result.displacements(name, sample.values)


@pytest.mark.parametrize(
    ("cells", "dim", "degree"),
    covering([("fe", False), ("fe", True), ("iga", False)], [2, 3], [1, 3]),
)
def test_a_stretched_box_is_exact(cells, dim, degree):
    """Of elements that are boxes, or divided into triangles or tetrahedra; splines have boxes."""
    backend, divided = cells
    data = box(backend, held(STRETCH, dim=dim), dim=dim, degree=degree, cell=CELLS[dim][divided])
    result, x, u = solved(data)
    across = -NU if dim == 3 else -NU / (1 - NU)
    rates = np.array([1.0, across, across])[:dim]
    assert u == pytest.approx(STRETCH * rates * x, abs=1e-13 * STRETCH)
    modulus = E if dim == 3 else E / (1 - NU**2)
    force = modulus * STRETCH * np.prod(SIZE[1:dim])
    pulled = [force * sign for sign in (-1, 1)]
    assert result.reactions["part"][[0, -1], 0] == pytest.approx(pulled, rel=1e-12)
    assert np.abs(result.reactions["part"].sum(axis=0)).max() <= 1e-12 * force


@pytest.mark.parametrize(
    ("backend", "form"), covering(["fe", "iga"], ["penalty", "saddle"], strength=1)
)
def test_supports_that_reach_a_contact_close_it(backend, form):
    """Moving the walls of one block by as much as the ground of the other changes no force."""
    found = []
    for mover, value in (("upper", -1e-3), ("lower", 1e-3)):
        data = two_blocks(backend, GPTS, mu=0.2, held=True)
        data["contacts"]["interface"]["form"] = form
        data["analysis"] = {"kind": "static", "samples": 5}
        walls = [{"surface": side, "components": ["z"]} for side in ("x_min", "z_max")]
        data["bodies"]["upper"]["supports"] = [{"surface": "y_min", "components": ["x", "y"]}]
        data["bodies"]["upper"]["supports"] += [{"surface": "x_min", "components": ["x"]}, *walls]
        for support in data["bodies"][mover]["supports"]:
            if "components" not in support:
                support["value"] = [0.0, 0.0, value]
            elif support["components"] == ["z"]:
                support["value"] = value
        result = run_scene(read_scene(data))
        found.append((result.stresses["interface"]["a"].sigma_n, result.reactions))
        for name, sign in (("upper", -1), ("lower", 1)):
            assert sign * result.reactions[name].sum(axis=0)[2] > 1e-5
    assert found[1][0] == pytest.approx(found[0][0], abs=1e-10 * np.abs(found[0][0]).max())
    for name in ("upper", "lower"):
        same = found[0][1][name]
        assert found[1][1][name] == pytest.approx(same, abs=1e-10 * np.abs(same).max())


def test_supports_bear_what_a_contact_with_a_law_does(backend, formulation):
    """Although one of them reaches it."""
    data = pressed_blocks(backend, formulation, kind="static", c_n=1e3, m_n=2.5, mu=0.3)
    data["bodies"]["upper"]["supports"] = [
        {"surface": "z_max", "value": [0.0, 0.0, -1e-3]},
        {"surface": "x_min", "components": ["z"], "value": -1e-3},
    ]
    data["loads"] = []
    result = run_scene(read_scene(data))
    state = result.steady.contacts["interface"]
    assert state.closed_area > 0
    forces = result.reactions["upper"].sum(axis=0)
    assert forces == pytest.approx(-state.force_on_a, abs=1e-10 * state.normal_force)
    assert result.reactions["lower"].sum(axis=0) == pytest.approx(
        state.force_on_a, abs=1e-10 * state.normal_force
    )


def test_small_motions_are_held_at_zero(backend):
    """Where all of a contact is closed and m_n = 1, how it was closed changes no mode."""
    modes = []
    for value in (-1e-3, -2e-3):
        data = pressed_blocks(backend, GPTS, c_n=10.0, mu=0.1) | {"loads": []}
        data["bodies"]["upper"]["supports"] = [{"surface": "z_max", "value": [0.0, 0.0, value]}]
        data["analysis"]["max_frequency"] = 1.0
        result = run_scene(read_scene(data))
        assert result.steady.contacts["interface"].closed_fraction == 1.0
        modes.append(result.eigenvalues)
    assert len(modes[0])
    assert modes[1] == pytest.approx(modes[0], rel=1e-10)


def test_values_that_contradict_each_other_are_refused(backend):
    supports = [*held(STRETCH), {"surface": "y_max", "components": ["x"], "value": 0.0}]
    with pytest.raises(InputError, match=r"supports\.value"):
        run_scene(read_scene(box(backend, supports)))


@pytest.mark.parametrize(
    ("support", "field"),
    [
        ({"value": [1.0, 2.0]}, "value"),
        ({"components": ["x"], "value": [1.0, 2.0]}, "value"),
        ({"components": ["x", "x"], "value": [1.0, 2.0]}, "components"),
        ({"components": ["x"], "value": "much"}, "value"),
        ({"components": ["x"], "value": float("nan")}, "value"),
        (
            {
                "components": ["radial", "circumferential"],
                "axis": [0.0, 0.0, 1.0],
                "value": [1.0, 0.0],
            },
            "value",
        ),
    ],
)
def test_what_is_no_value_is_refused(backend, support, field):
    with pytest.raises(SceneError) as refused:
        read_scene(box(backend, [*held(STRETCH), {"surface": "y_max"} | support]))
    assert any(f.field.startswith("bodies.part.supports.4") for f in refused.value.faults)
    assert any(field in f.field for f in refused.value.faults)


@pytest.mark.parametrize(
    ("backend", "contact"),
    covering(
        ["fe", "iga"],
        [
            {"formulation": {"method": "mortar"}},
            {"form": "saddle", "P": float("inf")},
            {"formulation": GPTS | {"lumped": True}},
        ],
        strength=1,
    ),
)
def test_contacts_that_know_no_forces_at_points_refuse_values_that_reach_them(backend, contact):
    data = two_blocks(backend, GPTS, mu=0.0, held=True)
    data["contacts"]["interface"] |= contact
    data["analysis"] = {"kind": "static", "samples": 5}
    data["bodies"]["upper"]["supports"][0]["value"] = [0.0, 0.0, -1e-3]
    run_scene(read_scene(data))
    data["bodies"]["upper"]["supports"] += [
        {"surface": "x_min", "components": ["z"], "value": -1e-3}
    ]
    with pytest.raises(InputError, match=r"contacts\.interface"):
        run_scene(read_scene(data))
