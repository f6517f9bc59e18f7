"""Results are warned of where they should be, and easy scenes never; doubts about the input."""

from functools import cache

import numpy as np
import pytest
from blocks import alone, rectangle, scene_body
from covering import covering

from scenes import inspect_scene, load_scene, read_scene, run_modes, run_scene, run_static
from scenes.checking.warnings import doubtful_numbers, warnings_of
from scenes.running.run import coupled

SEGMENTS, MORTAR = {"method": "segments"}, {"method": "mortar"}


def kinds(warnings):
    return [warning.kind for warning in warnings]


def told(scene):
    """Warnings of bodies and contacts by kind; nothing is solved."""
    system, _ = coupled(scene)
    found = warnings_of(scene, system.bodies, system.contacts)
    return {warning.kind: warning.data for warning in found}


def blocks(backend, **changes):
    """The layers of the catalogue with quadratic elements, 12 on 13."""
    scene = load_scene("blocks", backend=backend)
    mesh = {
        f"bodies.{name}.mesh": scene_body(backend, {}, elements)["mesh"]
        for name, elements in (("upper", [12, 3]), ("lower", [13, 6]))
    }
    contact = {f"contacts.interface.{name}": value for name, value in changes.items()}
    return scene.change(mesh | contact)


@pytest.mark.parametrize(
    ("name", "backend"),
    covering(("blocks", "blocks_constant_mu", "drum"), ("fe", "iga"), strength=1),
)
def test_modes_of_the_catalogue_are_free_of_warnings(name, backend):
    assert run_modes(load_scene(name, backend=backend)).warnings == ()


def test_too_few_points_are_told_with_their_numbers(backend):
    found = told(blocks(backend, formulation={"method": "gpts", "points": 1}))["under-sampled"]
    traces = {"fe": {"upper": 25, "lower": 26}, "iga": {"upper": 14, "lower": 15}}[backend]
    assert (found["points"], found["functions"]) == (12, traces)  # one point lies on a node
    assert "under-sampled" not in told(blocks(backend, formulation={"method": "gpts", "points": 3}))


def test_too_many_points_are_told_where_they_lock():
    """Segments at p = 1e6 are off by 3 %, mortar is not."""
    segments, mortar = (
        run_modes(blocks("iga", formulation=each, p=1e6, mu=0.0, form="saddle"))
        for each in (SEGMENTS, MORTAR)
    )
    assert set(kinds(segments.warnings)) == {"over-constrained"}
    assert mortar.warnings == ()
    off = np.abs(segments.frequencies[:6] / mortar.frequencies[:6] - 1).max()
    assert 0.01 < off < 0.1


@pytest.mark.parametrize(("apart", "expected"), [(0.015, 0.015), (1e-4, None)])
def test_a_closed_gap_is_told_with_its_width(apart, expected):
    moved = {"bodies.upper.placement": {"translation": [0.0, apart, 0.0]}}
    found = told(blocks("iga", reach=0.05).change(moved)).get("gap-closed", {})
    assert found.get("distance") == (expected and pytest.approx(expected, rel=1e-9))


def cantilever(backend, degree, nu, elements=4):
    """A beam of length 4 and height 1 clamped at its end."""
    held = {"material": {"E": 1.0, "nu": nu, "rho": 1.0}, "supports": [{"surface": "x_min"}]}
    beam = rectangle(backend, [4.0, 1.0], [4 * elements, elements], degree=degree, **held)
    return read_scene(alone(beam, 0.5))


@cache
def exact_frequencies(nu):
    """The first three frequencies of the beam."""
    return run_modes(cantilever("iga", 6, nu, elements=8)).frequencies[:3]


def locking_error(backend, degree, nu):
    """Relative error of the first three frequencies with four elements through the height."""
    found = run_modes(cantilever(backend, degree, nu)).frequencies[:3]
    return np.abs(found / exact_frequencies(nu) - 1).max()


@pytest.mark.parametrize(("elements", "limit"), [(("fe", 2), 0.499), (("iga", 2), 0.495)])
def test_volumetric_locking_is_told_where_it_is_measured(elements, limit):
    known, below = locking_error(*elements, 0.3), limit - 0.5 * (0.5 - limit)
    assert locking_error(*elements, limit) > max(0.02, 10 * known)
    assert told(cantilever(*elements, limit))["volumetric-locking"]["nu"] == limit
    assert told(cantilever(*elements, below)) == {}


