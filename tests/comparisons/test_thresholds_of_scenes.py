"""Thresholds of scenes beside dense eigenvalues, and what is told where there are none."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from mpi import on_ranks
from scipy.sparse import csr_array, save_npz

from comparisons.cli.app import main
from comparisons.cli.sweep import IN_PART
from comparisons.sweep.page import read_sweep
from comparisons.sweep.points import read_axis
from comparisons.sweep.scene import mapped
from comparisons.sweep.study import Asked, run
from comparisons.sweep.tables import headline, thresholds

DATA = Path(__file__).parent.parent / "data" / "thresholds"
BLOCKS = """
name = "blocks"
[bodies.upper]
backend = "fe"
geometry = { shape = "rectangle", size = [2.0, 0.5] }
material = { E = 0.1, nu = 0.25, rho = 0.35 }
supports = [
    { surface = "y_max" },
    { surface = "x_min", components = ["x"] },
    { surface = "x_max", components = ["x"] },
]
damping = { alpha = 0.001 }
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [10, 3] }
[bodies.lower]
backend = "fe"
geometry = { shape = "rectangle", size = [2.0, 1.0], origin = [0.0, -1.0] }
material = { E = 1.0, nu = 0.3, rho = 1.0 }
supports = [
    { surface = "y_min" },
    { surface = "x_min", components = ["x"] },
    { surface = "x_max", components = ["x"] },
]
damping = { alpha = 0.001 }
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [10, 5] }
[contacts.interface]
a = "upper.y_min"
b = "lower.y_max"
formulation = { method = "mortar" }
p = 1.0
mu = 0.3
friction_direction_on_a = { vector = [1.0, 0.0] }
[analysis]
kind = "cea"
max_frequency = 0.47
"""
SINGLE = """
name = "two modes"
[parameters]
mu = 0.9
[files]
I = "I.npz"
K = "K.npz"
[mass]
I = 1.0
[damping]
I = "-mu"
[stiffness]
K = 1.0
[analysis]
kind = "cea"
max_frequency = 5000.0
"""


def found_in(scene, axis, out, data=None):
    """The record of a map of one axis."""
    asked = Asked(scene, (read_axis(axis),), data=data, checks=1, confirm=9)
    made = run(asked, out / "out")
    made.store.discard()
    return made.record


def values_of(record):
    assert not record["unresolved"]
    for each in record["thresholds"]:
        assert abs(each["full_solve_differs"]) <= each["error"] + 1e-9
    return [each["value"] for each in record["thresholds"]]


@pytest.mark.parametrize("axis", ["parameters.mu=0:1:161", "parameters.mu=0:1:11"])
def test_a_second_pair_that_looks_like_the_first_is_found(tmp_path, axis):
    folder = DATA / "second_pair"
    record = found_in(folder / "t.toml", axis, tmp_path, str(folder))
    assert values_of(record) == pytest.approx([0.21959, 0.80353], abs=1e-5)
    assert "first of 2 thresholds" in headline(record)


def test_the_threshold_of_a_lightly_damped_pair_is_found(tmp_path):
    folder = DATA / "light_damping"
    record = found_in(folder / "t.toml", "parameters.mu=0:1:11", tmp_path, str(folder))
    assert values_of(record) == pytest.approx([0.8217853], abs=1e-6)


def test_lightly_damped_blocks_have_both_thresholds(tmp_path):
    """Full solves at 201 values have one growing mode more from 0.0547 and from 0.649 on."""
    (tmp_path / "scene.toml").write_text(BLOCKS)
    record = found_in(tmp_path / "scene.toml", "mu=0:1:6", tmp_path)
    assert values_of(record) == pytest.approx([0.054685, 0.649061], abs=1e-6)


@pytest.fixture
def single(tmp_path):
    """Two modes whose growth is mu / 2 (1/s)."""
    save_npz(tmp_path / "I.npz", csr_array(np.eye(2)))
    save_npz(tmp_path / "K.npz", csr_array(np.diag([1e8, 4e8])))

    def of(level):
        text = SINGLE + (f"growth_threshold = {level}\n" if level else "")
        (tmp_path / "scene.toml").write_text(text)
        return tmp_path / "scene.toml"

    return of


@pytest.mark.parametrize(
    ("level", "axis"), [(0, "parameters.mu=-1:1:5"), (50.0, "parameters.mu=-200:230:6")]
)
def test_growth_that_reaches_its_level_at_a_sample_is_found(tmp_path, single, level, axis):
    record = found_in(single(level), axis, tmp_path, str(tmp_path))
    assert values_of(record) == pytest.approx([2.0 * level] * 2, abs=1e-6)
    frequencies = sorted(each["im"] / (2 * np.pi) for each in record["thresholds"])
    assert frequencies == pytest.approx([1591.5, 3183.1], rel=1e-4)
    assert f"growth_threshold {level:g} 1/s" in headline(record)


def test_where_nothing_begins_it_is_said_that_all_is_resolved(tmp_path, single):
    record = found_in(single(0), "parameters.mu=-2:-1:3", tmp_path, str(tmp_path))
    assert not record["thresholds"]
    assert headline(record).startswith("No flutter for parameters.mu = -2 to -1, every interval")


def test_what_is_not_resolved_is_told_and_ends_in_part(tmp_path, single, monkeypatch, capsys):
    monkeypatch.setattr("cea.reduced.thresholds.BUDGET", 0)
    axis, out = "parameters.mu=-1:1:5", str(tmp_path / "out")
    command = ["cea", "threshold", str(single(0)), axis, "--data", str(tmp_path), "--out", out]
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == IN_PART
    record = json.loads((tmp_path / "out" / "result.json").read_text())
    assert record["unresolved"]
    assert len(thresholds(read_sweep(tmp_path / "out"))) == len(record["unresolved"])
    assert f"{len(record['unresolved'])} intervals unresolved" in capsys.readouterr().out
    assert "unresolved" in [each["kind"] for each in record["warnings"]]


def test_a_mode_that_grows_just_above_the_window_is_told(tmp_path, single):
    text = single(0).read_text().replace("5000.0", "3100.0")
    (tmp_path / "scene.toml").write_text(text)
    record = found_in(tmp_path / "scene.toml", "parameters.mu=10:20:3", tmp_path, str(tmp_path))
    assert record["above"]["frequency"] == pytest.approx(3183.1, rel=1e-4)
    assert record["above"]["growth"] == pytest.approx(5.0, rel=1e-6)
    assert "above-window" in [each["kind"] for each in record["warnings"]]


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["drum", "disc_pad"])
def test_bodies_with_many_doublets_have_the_thresholds_of_full_solves(tmp_path, scene, backend):
    """The number of growing modes at 201 values of mu is what thresholds foresee."""
    bodies = ("outer", "inner") if scene == "drum" else ("pad", "disc")
    overrides = (
        "analysis.growth_threshold=0.0",
        *(f"bodies.{name}.backend='{backend}'" for name in bodies),
    )
    asked = Asked(scene, (read_axis("mu=0:1:21"),), overrides, checks=1, confirm=0)
    record = run(asked, tmp_path / "out").record
    full = mapped(scene, (read_axis("mu=0:1:201"),), overrides, None)
    values, numbers = full.points.axis(0), []
    for value in values:
        modes = full.driver.solve(full.max_frequency, full.point((float(value),)))
        grows = modes.growth_rates > modes.growth_uncertainties
        numbers.append(int(np.where(modes.eigenvalues.imag[grows] > 1.0, 2, 1).sum()))
    full.driver.free()
    places = np.array([each["value"] for each in record["thresholds"]])
    changes = np.array([each["change"] for each in record["thresholds"]])
    foreseen = np.array([changes[(places >= 0) & (places < value)].sum() for value in values])
    wrong = foreseen != np.array(numbers) - (numbers[0] if not (places == 0).any() else 0)
    for value in places:
        wrong &= np.abs(values - value) > 1e-6
    for each in record["unresolved"]:
        wrong &= (values < each["low"]) | (values > each["high"])
    assert not wrong.any(), values[wrong]
    assert len(record["unresolved"]) <= 0.01 * len(values)


@pytest.mark.parametrize("ranks", [2, 3])
def test_thresholds_are_the_same_on_several_ranks(backend, ranks):
    alone = on_ranks(1, "threshold_numbers.numbers", backend)
    assert alone["values"]
    assert not alone["unresolved"]
    several = on_ranks(ranks, "threshold_numbers.numbers", backend)
    assert several["changes"] == alone["changes"]
    assert several["values"] == pytest.approx(alone["values"], rel=1e-7)
    assert several["first"] == pytest.approx(alone["first"], rel=1e-9)
