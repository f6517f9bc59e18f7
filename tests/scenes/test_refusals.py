"""What scenes, files and arrays are refused for, each under its name."""

import gzip
import json
from math import inf

import numpy as np
import pytest
from bad_inputs import HOSTILE, coarse, patience, valid

from cea.errors import InputError
from cea.expressions import Expression
from scenes import open_result, run_scene, save_result
from scenes.results.record import read_record, write_record
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene, read_scene


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_expressions_run_nothing_and_ask_for_nothing(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x = np.random.default_rng(1).normal(size=(1000, 3))
    before = x.copy()
    with patience(5), pytest.raises(InputError, match="expression = "):
        Expression(text)(x)
    assert np.array_equal(x, before)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["n" * 101, "\x1b[31mred", "two\nlines", " ", ""])
def test_names_of_scenes_fit_files_and_terminals(name):
    with pytest.raises(SceneError, match="printable"):
        read_scene(valid("disc") | {"name": name})


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


def test_a_small_file_does_not_unpack_to_gigabytes(tmp_path, monkeypatch):
    monkeypatch.setattr("scenes.results.record._LARGEST", 10**6)
    file = tmp_path / "r.json.gz"
    file.write_bytes(gzip.compress(b"[" + b"0," * 10**6 + b"0]"))
    with pytest.raises(InputError, match="more than"):
        read_record(file)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A stored result as text."""
    file = tmp_path_factory.mktemp("stored") / "r.json"
    save_result(run_scene(read_scene(coarse("disc"))), file)
    return file.read_text()


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
def test_stored_results_with_a_part_wrong(place, value, stored, tmp_path):
    data = part = json.loads(stored)
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