def test_point_rules_are_told_where_they_are_too_crude(backend):
    """Collocation where contact is soft, lumping where it is stiff or on splines; GPTS nowhere."""
    nodes = {"method": {"fe": "node_to_surface", "iga": "greville"}[backend]}
    gpts = {"method": "gpts", "points": 4}
    lumped = gpts | {"lumped": True}
    for formulation, crude in (
        (nodes, [True, False]),
        (lumped, [backend == "iga", True]),
        (gpts, [False, False]),
    ):
        found = [told(blocks(backend, formulation=formulation, p=p)) for p in (1.0, 1e3)]
        assert ["point-rule" in each for each in found] == crude


@pytest.mark.grid(quick=1)
def test_modes_too_short_for_their_mesh_are_named(backend):
    """Those left are within 3 % of the modes of a fine mesh."""
    scene, coarse = load_scene("drum", backend=backend), scene_body(backend, {}, [2, 12])["mesh"]
    result = run_modes(scene.change({f"bodies.{name}.mesh": coarse for name in scene.bodies}))
    (warning,) = result.warnings
    assert warning.kind == "short-modes"
    short = np.zeros(len(result.modes), dtype=bool)
    short[np.array(warning.data["modes"]) - 1] = True
    fine = run_modes(load_scene("drum", ["analysis.max_frequency=0.6"], "iga")).eigenvalues
    errors = np.array([np.abs(fine - value).min() / abs(value) for value in result.eigenvalues])
    assert 0 < short.sum() < 0.5 * len(short)
    assert errors[~short].max() < 0.03
    assert errors[short].mean() > 5 * errors[~short].mean()


@pytest.mark.grid(quick=1)
def test_too_few_elements_for_a_stiff_law_are_told(backend):
    """Of Hertz contact, whose closed zone is known and whose scene has enough of them."""
    scene, even = load_scene("hertz_cylinder", backend=backend), scene_body(backend, {}, [30, 12])
    meshes = {f"bodies.{name}.mesh": even["mesh"] for name in scene.bodies}
    coarse = run_static(scene.change(meshes))
    (data,) = (w.data for w in coarse.warnings if w.kind == "coarse-closed-zone")
    assert data["elements"] < data["needed"]
    assert data["width"] == pytest.approx(2 * 0.016676, rel=0.5)
    assert "coarse-closed-zone" not in kinds(run_static(scene).warnings)


ON_DISC = "contacts.pad_disc.friction_direction_on_a"
ALONG = {"circumferential_about": [0.0, 0.0, 1.0]}


def off_rotation(origin, direction, **changes):
    """The warning of a small pad on a disc that rotates about an axis through a point."""
    few = {"pad": [2, 4, 1], "disc": [3, 24, 1]}
    changes |= {f"bodies.{name}.mesh.iga.elements": elements for name, elements in few.items()}
    changes |= {f"bodies.{name}.placement": {"translation": origin} for name in few}
    changes |= {"bodies.disc.rotation.origin": origin, ON_DISC: direction}
    changes["contacts.pad_disc.sliding.speed"] = 3.0
    return told(load_scene("disc_pad_damped").change(changes)).get("against-rotation")


@pytest.mark.parametrize(("rate", "is_told"), [(1.0, False), (1e4, True)])
def test_damping_by_friction_on_a_body_that_rotates_fast_is_told(rate, is_told):
    """Of dampers C e' fixed in space, Omega C e x a is missing: with it fast whirl grows."""
    scene = load_scene("disc_pad_damped").change({"bodies.disc.rotation.rate": rate})
    assert ("friction-damping" in told(scene)) == is_told


