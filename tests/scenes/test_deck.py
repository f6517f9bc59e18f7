"""Decks of CalculiX and Abaqus: read back by their keywords, run by CalculiX, refused by field."""

import sys
from dataclasses import replace
from pathlib import Path

import decks
import numpy as np
import pytest
from mpi import BIN, mpiexec

from comparisons.cli.app import main
from comparisons.peers import calculix
from fe_cea import FEBody
from scenes import load_scene, read_scene, run_modes
from scenes.body_meshes import body_mesh
from scenes.deck.bodies import deck_bodies
from scenes.deck.write import write_deck
from scenes.read import SceneError

P2 = {"cell": "tetrahedron", "degree": 2, "geometry_degree": 1}
STEEL = {"E": 2.1e11, "nu": 0.3, "rho": 7800.0}
ROUND = [
    {"surface": "inner", "components": ["radial", "axial"], "axis": [0.0, 0.0, 1.0]},
    {"surface": "bottom"},
]
SLIDING = [
    {"surface": "outer", "components": ["circumferential"], "axis": [0.0, 0.0, 1.0]},
    {"surface": "top", "components": ["z"]},
]
ELEMENTS = {
    "C3D4": ("tetrahedron", 1),
    "C3D8": ("hexahedron", 1),
    "C3D10": ("tetrahedron", 2),
    "CPE3": ("triangle", 1),
    "CPE4": ("quadrilateral", 1),
    "CPE6": ("triangle", 2),
}
MASS = {"C3D8": None, "C3D10": 2, "C3D4": 1, "CPE4": None}
"""Degree to which CalculiX integrates the mass; None, exactly."""


def body(cell, degree, *, supports=None, elements=None):
    """A ring, or a ring in the plane, of steel."""
    size = {"inner_radius": 0.1, "outer_radius": 0.2}
    mesh = {"cell": cell, "degree": degree, "geometry_degree": 1}
    if cell in ("triangle", "quadrilateral"):
        geometry, elements = {"shape": "ring", **size}, elements or [3, 16]
    else:
        geometry, elements = {"shape": "annulus", **size, "bottom": 0.0, "top": 0.05}, [2, 12, 1]
    return {
        "backend": "fe",
        "geometry": geometry,
        "material": STEEL,
        "supports": supports or [{"surface": "inner"}],
        "mesh": {"fe": {**mesh, "elements": elements}},
    }


def alone(cell, degree, **options):
    bodies = {"part": body(cell, degree, **options)}
    analysis = {"kind": "cea", "max_frequency": 1e4}
    return read_scene({"name": "alone", "bodies": bodies, "analysis": analysis})


