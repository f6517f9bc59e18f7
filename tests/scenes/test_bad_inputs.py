"""Bad input is refused: by name, in bounded time and memory, and by nothing but a refusal."""

import json
from math import inf, nan

import numpy as np
import pytest
from bad_inputs import (
    BY_SIZE,
    HOSTILE,
    NAMES,
    PATIENCE,
    TABLE,
    assert_told_well,
    at,
    coarse,
    complaints,
    patience,
    places,
    valid,
    with_value,
)

from cea.errors import ConvergenceError, InputError
from cea.expressions import Expression, Formula
from scenes import SceneError, load_scene, open_result, read_scene, run_scene, save_result
from scenes.results.record import read_record, write_record

SEED = 12
RUNS = 200
"""Changed scenes that are run."""


@pytest.mark.parametrize("base", TABLE["read"])
def test_what_reading_refuses(base):
    """Inputs that are wrong as people get them wrong, each refused by its field."""
    assert complaints("read", base) == []


@pytest.mark.parametrize(
    "base",
    [
        pytest.param(base, marks=pytest.mark.slow if base == "disc_pad" else ())
        for base in TABLE["built"]
    ],
)
def test_what_building_refuses(base):
    assert complaints("built", base) == []


def of_depth(depth):
    """A list in a list, and so on."""
    return [of_depth(depth - 1)] if depth else []


WRONG = [
    None, True, [], {}, "", "text", "inf", "a.b", "\0", -1, 0, 1, 2.5, -1e300, 1e-300, 1e300,
    10**9, 10**400, inf, -inf, of_depth(49), [0.0] * 500, {"": 1, "a.b": 2}, *HOSTILE,
]  # fmt: skip
"""Values for any place."""


def read_or_refused(read, value, seconds=PATIENCE):
    """What is read, or None where it is refused as refusals are told."""
    with patience(seconds):
        try:
            return read(value)
        except (InputError, SceneError) as error:
            assert_told_well(error)
            return None


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_any_value_in_any_place_is_read_or_refused(name, backend):
    """What is not a number is refused everywhere, and so is a field that there is not."""
    data = valid(name, backend)
    for path in places(data):
        for value in WRONG:
            read_or_refused(read_scene, with_value(data, path, value))
        assert read_or_refused(read_scene, with_value(data, path, nan)) is None, path
        if isinstance(table := at(data, path), dict):
            extra = with_value(data, path, table | {"extra": 1})
            assert read_or_refused(read_scene, extra) is None, path


@pytest.mark.slow
def test_what_is_read_runs_or_is_refused(tmp_path):
    """To a result that opens again."""

    def run(scene):
        try:
            open_result(save_result(run_scene(scene), tmp_path / "r.json"))
        except ConvergenceError:
            return

    rng, done = np.random.default_rng(SEED), 0
    names = [name for name in NAMES if name not in BY_SIZE]
    while done < RUNS:
        data = coarse(str(rng.choice(names)), str(rng.choice(["fe", "iga"])))
        everywhere = list(places(data))
        path, value = everywhere[rng.integers(len(everywhere))], WRONG[rng.integers(len(WRONG))]
        scene = read_or_refused(read_scene, with_value(data, path, value))
        if scene is not None:
            read_or_refused(run, scene, 120.0)  # all modes may be asked for
            done += 1


def values(text):
    """A formula and its derivative at a point."""
    formula = Formula(text, {"x": "parameters.x", "y": "parameters.y"})
    at = {"parameters.x": 0.3, "parameters.y": -2.0}
    return [formula.at(at), formula.derivative("parameters.x", at)]


@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: text[:20])
def test_hostile_expressions_run_nothing_and_ask_for_nothing(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x = np.random.default_rng(1).normal(size=(1000, 3))
    before = x.copy()
    with patience(5), pytest.raises(InputError, match="expression = "):
        Expression(text)(x)
    assert np.array_equal(x, before)
    assert read_or_refused(values, text) is None
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a.b", "", " a", "a,b", "x" * 200])
@pytest.mark.parametrize("kind", ["bodies", "contacts"])
def test_names_part_no_paths(name, kind):
    data = valid("disc_pad")
    data[kind][name] = data[kind].pop(next(iter(data[kind])))
    if kind == "bodies":
        data["contacts"]["pad_disc"]["a"] = f"{name}.bottom"
    with pytest.raises(SceneError) as caught:
        read_scene(data)
    assert caught.value.faults[0].field == kind


def test_faults_are_told_together_those_of_single_fields_first():
    single = {
        "bodies.pad.material={E=-1.0,nu=0.7,rho=-3.0}": "bodies.pad.material.E",
        "analysis.max_frequency=-3": "analysis.max_frequency",
    }
    between = {
        "bodies.disc.supports=[{surface='innr'}]": "bodies.disc.supports.0.surface",
        "contacts.pad_disc.a='pad.top'": "contacts.pad_disc.a",
    }
    for settings, told in (([*single, *between], single), (between, between)):
        with pytest.raises(SceneError) as caught:
            load_scene("disc_pad", list(settings))
        assert [fault.field for fault in caught.value.faults] == list(told.values())


@pytest.mark.parametrize(
    "content",
    [
        b"\xff\xfe\x00name",
        b"a = " + b"[" * 100_000,
        b"a = " + b"9" * 5000,
        "name = 'é'".encode("latin-1"),
    ],
)
def test_files_that_are_no_scene(content, tmp_path):
    file = tmp_path / "scene.toml"
    file.write_bytes(content)
    with patience(10), pytest.raises(SceneError) as caught:
        load_scene(file)
    assert all(len(line) < 2000 for line in str(caught.value).splitlines())


def test_stored_results_with_a_part_wrong_are_refused(tmp_path):
    file = save_result(run_scene(read_scene(coarse("disc"))), tmp_path / "r.json")
    good = json.loads(file.read_text())
    for wrong in (
        {"warnings": 3},
        {"eigenvalues": {}},
        {"eigenvalues": [good["eigenvalues"][0] | {"re": "0.0"}]},
        {"window": good["window"] | {"radius": "wide"}},
        {"scene": good["scene"] | {"analysis": {"kind": "static"}}},
    ):
        file.write_text(json.dumps(good | wrong))
        with pytest.raises((InputError, SceneError)):
            open_result(file)


def test_texts_that_read_as_infinity_come_back_as_texts(tmp_path):
    texts = ["inf", "-inf", "\\inf", "\\\\-inf", "nan", "infinite", "\\", inf, -inf, 1.0]
    file = write_record({"texts": texts, "inf": "inf"}, tmp_path / "r.json")
    assert read_record(file) == {"texts": texts, "inf": "inf"}
    with pytest.raises(InputError, match=r"data.a.1 = nan"):
        write_record({"a": [0.0, float("nan")]}, file)
