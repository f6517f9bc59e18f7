"""Bad input is refused: by name, in bounded time and memory, and by nothing but a refusal."""

import gzip
import json
import resource
import sys
from math import inf
from pathlib import Path
from time import perf_counter, sleep

import numpy as np
import pytest
from bad_inputs import (
    HOSTILE,
    NAMES,
    complaint,
    faults_of,
    mutations,
    patience,
    random_bad,
    reader,
    valid,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cea.errors import InputError
from cea.fields import MAX_DEPTH, Expression
from cea.mesh import Mesh
from meshes.patches import GivenPatch
from scenes.opened import open_result
from scenes.read import SceneError, load_scene, read_scene
from scenes.stored import read_record, record, write_record

SEED = 12
QUICK, FULL = 400, 10_000
MOST_MEMORY = 1e9
"""Bytes by which all readers together may grow."""
WINDOW = {
    **{"max_frequency": 1.0, "shift": 2.0, "radius": inf, "found": 1, "discs": 1, "upper": 3.0},
    **{"found_below": 1, "symmetric_count": 1, "max_growth": inf, "bounded": True, "odd": False},
}

quickly = settings(
    max_examples=60,
    deadline=None,  # hangs are told by `patience`; a loaded machine is slow
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
numbers = st.floats() | st.integers() | st.integers(10**300, 10**310)
plain = st.recursive(
    st.none() | st.booleans() | numbers | st.text(max_size=20),
    lambda part: (
        st.lists(part, max_size=4) | st.dictionaries(st.text(max_size=8), part, max_size=4)
    ),
    max_leaves=20,
)


def a_record():
    """Content of a stored run, with a window that holds the whole spectrum."""
    run = {
        "scene": valid("blocks"),
        "dofs": {"free": 3, "bodies": {"upper": 2, "lower": 1}},
        "timings": {"meshing": 0.1},
        "skipped": {"newton": "none"},
        "contacts": {},
        "eigenvalues": [dict.fromkeys(("re", "im", "residual", "condition", "uncertainty"), 0.5)],
        "window": WINDOW,
        "unstable": [],
    }
    return record("run", run, inputs={"scene": "blocks"}, seconds=0.5)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    return write_record(a_record(), tmp_path_factory.mktemp("stored") / "r.json").read_bytes()


def met_badly(count, stored, folder):
    """Complaints about so many random inputs."""
    rng = np.random.default_rng(SEED)
    found = []
    for _ in range(count):
        bad = random_bad(rng, stored)
        told = complaint(bad, reader(bad.kind, folder))
        if told is not None:
            found.append(told)
    return found


def test_some_hundred_random_inputs(stored, tmp_path):
    assert met_badly(QUICK, stored, tmp_path) == []


@pytest.mark.slow
def test_ten_thousand_random_inputs(stored, tmp_path, capsys):
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, perf_counter()
    found = met_badly(FULL, stored, tmp_path)
    seconds = perf_counter() - start
    grown = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    with capsys.disabled():
        told = f"{FULL} bad inputs, seed {SEED}: {len(found)} met badly, {seconds:.0f} s"
        sys.stdout.write(f"\n{told}\n")
    assert found == []
    assert grown < MOST_MEMORY


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_mutation_of_a_scene(name, backend):
    told = [complaint(bad, read_scene) for bad in mutations(valid(name, backend))]
    assert [one for one in told if one] == []
    assert len(told) > 1000


def test_the_harness_sees_what_is_wrong():
    """A reader that takes everything, one that crashes and one that hangs are told."""
    must = next(bad for bad in mutations(valid("disc")) if bad.refused)
    assert "accepted" in complaint(must, lambda data: None)
    assert "KeyError" in complaint(must, lambda data: data["no such field"])
    with pytest.raises(TimeoutError), patience(0.05):
        sleep(10)


NAMELESS = "refused without a name"


def refused_or_read(read, value):
    """What is read, or None where it is refused by name."""
    with patience():
        try:
            return read(value)
        except (InputError, SceneError) as error:
            named = all(fault.field and fault.allowed for fault in faults_of(error))
            return None if named else NAMELESS


@quickly
@given(plain)
def test_nothing_random_is_a_scene(data):
    assert refused_or_read(read_scene, data) is None


@quickly
@given(st.sampled_from(NAMES), st.data())
def test_random_values_in_random_places(name, data):
    scene = valid(name)
    table = scene
    while True:
        key = data.draw(
            st.sampled_from(sorted(table) if isinstance(table, dict) else range(len(table)))
        )
        if not isinstance(table[key], dict | list) or not table[key] or data.draw(st.booleans()):
            break
        table = table[key]
    table[key] = data.draw(plain)
    assert refused_or_read(read_scene, scene) != NAMELESS


@quickly
@given(st.text(max_size=60), st.text(max_size=40))
def test_random_settings(path, value):
    read = refused_or_read(lambda text: load_scene("disc_pad", [text]), f"{path}={value}")
    assert read != NAMELESS


@quickly
@given(st.text(alphabet="xyzr0123456789.+-*/()<>=&|, sincohetaw", max_size=50))
def test_random_expressions_give_finite_numbers_or_a_refusal(text):
    values = refused_or_read(lambda t: Expression(t)(np.full((4, 3), 0.3)), text)
    assert values is None or (values.shape == (4,) and np.isfinite(values).all())


@quickly
@given(st.binary(max_size=300), st.sampled_from(["r.toml", "r.json", "r.json.gz"]))
def test_random_files(tmp_path_factory, content, name):
    file = tmp_path_factory.mktemp("files") / name
    file.write_bytes(content)
    assert refused_or_read(load_scene if name == "r.toml" else open_result, file) is None


@quickly
@given(plain, plain, plain)
def test_random_arrays_are_no_mesh(points, cells, surfaces):
    def made(_):
        return Mesh("triangle", 1, points, cells, surfaces)

    assert refused_or_read(made, None) is None


DIRECTION = "contacts.pad_disc.friction_direction_on_a"
PATCH = {
    "degrees": (1, 1),
    "knots": ((0.0, 0.0, 1.0, 1.0), (0.0, 0.0, 1.0, 1.0)),
    "control_points": (((0.0, 0.0), (0.0, 0.5)), ((0.5, 0.0), (0.5, 0.5))),
    "weights": ((1.0, 1.0), (1.0, 1.0)),
}


@quickly
@given(st.sampled_from(sorted(PATCH)), st.recursive(numbers, st.lists, max_leaves=8))
def test_random_numbers_in_a_patch(part, value):
    data = {"shape": "patches", "patches": [PATCH | {part: value}], "faces": {"low": [[0, 0, 0]]}}
    scene = valid("blocks")
    scene["bodies"]["upper"]["geometry"] = data
    assert refused_or_read(read_scene, scene) is None


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
    with pytest.raises(SceneError, match="without dot"):
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
    monkeypatch.setattr("scenes.stored._LARGEST", 10**6)
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