def test_friction_off_the_direction_of_the_rotations_is_told_with_its_angle():
    """A uniform direction in the middle of a sector of +- 20 degrees is off by 10 on average."""
    there = [0.3, 0.0, 0.0]
    assert off_rotation(there, ALONG | {"origin": there}) is None
    middle = np.radians(45.0)
    radial, along = [np.cos(middle), np.sin(middle), 0.0], [-np.sin(middle), np.cos(middle), 0.0]
    assert off_rotation(there, {"vector": along}) is None
    for direction, angle, fraction in (
        (ALONG | {"origin": there, "circumferential_about": [0.0, 0.0, -1.0]}, 180.0, 1.0),
        ({"vector": radial}, 90.0, 0.5),
        ({"vector": [-x for x in along]}, 170.0, 1.0),
    ):
        found = off_rotation(there, direction)
        assert found["angle"] == pytest.approx(angle, abs=0.1)
        assert found["fraction"] == pytest.approx(fraction, abs=1e-6)
    forgotten = off_rotation(there, ALONG)
    middle_of_pad = there[0] + 0.115 * radial[0], 0.115 * radial[1]
    expected = 45.0 - np.degrees(np.arctan2(middle_of_pad[1], middle_of_pad[0]))
    assert forgotten["angle"] == pytest.approx(expected, abs=0.5)
    assert forgotten["fraction"] == 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_uniform_direction_on_an_annulus_is_told_of_either_sign(sign):
    """Its mean power is zero: rounding must not decide."""
    whole = {"shape": "annulus", "inner_radius": 0.09, "outer_radius": 0.14}
    geometry = whole | {"bottom": 0.012, "top": 0.027}
    mesh = {"iga": {"degree": [2, 2, 2], "elements": [2, 12, 1]}}
    changes = {"bodies.pad.geometry": geometry, "bodies.pad.mesh": mesh}
    found = off_rotation([0.0, 0.0, 0.0], {"vector": [sign, 0.0, 0.0]}, **changes)
    assert found["angle"] == pytest.approx(90.0, abs=1e-6)
    assert found["fraction"] == pytest.approx(0.5, abs=1e-6)


def three_layers(backend, contact, pressure, kind="static"):
    """Layers with nu = 0, guided sideways; a pressure on the upper one, the weight of the middle.

    The lower contact has a law, so that a state of steady sliding is found, unless it is bonded.
    """
    sides = [{"surface": name, "components": ["x"]} for name in ("x_min", "x_max")]
    bodies = {}
    for name, low in (("top", 1.0), ("middle", 0.0), ("base", -1.0)):
        elements = {"top": [3, 2], "middle": [4, 2], "base": [5, 2]}[name]
        material = {"E": 1.0, "nu": 0.0, "rho": 1.0}
        layer = rectangle(backend, [2.0, 1.0], elements, origin=(0.0, low), material=material)
        bodies[name] = layer | {"supports": sides}
    bodies["base"]["supports"] = [*sides, {"surface": "y_min"}]
    law = {"formulation": MORTAR} | ({"c_n": 10.0} if kind == "cea" else {"P": 10.0})
    contacts = {
        "upper": {"a": "top.y_min", "b": "middle.y_max"} | contact,
        "lower": {"a": "middle.y_min", "b": "base.y_max"} | law,
    }
    loads = [{"surface": "top.y_max", "pressure": pressure}]
    loads.append({"body": "middle", "body_force": [0.0, -0.01]})
    analysis = {"kind": kind} | ({"max_frequency": 0.3} if kind == "cea" else {})
    return read_scene(
        {"name": "layers", "bodies": bodies, "contacts": contacts, "loads": loads}
        | {"analysis": analysis}
    )


@pytest.mark.parametrize("kind", ["static", "cea"])
def test_contacts_that_hold_the_sides_together_are_told_with_their_tension(kind, backend):
    """The normal stress is the load: pulled contacts are told, pressed and bonded ones are not."""
    for contact in ({"formulation": MORTAR, "P": np.inf}, {"formulation": SEGMENTS, "p": 10.0}):
        pulled = run_scene(three_layers(backend, contact, -1e-3, kind))
        (data,) = (w.data for w in pulled.warnings if w.kind == "tension")
        assert data == {"contact": "upper", "tension": pytest.approx(1e-3), "fraction": 1.0}
        assert "tension" not in kinds(
            run_scene(three_layers(backend, contact, 1e-3, kind)).warnings
        )
    bonded = three_layers(backend, {"formulation": {"method": "bonded"}, "P": np.inf}, -1e-3, kind)
    assert "tension" not in kinds(run_scene(bonded).warnings)


