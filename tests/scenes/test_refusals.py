"""What scenes, files and arrays are refused for, each under its name."""

import gzip
import json
from math import inf
from pathlib import Path

import numpy as np
import pytest
from bad_inputs import patience
from scene_mutations import HOSTILE, valid
from stored_runs import PATCH, a_record

from cea.errors import InputError
from cea.expressions import MAX_DEPTH, Expression
from cea.mesh import Mesh
from meshes.patches import GivenPatch
from scenes import open_result
from scenes.results.record import read_record, write_record
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene, read_scene

DIRECTION = "contacts.pad_disc.friction_direction_on_a"


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_expressions_run_nothing_and_ask_for_nothing(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x = np.random.default_rng(1).normal(size=(1000, 3))
    before = x.copy()
    with patience(5), pytest.raises(InputError, match="expression = "):
        Expression(text)(x)
    assert np.array_equal(x, before)
    assert not any(tmp_path.iterdir())


def test_expressions_write_nowhere():
    """The second operand of a numpy function is where it writes to."""
    x = np.random.default_rng(1).normal(size=(5, 3))
    before = x.copy()
    for text in ("sin(x, y)", "maximum(x, y, z)", "sin(x, where=y)"):
        with pytest.raises(InputError, match=r"takes|keyword"):
            Expression(text)(x)
    assert np.array_equal(x, before)


def test_depth_and_constants_of_expressions():
    x = np.full((2, 3), 0.5)
    assert Expression("+".join(["x"] * (MAX_DEPTH - 10)))(x) == pytest.approx(45.0)
    with pytest.raises(InputError, match="nested more"):
        Expression("+".join(["x"] * 300))(x)
    with pytest.raises(SceneError, match="finite everywhere"):
        load_scene("disc_pad", ['contacts.pad_disc.mu="10**10**10"'])
    load_scene("disc_pad", ['contacts.pad_disc.mu="where(x > 0.5, 1, 1/(x - 0.5))"'])


@pytest.mark.parametrize(
    ("override", "field"),
    [
        (f"{DIRECTION}={{vector=[1.0]}}", "friction_direction_on_a.vector"),
        (f"{DIRECTION}={{vector=[1.0,0.0]}}", "friction_direction_on_a.vector"),
        (f"{DIRECTION}={{vector=[0.0,0.0,0.0]}}", "vector"),
        (f"{DIRECTION}={{field=['x']}}", "friction_direction_on_a.field"),
        ("bodies.pad.springs=[{surface='top',stiffness=[1.0]}]", "springs.0.stiffness"),
        ("bodies.pad.supports.0={surface='top',components=['radial']}", "supports.0.axis"),
        ("bodies.pad.mesh.iga.elements=[0,1,1]", "bodies.pad.mesh.iga.elements"),
        ("bodies.disc.mesh.iga.elements=[2,3,1]", "bodies.disc.mesh.iga.elements"),
        ("bodies.pad.mesh.fe.elements=[2,3,-1]", "bodies.pad.mesh.fe.elements"),
        ("bodies.pad.mesh.fe.through={r=[7.0]}", "bodies.pad.mesh.fe.through"),
        ("bodies.pad.mesh.iga.degree=[0,2,2]", "bodies.pad.mesh.iga.degree.0"),
        ("bodies.pad.mesh.iga.continuity=[2,1,1]", "bodies.pad.mesh.iga.continuity"),
        ("bodies.pad.geometry.top=1e300", "bodies.pad.geometry.top"),
        ("bodies.pad.material.E=1e300", "bodies.pad.material.E"),
        ("contacts.pad_disc.P=1e-300", "contacts.pad_disc.P"),
        ("contacts.pad_disc.formulation.points=1000000", "contacts.pad_disc.formulation.points"),
        ("analysis.max_frequency=1e308", "analysis.max_frequency"),
    ],
)  # fmt: skip
def test_what_used_to_be_taken_is_refused_by_name(override, field):
    with pytest.raises(SceneError) as caught:
        load_scene("disc_pad", [override])
    assert any(field in fault.field for fault in caught.value.faults)


@pytest.mark.parametrize(
    ("override", "field"),
    [
        ("contacts.interface.friction_direction_on_a={vector=[1.0,0.0,0.0]}", "vector"),
        ("contacts.interface.friction_direction_on_a={vector=[1.0]}", "vector"),
        (
            "contacts.interface.friction_direction_on_a={circumferential_about=[1.0,0.0,1.0]}",
            "circumferential_about",
        ),
        (
            "contacts.interface.friction_direction_on_a="
            "{circumferential_about=[0.0,0.0,1.0],origin=[0.0,-1.0,2.0]}",
            "origin",
        ),
        ("contacts.interface.friction_direction_on_a={field=['x','y','0']}", "field"),
        ('contacts.interface.mu="0.3 + z"', "mu"),
        ("bodies.upper.placement={axis=[1.0,0.0,0.0],angle=90.0}", "placement"),
        ("bodies.upper.placement={translation=[0.0,0.0,1.0]}", "placement"),
        ("bodies.upper.geometry.origin=[1e20,0.0]", "geometry"),
    ],
)
def test_the_plane_has_two_dimensions(override, field):
    with pytest.raises(SceneError) as caught:
        load_scene("blocks", [override])
    assert any(field in fault.field for fault in caught.value.faults)


def test_sides_have_the_same_dimension():
    data = valid("blocks_3d")
    data["bodies"]["upper"] = valid("blocks")["bodies"]["upper"]
    with pytest.raises(SceneError, match="same dimension"):
        read_scene(data)


@pytest.mark.parametrize("name", ["a.b", "", " a", "a,b", "a\nb", "x" * 200, "\0"])
@pytest.mark.parametrize("kind", ["bodies", "contacts"])
def test_names_part_no_paths(name, kind):
    data = valid("disc_pad")
    first = next(iter(data[kind]))
    data[kind][name] = data[kind].pop(first)
    if kind == "bodies":
        data["contacts"]["pad_disc"]["a"] = f"{name}.bottom"
    with pytest.raises(SceneError) as caught:
        read_scene(data)
    assert caught.value.faults[0].field == kind


def test_names_of_given_surfaces_part_no_paths():
    patch = {name: value for name, value in PATCH.items() if name != "weights"}
    faces = {"y.min": [[0, 1, 0]]}
    scene = valid("blocks")
    scene["bodies"]["upper"]["geometry"] = {"shape": "patches", "patches": [patch], "faces": faces}
    with pytest.raises(SceneError, match="no dot"):
        read_scene(scene)


@pytest.mark.parametrize(
    "content",
    [
        b"\xff\xfe\x00name",
        b"\x00" * 1000,
        b"name = 'a",
        b"a." * 100_000 + b"b = 1",
        b"a = " + b"[" * 100_000,
        b"a = " + b"9" * 5000,
        b"name = 1979-05-27",
        "name = 'é'".encode("latin-1"),
    ],
)
def test_files_that_are_no_scene(content, tmp_path):
    file = tmp_path / "scene.toml"
    file.write_bytes(content)
    with patience(10), pytest.raises(SceneError) as caught:
        load_scene(file)
    assert all(len(line) < 2000 for line in str(caught.value).splitlines())


@pytest.mark.parametrize("place", ["/", "/dev/zero", "\0", "x" * 5000, "x" * 5000 + ".toml", ""])
def test_places_that_hold_no_scene(place):
    with patience(10), pytest.raises(SceneError, match="a TOML file, or one of"):
        load_scene(place)


def test_messages_are_one_line_whatever_they_tell():
    for field, value in (
        ("a\nb", "x"),
        ("a", "x\n" * 9),
        ("a", list(range(10**5))),
        ("a", 10**5000),
    ):
        text = str(InputError(field, value, "nothing\nlike it"))
        assert "\n" not in text
        assert len(text) < 500


def test_a_small_file_does_not_unpack_to_gigabytes(tmp_path, monkeypatch):
    monkeypatch.setattr("scenes.results.record._LARGEST", 10**6)
    file = tmp_path / "r.json.gz"
    file.write_bytes(gzip.compress(b"[" + b"0," * 10**6 + b"0]"))
    with pytest.raises(InputError, match="more than"):
        read_record(file)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("warnings",), 3),
        (("seconds",), "1.0"),
        (("window", "radius"), "wide"),
        (("window", "found"), None),
        (("eigenvalues",), {}),
        (("eigenvalues", 0, "re"), "0.0"),
        (("eigenvalues", 0), 3),
        (("dofs",), []),
        (("scene", "name"), 3),
        (("scene", "analysis"), {"kind": "static"}),
    ],
)
def test_stored_results_with_a_part_wrong(place, value, tmp_path):
    data = json.loads(write_record(a_record(), tmp_path / "r.json").read_text())
    part = data
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    (tmp_path / "wrong.json").write_text(json.dumps(data))
    with pytest.raises((InputError, SceneError)):
        open_result(tmp_path / "wrong.json")


