"""Gaps of curved contacts are those of the shapes, however coarse the facets.

Truths are Lame's rings in closed form, distances between circles, and NURBS, whose surfaces are
those of the shapes.
"""

from functools import cache

import numpy as np
import pytest
from covering import covering
from curved_scenes import (
    MORTAR,
    SEGMENTS,
    in_files,
    kinds,
    lame,
    normal_force,
    pressed,
    rings,
    shaft,
    shoe,
)
from mpi import on_ranks

from cea.timing import StageTimer
from scenes import run_static
from scenes.building.build import build_bodies, build_interfaces
from scenes.checking.check import inspect_scene, largest_gap
from scenes.spec.reading import load_scene, read_scene

GPTS = {"method": "gpts", "points": 4}
PLACED = {"axis": [0.0, 0.0, 1.0], "angle": 37.0, "translation": [0.3, -0.2, 0.0]}


def interface(data):
    scene = read_scene(data)
    (found,) = build_interfaces(scene, build_bodies(scene, StageTimer()), StageTimer()).values()
    return found


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
@pytest.mark.parametrize("backends", [("fe", "fe"), ("fe", "iga"), ("iga", "fe")])
def test_rings_that_touch_have_no_gap(degree, backends):
    data = rings(degree, ((1, 24), (1, 16)), backends)
    for each in data["bodies"].values():
        each["placement"] = PLACED
    found = interface(data)
    assert np.abs(found.initial_gap).max() < 1e-15
    assert found.largest_distance > {1: 3e-4, 2: 3e-7, 3: 1e-8, 4: 3e-11}[degree]


@pytest.mark.parametrize(("cell", "degree"), [("hexahedron", 1), ("hexahedron", 3),
                                              ("tetrahedron", 1), ("tetrahedron", 2)])  # fmt: skip
def test_cylinders_that_touch_have_no_gap(cell, degree):
    data = rings(degree, ((1, 12), (1, 8)))
    for each, n in zip(data["bodies"].values(), (24, 16), strict=True):
        each["geometry"] |= {"shape": "annulus", "bottom": 0.0, "top": 0.02}
        each["mesh"] = {"fe": {"cell": cell, "degree": degree, "elements": [1, n, 1]}}
        each["springs"] = []
    found = interface(data)
    assert np.abs(found.initial_gap).max() < 1e-15
    assert found.largest_distance > 1e-8


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_shaft_keeps_its_clearance(degree):
    """The distance of two circles along the lines on which facets are searched."""
    clearance = 2e-5
    found = interface(shaft("fe", degree, 1, clearance))
    x, n = found.points.x, found.points.normal
    across = np.einsum("ij,ij->i", x, n)
    beyond = (x**2).sum(axis=1) - across**2
    ends = [np.sqrt(radius**2 - beyond) for radius in (0.07 - clearance, 0.07)]
    np.testing.assert_allclose(found.initial_gap, ends[1] - ends[0], rtol=0, atol=1e-15)
    assert found.initial_gap.min() == pytest.approx(clearance, rel=1e-5)


@pytest.mark.parametrize("degree", [1, 2])
def test_a_crowned_pad_has_the_gap_of_its_crown(degree):
    """A pad on a flat disc falls away by s^2 / (2 R), s the straight distance from its middle."""
    scene = load_scene("crowned_pad", [f"bodies.pad.mesh.fe.degree={degree}"], "fe")
    (half,) = inspect_scene(scene).halves.values()
    x = half.interface.points.x
    n = half.interface.points.normal
    gap = half.interface.initial_gap
    foot = x + gap[:, None] * n  # on the flat disc, from the face along the normal
    assert np.abs(foot[:, 2] - 0.012).max() < (1e-5 if degree == 1 else 1e-9) + 1e-7
    r = np.hypot(*x[:, :2].T)
    chord = x[:, :2] - r[:, None] * np.array([np.cos(np.pi / 4), np.sin(np.pi / 4)])
    fall = (chord**2).sum(axis=1) / 40.0
    np.testing.assert_allclose(gap, fall, rtol=1e-4, atol=1e-12)
    assert largest_gap(half) == pytest.approx(np.abs(gap).max())


@pytest.mark.parametrize(("degree", "elements"), [(1, ((2, 80), (2, 68))), (2, ((2, 20), (2, 16))),
                                                  (3, ((2, 20), (2, 16)))])  # fmt: skip
@pytest.mark.parametrize("formulation", [MORTAR, SEGMENTS])
def test_rings_meet_the_pressure_of_lame(degree, elements, formulation):
    """The normal force always; the peak to two per cent, or with a warning."""
    result, state, _ = pressed(rings(degree, elements, formulation=formulation))
    assert state.normal_force == pytest.approx(normal_force(lame()), rel=2e-3)
    if abs(state.pressure.max() / lame() - 1) > 0.02:
        assert kinds(result)["geometry-error"]["relative"] > 0.01
    else:
        assert result.warnings == ()
        assert state.closed_fraction == 1
    assert result.warnings == () or formulation is SEGMENTS