# Doubts about numbers, motions or places that are unlikely to be meant come with every run.
STEEL, TONNES = {"E": 2.1e11, "rho": 7850.0}, {"E": 2.1e5, "rho": 7.85e-9}


def bar(backend, material=STEEL, size=(0.2, 0.02), max_frequency=2000.0, **others):
    """A bar in plane strain that is held at its left end."""
    held = {"material": {"nu": 0.0} | material, "supports": [{"surface": "x_min"}]}
    return alone(rectangle(backend, size, [8, 2], **held), max_frequency) | others


def doubts_of_both(data):
    """Kinds of warnings of a run, which are those of an inspection."""
    found = kinds(run_scene(read_scene(data)).warnings)
    assert kinds(inspect_scene(read_scene(data)).warnings) == found
    return found


def pulled(backend, strain):
    """The bar pulled with a uniform strain: nu = 0, so that u = strain x."""
    loads = [{"surface": "part.x_max", "pressure": -strain * STEEL["E"]}]
    return run_scene(read_scene(bar(backend, max_frequency=None, loads=loads)))


def test_large_strains_are_told_with_their_number(backend):
    assert kinds(pulled(backend, 0.09).warnings) == []
    (warning,) = pulled(backend, 0.11).warnings
    assert warning.kind == "large-strain"
    assert warning.data["strain"] == pytest.approx(0.11, rel=1e-6)


def test_displacements_larger_than_the_body_are_told(backend):
    """A bar held by a support that moves it by more than its length, without any strain."""
    data = bar(backend, max_frequency=None)
    for moved, expected in ((0.19, []), (0.21, ["large-displacement"])):
        data["bodies"]["part"]["supports"] = [{"surface": "x_min", "value": [moved, 0.0]}]
        assert kinds(run_scene(read_scene(data)).warnings) == expected


@pytest.mark.parametrize(("shift", "overlap"), [((0.1, -0.01), True), ((0.0, 0.02), False)])
def test_bodies_that_overlap_without_a_contact(shift, overlap, backend):
    """Those that touch do not."""
    data = bar(backend)
    geometry = {"shape": "rectangle", "size": [0.2, 0.02], "origin": list(shift)}
    data["bodies"]["other"] = data["bodies"]["part"] | {"geometry": geometry}
    assert doubts_of_both(data) == ["bodies-overlap"] * overlap


@pytest.mark.parametrize(("bore", "overlap"), [(0.2, False), (0.1, True)])
def test_a_body_in_the_hole_of_another_does_not_overlap(bore, overlap, backend):
    data = bar(backend)
    for name, low, high in (("inner", 0.1, 0.2), ("outer", bore, 0.3)):
        geometry = {"shape": "ring", "inner_radius": low, "outer_radius": high}
        data["bodies"][name] = scene_body(backend, geometry, [2, 16], material=STEEL | {"nu": 0.3})
    del data["bodies"]["part"]
    warnings = inspect_scene(read_scene(data)).warnings
    assert kinds(warnings) == ["bodies-overlap"] * overlap


def test_scenes_without_units_say_so_once_and_are_left_alone(backend):
    loads = [{"surface": "part.x_max", "pressure": 1e3}]
    for data in (
        bar(backend, {"E": 1.0, "rho": 1.0}, (200.0, 20.0), None, loads=loads),
        bar(backend, TONNES, (200.0, 20.0), units="other"),
    ):
        result = run_scene(read_scene(data))
        assert result.warnings == ()
        assert "doubts of units" in result.skipped
    found = list(doubtful_numbers(result.scene.change("units", "SI")))
    assert kinds(found) == ["doubtful-units", "doubtful-size"]
    # The speed of sound would be sqrt(2.1e5 / 7.85e-9) m/s.
    assert found[0].data["value"] == pytest.approx(5.172e6, rel=1e-3)
    assert doubts_of_both(bar(backend, TONNES, max_frequency=2e6)) == ["doubtful-units"]
    assert doubts_of_both(bar(backend)) == []