def in_contact(**changes):
    """Disc and pad on a few quadratic tetrahedra."""
    fields = {
        "bodies.pad.mesh.fe": {**P2, "elements": [2, 3, 1]},
        "bodies.disc.mesh.fe": {**P2, "elements": [3, 16, 1]},
        "contacts.pad_disc.formulation": {"method": "segments"},
        "analysis.max_frequency": 9000.0,
    }
    return load_scene("disc_pad", backend="fe").change(fields | changes)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Disc and pad as decks: their files, and the cards of each."""
    files = write_deck(in_contact(), tmp_path_factory.mktemp("decks"))
    return files, [decks.cards(file) for file in files]


@pytest.mark.parametrize("name", ELEMENTS)
def test_elements_are_those_of_the_mesh_and_right_handed(name, tmp_path):
    scene = alone(*ELEMENTS[name])
    deck = decks.cards(write_deck(scene, tmp_path)[1])
    kind, elements = decks.elements(deck, "part")
    assert kind == name
    x = decks.nodes(deck)
    mesh = deck_bodies(scene)["part"].mesh
    assert len(elements) == len(mesh.cells)
    assert len(x) == len(mesh.points)
    assert set().union(*elements.values()) == set(x)
    volumes = [volume(np.array([x[n] for n in nodes]), kind) for nodes in elements.values()]
    assert min(volumes) > 0
    sides, height = (16, 1.0) if mesh.dim == 2 else (12, 0.05)
    exact = sides * np.sin(2 * np.pi / sides) / 2 * (0.2**2 - 0.1**2) * height
    assert sum(volumes) == pytest.approx(exact, rel=1e-12)
    if name in decks.LINEAR:
        check_middles(x, elements, kind)


def volume(x, kind):
    """Volume of a straight element, or area; negative where it is inside out."""
    kind = decks.LINEAR.get(kind, kind)
    if kind == "C3D4":
        return np.linalg.det(x[1:4] - x[0]) / 6
    if kind == "C3D8":
        bottom, top = (area(x[i : i + 4, :2]) for i in (0, 4))
        assert bottom == pytest.approx(top)
        return bottom * (x[4, 2] - x[0, 2])
    return area(x[: int(kind[3]), :2])


def area(x):
    """Area of a polygon, positive where it runs counterclockwise."""
    following = np.roll(x, -1, axis=0)
    return float((x[:, 0] * following[:, 1] - x[:, 1] * following[:, 0]).sum() / 2)


def check_middles(x, elements, kind):
    """Nodes behind the corners lie in the middle of the edges that the manuals name."""
    ends = {"C3D10": "12 23 31 14 24 34", "CPE6": "12 23 31"}[kind].split()
    corners = {"C3D10": 4, "CPE6": 3}[kind]
    for nodes in elements.values():
        for middle, (i, j) in zip(nodes[corners:], ends, strict=True):
            expected = (x[nodes[int(i) - 1]] + x[nodes[int(j) - 1]]) / 2
            assert np.allclose(x[middle], expected, atol=1e-15)


@pytest.mark.parametrize("name", ELEMENTS)
def test_surfaces_are_whole_and_their_nodes_are_the_sets(name, tmp_path):
    deck = decks.cards(write_deck(alone(*ELEMENTS[name]), tmp_path)[1])
    x = decks.nodes(deck)
    faces = decks.faces(deck, "part-outer", "part")
    members = decks.members(deck, "part-outer")
    assert {n for face in faces for n in face} <= members
    radii = [np.hypot(*x[n][:2]) for face in faces for n in face]
    assert np.allclose(radii, 0.2)
    sides = 16 if "CPE" in name else 12
    around = sides * 2 * 0.2 * np.sin(np.pi / sides)
    sizes = [size(np.array([x[n] for n in face])) for face in faces]
    assert sum(sizes) == pytest.approx(around if "CPE" in name else around * 0.05)


def size(corners):
    """Length of an edge, area of a flat triangle or quadrilateral."""
    if len(corners) == 2:
        return np.linalg.norm(corners[1] - corners[0])
    diagonals = corners[2] - corners[0], corners[-1] - corners[1]
    return np.linalg.norm(np.cross(*diagonals)) / 2


def test_a_model_names_sets_and_materials_as_the_scene_does(written):
    _, (model, *_) = written
    assert {card.parameters["NSET"] for card in decks.of(model, "NODE")} == {"pad", "disc"}
    (material,) = decks.of(model, "MATERIAL", NAME="disc-material")
    following = model[model.index(material) + 1 :][:2]
    assert [[float(word) for word in card.rows[0]] for card in following] == [[2.1e11, 0.3], [7800]]
    sections = {
        c.parameters["ELSET"]: c.parameters["MATERIAL"] for c in decks.of(model, "SOLID SECTION")
    }
    assert sections == {"pad": "pad-material", "disc": "disc-material"}
    pad = [x for n, x in decks.nodes(model).items() if n in decks.members(model, "pad-bottom")]
    assert np.allclose(np.array(pad)[:, 2], 0.012)
    assert len(decks.members(model, "pad-bottom")) == (2 * 2 + 1) * (2 * 3 + 1)


def test_a_contact_has_the_stiffness_and_the_sides_of_the_scene(written):
    _, (_, *both) = written
    for deck in both:
        (behaviour,) = decks.of(deck, "SURFACE BEHAVIOR")
        straight = 3 * np.sin(np.radians(40 / 3)) * (0.14**2 - 0.09**2) / 2
        assert float(behaviour.rows[0][0]) == pytest.approx(1e9 / straight, rel=1e-12)
        (pair,) = decks.of(deck, "CONTACT PAIR")
        assert pair.rows == [["pad-bottom", "disc-top"]]
        friction = decks.of(deck, "FRICTION")
        assert float(friction[-1].rows[0][0]) == 0.7
        assert len(decks.of(deck, "CHANGE FRICTION")) == 1


def test_abaqus_is_told_the_motion_that_pushes_the_pad_as_the_scene_says(written):
    _, (_, _, deck) = written
    (motion,) = decks.of(deck, "MOTION")
    assert "ROTATION" in motion.parameters
    name, rate, *axis = motion.rows[0]
    assert name == "disc"
    chord = 0.09 * np.cos(np.radians(40 / 6))  # where a node is nearest to the axis
    assert float(rate) == pytest.approx(1 / chord)  # positive: along the friction on the pad
    assert [float(word) for word in axis] == [0, 0, 0, 0, 0, 1]
    (complex_,) = decks.of(deck, "COMPLEX FREQUENCY")
    assert complex_.parameters["FRICTION DAMPING"] == "NO"


def test_without_friction_no_step_is_complex(tmp_path):
    _, theirs, abaqus = write_deck(in_contact(**{"contacts.pad_disc.mu": 0.0}), tmp_path)
    assert not decks.of(decks.cards(abaqus), "COMPLEX FREQUENCY")
    assert not decks.of(decks.cards(theirs), "FRICTION")


def test_held_components_are_those_of_the_supports(tmp_path):
    deck = decks.cards(write_deck(alone("tetrahedron", 2, supports=ROUND), tmp_path)[1])
    (boundary,) = decks.of(deck, "BOUNDARY")
    held = {(row[0], int(row[1]), int(row[2])) for row in boundary.rows}
    assert held == {("part-inner", 1, 1), ("part-inner", 3, 3), ("part-bottom", 1, 3)}
    (transform,) = decks.of(deck, "TRANSFORM")
    assert transform.parameters["TYPE"] == "C"
    assert decks.members(deck, transform.parameters["NSET"]) == decks.members(deck, "part-inner")
    assert [float(word) for word in transform.rows[0]] == [0, 0, 0, 0, 0, 1]


def ours(scene, quadrature, top):
    """Frequencies of this program up to one, with the mass of another."""
    scene = scene.change("analysis.max_frequency", top)
    bodies = {
        name: FEBody.from_mesh(
            name,
            body_mesh(name, spec, ()),
            degree=spec.fe_degree,
            material=spec.material,
            supports=[support.support() for support in spec.supports],
            mass_quadrature=quadrature,
        )
        for name, spec in scene.bodies.items()
    }
    return run_modes(scene, bodies=bodies).eigenvalues


@pytest.mark.parametrize("supports", [None, ROUND, SLIDING], ids=["held", "round", "sliding"])
@pytest.mark.parametrize("name", MASS)
def test_calculix_finds_the_same_frequencies(name, supports, tmp_path):
    decks.with_calculix()
    cell, degree = ELEMENTS[name]
    if name.startswith("CPE") and supports:
        pytest.skip("these supports are in space")
    scene = alone(cell, degree, supports=supports)
    # The last of its list have not always converged, and one may be missing.
    found = calculix.run(write_deck(scene, tmp_path, 16)[1]).eigenvalues.imag[:8]
    values = ours(scene, MASS[name], 1.01 * found[-1] / (2 * np.pi)).imag
    assert found == pytest.approx(np.sort(values)[:8], rel=1e-8 if supports else 1e-10)


def test_calculix_finds_the_same_flutter(tmp_path):
    decks.with_calculix()
    scene = in_contact()
    found = calculix.run(write_deck(scene, tmp_path, 20)[1])
    values = ours(scene, 2, 1.01 * found.eigenvalues.imag[-1] / (2 * np.pi))
    (theirs,) = found.eigenvalues[found.eigenvalues.real > 1]
    (own,) = values[values.real > 1]
    assert theirs.imag == pytest.approx(own.imag, rel=1e-5)
    assert theirs.real == pytest.approx(own.real, rel=1e-3)


def test_friction_pushes_the_pad_as_the_scene_says(tmp_path):
    """No spectrum tells the sign: forces of the static step do."""
    decks.with_calculix()
    deck = write_deck(in_contact(), tmp_path, 4)[1]
    calculix.run(deck)
    listed = deck.with_suffix(".dat").read_text().split("total surface force")[1].splitlines()
    force = np.array(listed[2].split()[:3], dtype=float)
    middle = np.array([-1.0, 1.0]) / np.sqrt(2)  # circumferential, in the middle of the pad
    size = 4 / np.radians(40) * np.sin(np.radians(20)) / 2  # of the mean direction over 40 degrees
    assert force[2] > 0  # the disc pushes the pad up
    assert force[:2] @ middle == pytest.approx(2 * 0.7 * force[2] * size, rel=0.02)


def test_a_model_read_back_is_the_body_that_was_written(written, tmp_path):
    (model, *_), (deck, *_) = written
    scene = in_contact()
    faces = {"pad": ("top", "bottom"), "disc": ("inner", "top")}
    for name, used in faces.items():
        sets = {each: f"{name}-{each}" for each in used}
        file = {"shape": "mesh_file", "file": str(model), "unit": "m", "part": name, "faces": sets}
        scene = scene.change({f"bodies.{name}.geometry": file, f"bodies.{name}.mesh": {}})
    found, before = (run_modes(each).eigenvalues for each in (scene, in_contact()))
    assert found == pytest.approx(before, abs=1e-10 * abs(before).max())
    again = decks.cards(write_deck(scene, tmp_path)[0])
    assert len(decks.nodes(again)) == len(decks.nodes(deck))
    assert decks.faces(again, "pad-bottom", "pad") != []


REFUSED = {
    "NURBS": ({"bodies.pad.backend": "iga"}, "bodies.pad.backend = 'iga'"),
    "nodes inside": (
        {"bodies.pad.mesh.fe": {"cell": "hexahedron", "degree": 2, "elements": [2, 3, 1]}},
        "bodies.pad.mesh.fe.degree = 2: 1 for a deck, or 2 with cell = 'tetrahedron'",
    ),
    "degree": (
        {"bodies.pad.mesh.fe": {**P2, "degree": 3, "elements": [2, 3, 1]}},
        "bodies.pad.mesh.fe.degree = 3",
    ),
    "curved": (
        {"bodies.pad.mesh.fe": {**P2, "geometry_degree": 3, "elements": [2, 3, 1]}},
        "bodies.pad.mesh.fe.geometry_degree = 3",
    ),
    "springs": (
        {"bodies.pad.springs": [{"surface": "top", "stiffness": [1.0, 1.0, 1.0]}]},
        "bodies.pad.springs",
    ),
    "damping": ({"bodies.pad.damping": {"alpha": 1.0}}, "bodies.pad.damping"),
    "rotation": ({"bodies.disc.rotation": {"rate": 1.0}}, "bodies.disc.rotation"),
    "rollers": (
        {"bodies.disc.supports": [{"surface": "inner", "components": ["normal"]}]},
        "bodies.disc.supports.0.components",
    ),
    "field of stiffness": (
        {"contacts.pad_disc.P": None, "contacts.pad_disc.p": "1e11*(1+x)"},
        "contacts.pad_disc.p",
    ),
    "tied": ({"contacts.pad_disc.P": float("inf")}, "contacts.pad_disc.P"),
    "field of friction": ({"contacts.pad_disc.mu": "0.3*(1+x)"}, "contacts.pad_disc.mu"),
    "full pass": ({"contacts.pad_disc.full_pass": True}, "contacts.pad_disc.full_pass"),
    "law": (
        {"contacts.pad_disc.P": None, "contacts.pad_disc.c_n": 1e12},
        "contacts.pad_disc.c_n",
    ),
    "sliding": ({"contacts.pad_disc.sliding": {"speed": 1.0, "pressure": 1e5}}, "pad_disc.sliding"),
    "field of directions": (
        {"contacts.pad_disc.friction_direction_on_a": {"field": ["-y", "x", "0"]}},
        "contacts.pad_disc.friction_direction_on_a",
    ),
    "oblique": (
        {"contacts.pad_disc.friction_direction_on_a": {"vector": [1.0, 0.0, 0.5]}},
        "contacts.pad_disc.friction_direction_on_a",
    ),
    "loads": ({"loads": [{"surface": "disc.bottom", "pressure": 1.0}]}, "loads"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_deck_cannot_hold_is_refused_by_its_field(name, tmp_path):
    changes, told = REFUSED[name]
    with pytest.raises(ValueError, match=r"a deck|a vector, or|sides stay together") as error:
        write_deck(in_contact(**changes), tmp_path)
    assert told in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_texts_of_a_scene_stay_comments(written, tmp_path):
    scene = replace(in_contact(), name="*STEP\nä", description="one\n*END STEP\n\ntwo")
    files = write_deck(scene, tmp_path)
    assert files[0].name == "_STEP___model.inp"
    for file, usual in zip(files, written[1], strict=True):
        assert file.read_bytes().isascii()
        keywords = [card.keyword for card in decks.cards(file)]
        assert keywords == [card.keyword for card in usual]


def test_names_that_programs_do_not_take_are_refused(tmp_path):
    for name in ("1part", "part+", "teil-ä"):
        data = {"name": "names", "bodies": {name: body("tetrahedron", 1)}}
        scene = read_scene({**data, "analysis": {"kind": "cea", "max_frequency": 1e4}})
        with pytest.raises(SceneError, match="a letter, then at most"):
            write_deck(scene, tmp_path)
    twice = {"part": body("tetrahedron", 1), "Part": body("tetrahedron", 1)}
    data = {"name": "names", "bodies": twice, "analysis": {"kind": "cea", "max_frequency": 1e4}}
    with pytest.raises(SceneError, match="that no other has"):
        write_deck(read_scene(data), tmp_path)


def test_a_node_in_two_frames_is_refused(tmp_path):
    supports = [SLIDING[0], {"surface": "top", "components": ["x"]}]
    with pytest.raises(ValueError, match=r"supports\.1\.components = \['x'\]"):
        write_deck(alone("tetrahedron", 1, supports=supports), tmp_path)


@pytest.mark.parametrize("modes", [0, 10**9])
def test_numbers_of_modes_are_bounded(modes, tmp_path):
    with pytest.raises(ValueError, match="modes"):
        write_deck(in_contact(), tmp_path, modes)


def test_the_command_names_what_it_wrote_or_what_is_wrong(tmp_path, monkeypatch, capsys):
    mesh = 'mesh.fe={cell="hexahedron", degree=1, elements=[3, 16, 1]}'
    command = ["cea", "export", "disc", "--out", str(tmp_path), "--set", f"bodies.disc.{mesh}"]
    for more, code in ((["--backend", "fe", "--modes", "7"], 0), ([], 1)):
        monkeypatch.setattr(sys, "argv", [*command, *more])
        with pytest.raises(SystemExit) as end:
            main()
        assert (end.value.code or 0) == code
    told = capsys.readouterr()
    files = [Path(line) for line in told.out.splitlines()]
    assert sorted(files) == sorted(tmp_path.iterdir())
    assert len(files) == 3
    (frequency,) = decks.of(decks.cards(tmp_path / "disc_calculix.inp"), "FREQUENCY")
    assert frequency.rows == [["7"]]
    assert told.err.startswith("error: bodies.disc.backend = 'iga'")


@pytest.mark.mpi
def test_ranks_write_the_deck_once(written, tmp_path):
    (model, *_), _ = written
    overrides = []
    for field in ("pad.mesh.fe.elements=[2,3,1]", "disc.mesh.fe.elements=[3,16,1]"):
        overrides += ["--set", f"bodies.{field}"]
    for name in ("pad", "disc"):
        for field in ('cell="tetrahedron"', "degree=2", "geometry_degree=1"):
            overrides += ["--set", f"bodies.{name}.mesh.fe.{field}"]
        overrides += ["--set", f"bodies.{name}.mesh.fe.through={{}}"]
    command = [BIN / "cea", "export", "disc_pad", "--backend", "fe", *overrides]
    done = mpiexec(2, *command, "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 3
    assert (tmp_path / model.name).read_bytes() == model.read_bytes()
