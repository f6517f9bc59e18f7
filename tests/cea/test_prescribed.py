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
STATIC = {"kind": "static", "samples": 5}


def box(backend, *others, dim=3, degree=2, divided=False):
    """A static box stretched along x, free to shrink across, with its corner at the origin."""
    supports = [{"surface": f"{axis}_min", "components": [axis]} for axis in "xyz"[:dim]]
    supports += [{"surface": "x_max", "components": ["x"], "value": STRETCH}, *others]
    body = {"supports": supports, "material": {"E": E, "nu": NU, "rho": 1.0}}
    geometry = {"shape": "box" if dim == 3 else "rectangle", "size": list(SIZE[:dim])}
    section = scene_body(backend, geometry, [3, 2, 2][:dim], degree, **body)
    section["mesh"]["fe"]["cell"] = CELLS[dim][divided]
    return alone(section, None)


def solved(data):
    return run_scene(read_scene(data))


@pytest.mark.parametrize(
    ("cells", "dim", "degree"),
    covering([("fe", False), ("fe", True), ("iga", False)], [2, 3], [1, 3]),
)
def test_a_stretched_box_is_exact(cells, dim, degree):
    """Of elements that are boxes, or divided into triangles or tetrahedra; splines have boxes."""
    backend, divided = cells
    result = solved(box(backend, dim=dim, degree=degree, divided=divided))
    sample = result.bodies["part"].space.volume_cells().straight()
    across = -NU if dim == 3 else -NU / (1 - NU)
    expected = STRETCH * np.array([1.0, across, across])[:dim] * sample.points
    found = result.displacements("part", sample.values)
    assert found == pytest.approx(expected, abs=1e-13 * STRETCH)
    modulus = E if dim == 3 else E / (1 - NU**2)
    force = modulus * STRETCH * np.prod(SIZE[1:dim])
    reactions = result.reactions["part"]
    assert reactions[[0, -1], 0] == pytest.approx([-force, force], rel=1e-12)
    assert np.abs(reactions.sum(axis=0)).max() <= 1e-12 * force


@pytest.mark.grid
@pytest.mark.parametrize("form", ["penalty", "saddle"])
def test_supports_that_reach_a_contact_close_it(backend, form):
    """Moving the walls of one block by as much as the ground of the other changes no force."""
    pressures, reactions = [], []
    for mover, value in (("upper", -1e-3), ("lower", 1e-3)):
        data = two_blocks(backend, GPTS, mu=0.2, held=True) | {"analysis": STATIC}
        data["contacts"]["interface"]["form"] = form
        moved = {"value": value} if mover == "upper" else {}
        data["bodies"]["upper"]["supports"] = [
            {"surface": "y_min", "components": ["x", "y"]},
            {"surface": "x_min", "components": ["x"]},
            {"surface": "x_min", "components": ["z"]} | moved,
            {"surface": "z_max", "components": ["z"]} | moved,
        ]
        if mover == "lower":
            data["bodies"]["lower"]["supports"][0]["value"] = [0.0, 0.0, value]
        result = solved(data)
        pressures.append(result.stresses["interface"]["a"].sigma_n)
        reactions.append(result.reactions)
        for name, sign in (("upper", -1), ("lower", 1)):
            assert sign * result.reactions[name].sum(axis=0)[2] > 1e-5
    for one, other in (pressures, *([r[name] for r in reactions] for name in ("upper", "lower"))):
        assert other == pytest.approx(one, abs=1e-10 * np.abs(one).max())


def test_supports_bear_what_a_contact_with_a_law_does(backend, formulation):
    """Although one of them reaches it."""
    data = pressed_blocks(backend, formulation, kind="static", c_n=1e3, m_n=2.5, mu=0.3)
    data["bodies"]["upper"]["supports"] = [
        {"surface": "z_max", "value": [0.0, 0.0, -1e-3]},
        {"surface": "x_min", "components": ["z"], "value": -1e-3},
    ]
    result = solved(data | {"loads": []})
    state = result.steady.contacts["interface"]
    assert state.closed_area > 0
    for name, sign in (("upper", -1), ("lower", 1)):
        forces = result.reactions[name].sum(axis=0)
        assert forces == pytest.approx(sign * state.force_on_a, abs=1e-10 * state.normal_force)


def test_small_motions_are_held_at_zero(backend):
    """Where all of a contact is closed and m_n = 1, how it was closed changes no mode."""
    modes = []
    for value in (-1e-3, -2e-3):
        data = pressed_blocks(backend, GPTS, c_n=10.0, mu=0.1) | {"loads": []}
        data["bodies"]["upper"]["supports"] = [{"surface": "z_max", "value": [0.0, 0.0, value]}]
        data["analysis"]["max_frequency"] = 1.0
        result = solved(data)
        assert result.steady.contacts["interface"].closed_fraction == 1.0
        modes.append(result.eigenvalues)
    assert len(modes[0])
    assert modes[1] == pytest.approx(modes[0], rel=1e-10)


@pytest.mark.parametrize(
    ("support", "field"),
    [
        ({"value": [1.0, 2.0]}, "value"),
        ({"components": ["x"], "value": [1.0, 2.0]}, "value"),
        ({"components": ["x", "x"], "value": [1.0, 2.0]}, "components"),
        ({"components": ["x"], "value": "much"}, "value"),
        ({"components": ["x"], "value": float("nan")}, "value"),
        (
            {"components": ["radial", "circumferential"], "axis": [0.0, 0.0, 1.0]}
            | {"value": [1.0, 0.0]},
            "value",
        ),
    ],
)
def test_what_is_no_value_is_refused(backend, support, field):
    with pytest.raises(SceneError) as refused:
        read_scene(box(backend, {"surface": "y_max"} | support))
    assert any(f.field.startswith("bodies.part.supports.4") for f in refused.value.faults)
    assert any(field in f.field for f in refused.value.faults)


def test_values_that_contradict_each_other_are_refused(backend):
    with pytest.raises(InputError, match=r"supports\.value"):
        solved(box(backend, {"surface": "y_max", "components": ["x"], "value": 0.0}))


CONTACTS = [
    {"formulation": {"method": "mortar"}},
    {"form": "saddle", "P": float("inf")},
    {"formulation": GPTS | {"lumped": True}},
]


@pytest.mark.grid
@pytest.mark.parametrize("contact", CONTACTS, ids=str)
def test_contacts_that_know_no_forces_at_points_refuse_values_that_reach_them(backend, contact):
    data = two_blocks(backend, GPTS, mu=0.0, held=True) | {"analysis": STATIC}
    data["contacts"]["interface"] |= contact
    supports = data["bodies"]["upper"]["supports"]
    supports[0]["value"] = [0.0, 0.0, -1e-3]
    solved(data)
    supports.append({"surface": "x_min", "components": ["z"], "value": -1e-3})
    with pytest.raises(InputError, match=r"contacts\.interface"):
        solved(data)
