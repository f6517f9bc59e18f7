"""Doubts about the input come with every run, and never with scenes that are meant as they are."""

import pytest
from blocks import rectangle

from scenes import run_scene
from scenes.checking.check import inspect_scene
from scenes.checking.warnings import doubtful_numbers
from scenes.spec.reading import read_scene

STEEL, TONNES = {"E": 2.1e11, "rho": 7850.0}, {"E": 2.1e5, "rho": 7.85e-9}


def bar(backend, *, E=2.1e11, rho=7850.0, size=(0.2, 0.02), analysis=None, **others):
    """A bar in plane strain that is held at its left end."""
    material, supports = {"E": E, "nu": 0.0, "rho": rho}, [{"surface": "x_min"}]
    scene = {
        "name": "bar",
        "bodies": {"bar": rectangle(backend, size, [8, 2], material=material, supports=supports)},
        "analysis": analysis or {"kind": "cea", "max_frequency": 2000.0},
    }
    return scene | others


def kinds(warnings):
    return [warning.kind for warning in warnings]


def pulled(backend, strain, E=2.1e11):
    """The bar pulled with a uniform strain: nu = 0, so that u = strain x."""
    data = bar(
        backend,
        E=E,
        analysis={"kind": "static"},
        loads=[{"surface": "bar.x_max", "pressure": -strain * E}],
    )
    return run_scene(read_scene(data))


def two_bars(backend, shift):
    """Two bars of which the second stands somewhere else, without a contact."""
    data = bar(backend)
    other = dict(data["bodies"]["bar"])
    other["geometry"] = {"shape": "rectangle", "size": [0.2, 0.02], "origin": list(shift)}
    data["bodies"]["other"] = other
    return data


def test_steel_in_tonnes_and_millimetres_is_told_by_every_run(backend):
    """Its speed of sound would be sqrt(2.1e5 / 7.85e-9) = 5.17e6 m/s."""
    data = bar(backend, **TONNES, analysis={"kind": "cea", "max_frequency": 2e6})
    scene = read_scene(data)
    warning = run_scene(scene).warnings[0]
    assert warning.kind == "doubtful-units"
    assert warning.data["value"] == pytest.approx(5.172e6, rel=1e-3)
    assert kinds(inspect_scene(scene).warnings) == ["doubtful-units"]
    assert kinds(run_scene(read_scene(bar(backend))).warnings) == []


def test_large_strains_are_told_with_their_number(backend):
    assert kinds(pulled(backend, 0.09).warnings) == []
    (warning,) = pulled(backend, 0.11).warnings
    assert warning.kind == "large-strain"
    assert warning.data["strain"] == pytest.approx(0.11, rel=1e-6)


def test_displacements_larger_than_the_body_are_told(backend):
    """A bar held by a support that moves it by more than its length, without any strain."""
    data = bar(backend, analysis={"kind": "static"})
    for moved, told in ((0.19, []), (0.21, ["large-displacement"])):
        data["bodies"]["bar"]["supports"] = [{"surface": "x_min", "value": [moved, 0.0]}]
        assert kinds(run_scene(read_scene(data)).warnings) == told


@pytest.mark.parametrize(
    ("shift", "told"),
    [
        ((0.0, 0.01), True),
        ((0.1, -0.01), True),
        ((0.0, 0.02), False),  # they touch
        ((0.2, 0.0), False),
        ((0.0, 0.03), False),
    ],
)
def test_bodies_that_overlap_without_a_contact(shift, told, backend):
    scene = read_scene(two_bars(backend, shift))
    assert kinds(run_scene(scene).warnings) == ["bodies-overlap"] * told
    assert kinds(inspect_scene(scene).warnings) == ["bodies-overlap"] * told


def test_a_body_in_the_hole_of_another_does_not_overlap(backend):
    mesh = {
        "fe": {"cell": "quadrilateral", "degree": 2, "elements": [2, 16]},
        "iga": {"degree": [2, 2], "elements": [2, 16]},
    }
    data = bar(backend)
    data["bodies"] = {
        name: {
            "backend": backend,
            "geometry": {"shape": "ring", "inner_radius": low, "outer_radius": high},
            "material": {"nu": 0.3, **STEEL},
            "mesh": mesh,
        }
        for name, low, high in (("inner", 0.1, 0.2), ("outer", 0.2, 0.3))
    }
    assert kinds(inspect_scene(read_scene(data)).warnings) == []
    data["bodies"]["outer"]["geometry"]["inner_radius"] = 0.1
    assert kinds(inspect_scene(read_scene(data)).warnings) == ["bodies-overlap"]


def test_scenes_without_units_say_so_once_and_are_left_alone(backend):
    data = bar(backend, E=1.0, rho=1.0, size=(200.0, 20.0), analysis={"kind": "static"})
    data["loads"] = [{"surface": "bar.x_max", "pressure": 1e3}]
    result = run_scene(read_scene(data))
    assert result.warnings == ()
    assert "doubts of units" in result.skipped
    assert "doubts of units" not in pulled(backend, 0.01).skipped
    millimetres = bar(backend, **TONNES, size=(200.0, 20.0), units="other")
    result = run_scene(read_scene(millimetres))
    assert result.warnings == ()
    assert "doubts of units" in result.skipped
    assert kinds(doubtful_numbers(result.scene.change("units", "SI"))) == [
        "doubtful-units",
        "doubtful-size",
    ]
