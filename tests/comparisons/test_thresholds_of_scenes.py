"""Thresholds of scenes beside dense eigenvalues, and what is told where there are none."""

import json
import re
from pathlib import Path
from tempfile import gettempdir

import numpy as np
import pytest
from mpi import on_ranks
from scipy.sparse import csr_array, save_npz
from sweep_cases import MU, eigenvalues, sine_blocks, sweep_of

from cea.petsc import MPI
from comparisons.cli.sweep import IN_PART
from comparisons.sweep.page import first_lines, headline
from comparisons.sweep.points import read_axis
from comparisons.sweep.scene import mapped
from scenes import assemble, load_scene

pytestmark = pytest.mark.usefixtures("files_read_here")
DATA = Path(__file__).parent.parent / "data" / "thresholds"
SINGLE = """
name = "two modes"
parameters = { mu = 0.9 }
files = { I = "I.npz", K = "K.npz" }
mass = { I = 1.0 }
damping = { I = "-mu" }
stiffness = { K = 1.0 }
analysis = { kind = "cea", max_frequency = 5000.0 }
"""
"""Two modes whose growth is mu / 2 (1/s)."""


def found_in(scene, axis, out, data=None, overrides=()):
    """The record of a map of one axis."""
    return sweep_of(scene, [axis], out / "out", overrides, data=data, checks=1, confirm=9).record


def values_of(record):
    assert not record["unresolved"]
    for each in record["thresholds"]:
        assert abs(each["full_solve_differs"]) <= each["error"] + 1e-9
    return [each["value"] for each in record["thresholds"]]


@pytest.mark.parametrize(
    ("name", "axis", "values"),
    [
        pytest.param(
            *("second_pair", "parameters.mu=0:1:161", [0.21959, 0.80353]), marks=pytest.mark.slow
        ),
        ("second_pair", "parameters.mu=0:1:11", [0.21959, 0.80353]),
        ("light_damping", "parameters.mu=0:1:11", [0.8217853]),
    ],
)
def test_thresholds_of_given_matrices_are_found(tmp_path, name, axis, values):
    """A second pair that looks like the first; a lightly damped one."""
    record = found_in(DATA / name / "t.toml", axis, tmp_path, str(DATA / name))
    assert values_of(record) == pytest.approx(values, abs=1e-5)
    assert ("first of 2 thresholds" in headline(record)) == (len(values) == 2)


@pytest.mark.slow
def test_lightly_damped_blocks_have_both_thresholds(tmp_path):
    """Full solves at 201 values have one growing mode more from 0.0547 and from 0.649 on."""
    overrides = ["analysis.growth_threshold=0.0", "contacts.interface.mu=0.3"]
    for name, elements in (("upper", [10, 3]), ("lower", [10, 5])):
        mesh = f"{{cell='quadrilateral', degree=2, elements={elements}}}"
        overrides += [f"bodies.{name}.backend='fe'", f"bodies.{name}.mesh.fe={mesh}"]
        overrides += [f"bodies.{name}.damping={{alpha=0.001}}"]
    record = found_in("blocks", "mu=0:1:6", tmp_path, overrides=tuple(overrides))
    assert values_of(record) == pytest.approx([0.054685, 0.649061], abs=1e-6)


@pytest.mark.parametrize("full", [False, True])
@pytest.mark.parametrize(
    ("mu", "told"), [("'sin(pi*x/2)'", True), ("'0.1*3'", False), ("0.3", False)]
)
def test_an_axis_that_is_a_factor_on_an_expression_says_so(tmp_path, mu, told, full):
    changes = sine_blocks("iga", f"contacts.interface.mu={mu}", "analysis.max_frequency=0.2")
    swept = sweep_of("blocks", ["mu=0:0.2:2"], tmp_path / "out", changes, full=full)
    lines = [line for line in first_lines(swept) if "is a factor on" in line]
    assert lines == [f"mu is a factor on the scene's expression {MU}, not its value."] * told


@pytest.fixture
def single(tmp_path):
    save_npz(tmp_path / "I.npz", csr_array(np.eye(2)))
    save_npz(tmp_path / "K.npz", csr_array(np.diag([1e8, 4e8])))

    def of(old="", new=""):
        (tmp_path / "scene.toml").write_text(SINGLE.replace(old, new) if old else SINGLE)
        return tmp_path / "scene.toml"

    return of