@pytest.mark.parametrize("backends", [("fe", "iga"), ("iga", "fe")])
def test_rings_of_both_backends_meet_the_pressure_of_lame(backends):
    _, state, _ = pressed(rings(2, ((2, 20), (2, 16)), backends))
    assert state.normal_force == pytest.approx(normal_force(lame()), rel=1e-5)
    assert state.pressure.max() == pytest.approx(lame(), rel=1e-3)


def test_a_full_pass_meets_the_pressure_of_lame():
    data = rings(2, ((2, 20), (2, 16)), formulation=GPTS, full_pass=True)
    states = run_static(read_scene(data)).steady.contacts.values()
    total = sum(state.normal_force for state in states)
    assert total == pytest.approx(normal_force(lame()), rel=1e-3)
    assert all(state.closed_fraction == 1 for state in states)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_ring_too_large_for_its_bore_meets_the_pressure_of_lame(degree):
    """A shrink fit: the overlap of the shapes is a negative gap."""
    overlap = 1e-5
    _, state, _ = pressed(rings(degree, ((2, 24), (2, 16)), overlap=overlap))
    expected = lame(overlap=overlap)
    assert state.pressure.max() == pytest.approx(expected, rel=0.025)
    assert state.normal_force == pytest.approx(normal_force(expected), rel=0.015)


def test_an_added_gap_is_added_to_that_of_the_shapes():
    _, state, _ = pressed(rings(2, ((2, 24), (2, 16)), added_gap=-1e-5))
    assert state.pressure.max() == pytest.approx(lame(overlap=1e-5), rel=1e-3)


@pytest.mark.convergence
@pytest.mark.parametrize(("degree", "order"), [(1, 2), (2, 4), (3, 6)])
def test_forces_of_rings_converge_as_energies_do(degree, order):
    """Order 2p of the normal force; the peak is a pressure at a point, of order 1 at least."""
    sizes = np.array([1, 2, 4])
    expected, errors, peaks = lame(), [], []
    for k in sizes:
        _, state, _ = pressed(rings(degree, ((k, 12 * k), (k, 8 * k)), mu=0.0))
        errors.append(abs(state.normal_force / normal_force(expected) - 1))
        peaks.append(abs(state.pressure.max() / expected - 1))
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] < -(order - 0.4)
    assert np.polyfit(np.log(sizes), np.log(peaks), 1)[0] < -1
    assert errors[-1] < {1: 2e-4, 2: 1e-6, 3: 1e-8}[degree]
    assert peaks[-1] < {1: 4e-3, 2: 1e-4, 3: 2e-4}[degree]


@pytest.mark.parametrize("scene", [shoe, shaft])
def test_shoes_and_shafts_agree_with_nurbs(scene):
    _, _, expected = pressed(scene("iga", 2, 2))
    for degree, k, close in ((1, 2, 0.02), (2, 2, 0.005), (3, 1, 0.005)):
        result, _, mean = pressed(scene("fe", degree, k))
        if abs(mean / expected - 1) > close:
            assert degree == 1
            assert "geometry-error" in kinds(result)
        else:
            assert result.warnings == () or degree == 1


@cache
def by_nurbs(scene):
    """Normal force, peak and mean pressure of a shoe or a shaft on a fine mesh of NURBS."""
    _, state, mean = pressed(scene("iga", 2, 8))
    return state.normal_force, state.pressure.max(), mean


MESHES = [(1, 2), (1, 4), (2, 1), (2, 2), (3, 1), (3, 2)]
"""Degrees and refinements of working meshes."""


@pytest.mark.parametrize(
    ("scene", "mesh", "source"),
    covering((shoe, shaft), MESHES, ("shapes", "files", "with NURBS", "on NURBS")),
)
def test_working_meshes_agree_with_nurbs_or_say_that_they_may_not(scene, mesh, source, tmp_path):
    """Normal force and pressure to two per cent, or a warning that names the geometry.

    The shoe has corners, where its pressure has no bound. What is compared is the mean, weighted by
    the pressure itself, and of the shaft the peak too.
    """
    data = scene("fe", *mesh)
    first, second = data["bodies"]
    if source == "files":
        in_files(data, tmp_path)
    elif source != "shapes":
        name = second if source == "on NURBS" else first
        data["bodies"][name] = scene("iga", 2, 2)["bodies"][name]
    result, state, mean = pressed(data)
    force, peak, fine = by_nurbs(scene)
    errors = [state.normal_force / force - 1, mean / fine - 1]
    if scene is shaft:
        errors.append(state.pressure.max() / peak - 1)
    close = np.abs(errors).max() < 0.02
    assert close or "geometry-error" in kinds(result)
    assert close or mesh[0] == 1 or source == "files"