def test_texts_that_read_as_infinity_come_back_as_texts(tmp_path):
    texts = ["inf", "-inf", "\\inf", "\\\\-inf", "nan", "infinite", "\\", inf, -inf, 1.0]
    file = write_record({"texts": texts, "inf": "inf"}, tmp_path / "r.json")
    assert read_record(file) == {"texts": texts, "inf": "inf"}
    with pytest.raises(InputError, match=r"data.a.1 = nan"):
        write_record({"a": [0.0, float("nan")]}, file)


@pytest.mark.parametrize("name", ["inf", "-inf", "nan", "\\inf"])
def test_a_scene_of_any_name_opens_again(name, tmp_path):
    data = a_record()
    data["scene"]["name"] = name
    opened = open_result(write_record(data, tmp_path / "r.json"))
    assert opened.scene.name == name


def test_a_window_of_the_whole_spectrum_is_json(tmp_path):
    file = write_record(a_record(), tmp_path / "r.json")

    def refuse(constant):
        raise ValueError(constant)

    json.loads(file.read_text(), parse_constant=refuse)
    window = open_result(file).modes.window
    assert (window.radius, window.max_growth) == (inf, inf)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"cell": ["triangle"]}, "cell"),
        ({"order": True}, "order"),
        ({"points": [[0, 0], [0]]}, "points"),
        ({"points": [["0", "0"]] * 4}, "points"),
        ({"points": np.full((4, 2), 1j)}, "points"),
        ({"cells": [[0, 1, 2, 3], [0]]}, "cells"),
        ({"cells": [[0, 1, 2, 2]]}, "cells"),
        ({"cells": [[0, 1, 2, 3], [3, 2, 1, 0]]}, "cells"),
        ({"cells": [[0, 1, 2, 10**30]]}, "cells"),
        ({"surfaces": [[0, 1]]}, "surfaces"),
        ({"surfaces": {3: [[0, 1]]}}, "surfaces"),
    ],
)
def test_arrays_that_are_no_mesh(change, field):
    square = {
        **{"cell": "quadrilateral", "order": 1, "points": [[0, 0], [0, 1], [1, 0], [1, 1]]},
        **{"cells": [[0, 1, 2, 3]], "surfaces": {"left": [[0, 1]]}},
    }
    Mesh(**square)
    with pytest.raises(InputError) as caught:
        Mesh(**square | change)
    assert caught.value.field == field


def test_control_points_are_numbers():
    with pytest.raises(InputError, match="control_points"):
        GivenPatch(**PATCH | {"control_points": [[["0", "0"]] * 2] * 2})


def test_nothing_is_left_behind():
    assert not Path("stolen").exists()