@pytest.mark.parametrize(
    ("level", "axis"), [(0, "parameters.mu=-1:1:5"), (50.0, "parameters.mu=-200:230:6")]
)
def test_growth_that_reaches_its_level_at_a_sample_is_found(tmp_path, single, level, axis):
    added = f"5000.0, growth_threshold = {level}" if level else "5000.0"
    scene = single("5000.0", added)
    record = found_in(scene, axis, tmp_path, str(tmp_path))
    assert values_of(record) == pytest.approx([2.0 * level] * 2, abs=1e-6)
    frequencies = sorted(each["im"] / (2 * np.pi) for each in record["thresholds"])
    assert frequencies == pytest.approx([1591.5, 3183.1], rel=1e-4)
    assert f"growth_threshold {level:g} 1/s" in headline(record)


def test_where_nothing_begins_or_a_mode_grows_above_the_window_it_is_said(tmp_path, single):
    record = found_in(single(), "parameters.mu=-2:-1:3", tmp_path, str(tmp_path))
    assert not record["thresholds"]
    assert headline(record).startswith("No flutter for parameters.mu = -2 to -1, every interval")
    low = single("5000.0", "3100.0")
    record = found_in(low, "parameters.mu=10:20:3", tmp_path, str(tmp_path))
    told = {each["kind"]: each["message"] for each in record["warnings"]}["above-window"]
    assert re.search(r"at 3183\.\d+ Hz has the growth rate 5 1/s at parameters.mu = 10,", told)


def test_what_is_not_resolved_is_told_and_ends_in_part(tmp_path, single, monkeypatch, cea):
    monkeypatch.setattr("cea.reduced.thresholds.BUDGET", 0)
    out, axis = tmp_path / "out", "parameters.mu=-1:1:5"
    code, written, _ = cea("threshold", single(), axis, "--data", tmp_path, "--out", out)
    assert code == IN_PART
    record = json.loads((out / "result.json").read_text())
    assert record["unresolved"]
    assert f"{len(record['unresolved'])} intervals unresolved" in written
    assert "unresolved" in [each["kind"] for each in record["warnings"]]


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["drum", "disc_pad"])
def test_bodies_with_many_doublets_have_the_thresholds_of_full_solves(tmp_path, scene, backend):
    """The number of growing modes at 201 values of mu is what thresholds foresee."""
    overrides = ["analysis.growth_threshold=0.0"]
    overrides += [f"bodies.{name}.backend='{backend}'" for name in load_scene(scene).bodies]
    options = {"checks": 1, "confirm": 0}
    record = sweep_of(scene, ["mu=0:1:21"], tmp_path / "out", overrides, **options).record
    full = mapped(scene, (read_axis("mu=0:1:201"),), tuple(overrides), None)
    values, numbers = full.points.axes[0], []
    for value in values:
        modes = full.driver.solve(full.window.max_frequency, full.point((float(value),)))
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


def threshold_numbers(backend):
    """What a map of the blocks comes to, and a threshold of the scene, in plain numbers."""
    changes = sine_blocks(backend, "analysis.max_frequency=0.5")
    name = f"thresholds_{MPI.COMM_WORLD.bcast(np.random.default_rng().integers(2**31))}"
    out = Path(gettempdir()) / name
    made = sweep_of("blocks", ["mu=0:0.6:3"], out, changes, checks=0, confirm=0)
    record, z = made.record, [eigenvalues(made, i) ** 2 for i in range(3)]
    first = assemble(load_scene("blocks", changes)).threshold(MU, real=0.0, flutter=0.6)
    return {
        "modes": [len(each) for each in z],
        "sums": [each.sum().real for each in z],
        "squares": [(each**2).sum().real for each in z],
        "solves": len(record["snapshots"]),
        "values": [each["value"] for each in record["thresholds"]],
        "changes": [each["change"] for each in record["thresholds"]],
        "unresolved": len(record["unresolved"]),
        "first": [first.value, first.frequency],
    }


@pytest.mark.mpi
@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("ranks", [3, 2])
def test_maps_and_thresholds_are_the_same_on_several_ranks(backend, ranks):
    alone = on_ranks(1, threshold_numbers, backend)
    assert alone["values"]
    assert not alone["unresolved"]
    several = on_ranks(ranks, threshold_numbers, backend)
    for name in ("changes", "modes", "solves"):
        assert several[name] == alone[name]
    for name, digits in (("sums", 1e-8), ("squares", 1e-8), ("values", 1e-7), ("first", 1e-9)):
        assert several[name] == pytest.approx(alone[name], rel=digits)