@pytest.mark.convergence
@pytest.mark.parametrize(
    ("scene", "degree", "rate", "last"),
    [
        (shoe, 1, 1.5, 0.05),
        (shaft, 1, 1.5, 2e-3),
        (shoe, 2, 1.5, 1e-4),
        (shaft, 2, 0.7, 1e-3),
        pytest.param(shoe, 3, 1.5, 1e-4, marks=pytest.mark.slow),
        pytest.param(shaft, 3, 1.5, 1e-3, marks=pytest.mark.slow),
    ],
)
def test_pressures_of_shoes_and_shafts_converge(scene, degree, rate, last):
    """Towards NURBS; the end of a closed zone and corners leave no higher order."""
    sizes = np.array([2, 4, 8] if degree == 1 else [1, 2, 4])
    means = np.array([pressed(scene("fe", degree, k))[2] for k in sizes])
    errors = np.abs(means / by_nurbs(scene)[2] - 1)
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] < -rate
    assert errors[-1] < last


@pytest.mark.parametrize("degree", [1, 2])
def test_gaps_that_a_mesh_file_cannot_tell_count_as_zero(degree, tmp_path):
    """Rings touch; their normal force is right, and it is said that nobody knows that they do."""
    data = in_files(rings(degree, ((2, 24), (2, 16))), tmp_path)
    result, state, _ = pressed(data)
    assert state.normal_force == pytest.approx(normal_force(lame()), rel=5e-3)
    assert state.pressure.max() == pytest.approx(lame(), rel=0.02)
    found = kinds(result)
    assert found["gaps-as-zero"]["fraction"] == pytest.approx(1)
    assert 0 < found["gaps-as-zero"]["gap"] < found["gaps-as-zero"]["geometry_error"]
    closure = found["geometry-error"]["closure"]
    assert closure == pytest.approx(lame() / 1e12, rel=0.02)
    assert found["geometry-error"]["geometry_error"] > closure


def test_a_clearance_above_the_error_of_a_mesh_file_is_kept(tmp_path):
    result, state, mean = pressed(in_files(shaft("fe", 2, 2), tmp_path))
    _, of_shapes, expected = pressed(shaft("fe", 2, 2))
    assert mean == pytest.approx(expected, rel=0.005)
    assert state.closed_fraction == pytest.approx(of_shapes.closed_fraction, abs=0.02)
    assert set(kinds(result)) == {"geometry-error"}


def test_a_clearance_below_the_error_of_a_mesh_file_is_told(tmp_path):
    result, _, _ = pressed(in_files(shaft("fe", 1, 1), tmp_path))
    found = kinds(result)
    assert found["gaps-as-zero"]["geometry_error"] > 2e-5
    assert found["geometry-error"]["relative"] > 1


def test_flat_mesh_files_are_free_of_warnings(tmp_path, backend):
    bodies = {
        name: {
            "backend": each,
            "geometry": {"shape": "rectangle", "size": [0.1, 0.02], "origin": [0.0, y]},
            "material": {"E": 1e9, "nu": 0.3},
            "mesh": {
                "fe": {"cell": "quadrilateral", "degree": 2, "elements": [n, 2]},
                "iga": {"degree": [2, 2], "elements": [n, 2]},
            },
            "supports": held,
        }
        for name, each, y, n, held in (
            ("upper", backend, 0.0, 5, [{"surface": "x_min", "components": ["x"]}]),
            ("lower", "fe", -0.02, 7, [{"surface": "y_min"}]),
        )
    }
    contact = {"a": "upper.y_min", "b": "lower.y_max", "formulation": MORTAR, "c_n": 1e13}
    data = {
        **{"name": "flat", "bodies": bodies, "contacts": {"s": contact | {"mu": 0.0}}},
        **{"loads": [{"surface": "upper.y_max", "pressure": 1e5}], "analysis": {"kind": "static"}},
    }
    result, state, _ = pressed(in_files(data, tmp_path))
    assert result.warnings == ()
    assert state.normal_force == pytest.approx(1e4)


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_states_do_not_depend_on_the_number_of_ranks(ranks, tmp_path):
    in_files(rings(2, ((1, 12), (1, 8))), tmp_path)
    found, expected = (
        on_ranks(n, "curved_scenes.on_any_number_of_ranks", str(tmp_path)) for n in (ranks, 1)
    )
    for name, numbers in expected.items():
        assert found[name]["force"] == pytest.approx(numbers["force"], rel=1e-9)
        np.testing.assert_allclose(found[name]["pressure"], numbers["pressure"], rtol=1e-6)
        assert found[name]["warnings"].keys() == numbers["warnings"].keys()
        for kind, data in numbers["warnings"].items():
            other = found[name]["warnings"][kind]
            assert other["contact"] == data["contact"] == "s"
            for key in data.keys() - {"contact", "half"}:
                assert other[key] == pytest.approx(data[key], rel=1e-6)
    assert expected["shapes"]["force"] == pytest.approx(normal_force(lame()), rel=1e-3)
