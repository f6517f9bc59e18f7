"""Sweeps and maps: values, thresholds and slopes of full solves, files, and interruptions."""

import json
import signal
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest
import xarray
from covering import covering
from reference_data import plane_meshes
from sweep_cases import MESHES, MU, P, assert_within_bounds, sine_blocks, sweep_of

from cea.errors import InputError
from cea.reduced.full_solves import SpectraAlong
from cea.reduced.greedy import Enrichment
from cea.reduced.model import ReducedModel
from comparisons.sweep.page import read_sweep, write_sweep
from comparisons.sweep.points import read_axis, read_fields
from comparisons.sweep.scene import NoMapError, mapped
from comparisons.sweep.store import fingerprint
from comparisons.sweep.study import Asked, run
from scenes import load_scene, run_modes

WAY = "contacts.interface.friction_direction_on_a"
TOP = ("analysis.max_frequency=0.4", "analysis.growth_threshold=0.0")
RNG = np.random.default_rng(5)
BONDED = Path(__file__).parent.parent / "data" / "sweeps" / "bonded.toml"
TIED = "contacts.tie.P=inf"
MAP = ("mu=0:2:21", "P=0.5:500:log:4")


def asked(backend, *axes, **options):
    return Asked("blocks", read_fields(axes), sine_blocks(backend, *TOP), **options)


@pytest.fixture(scope="module", params=["iga", pytest.param("fe", marks=pytest.mark.slow)])
def made(request, tmp_path_factory):
    """A map over three decades of P, its backend and its folder."""
    folder = tmp_path_factory.mktemp("sweep") / "out"
    swept = run(asked(request.param, *MAP), folder)
    write_sweep(swept, folder)
    swept.store.discard()
    return swept, request.param, folder


@pytest.mark.parametrize(
    "fields", [("mu=0:2:25", "P=1e-3:1e9:log:4"), ("P=1e-3:1e9:log:25", "mu=0:2:4")]
)
def test_a_part_of_a_basis_gives_the_spectra_of_the_whole_along_a_line(fields, monkeypatch):
    """Lines of friction, and of stiffness over decades."""
    monkeypatch.setattr("cea.reduced.model._SMALLER", 0.95)  # else the basis is too small for it
    scene = mapped("blocks", read_fields(fields), sine_blocks("iga", *TOP[1:]))
    low, high = (scene.point(end) for end in zip(*scene.points.ends, strict=True))
    box = {name: (low[name], high[name]) for name in low}
    model = ReducedModel(scene.pencil, box, scene.window.max_frequency)
    every = [scene.point(values) for values in scene.points.values.tolist()]
    Enrichment(model, scene.driver).cover(every[::7], 1e-9)
    sizes = set()
    for line in scene.points.parts:
        points = [every[i] for i in line]
        spectra = SpectraAlong(model, points)
        for point in points:
            (found, part), whole = spectra.at(point), model.at(point)
            sizes.add(len(part.forces) / model.size)
            assert len(found) == len(whole)
            assert (np.abs(found.z - whole.z) <= found.errors + whole.errors).all()
            assert found.worst <= 1e-8 or part is model
            shapes = part.shapes(found).conj() * model.shapes(whole)
            apart = np.ptp(found.clusters) + 1 == len(found)
            assert not apart or np.abs(shapes.sum(axis=0)).min() > 1 - 1e-6
    assert min(sizes) < 0.95


def test_values_and_slopes_are_those_of_full_solves(made):
    swept, backend, folder = made
    scene = mapped("blocks", read_fields(MAP), sine_blocks(backend, *TOP))
    data, points, spectra = swept.record, swept.points, swept.spectra
    assert data["certified"] == data["values"] == 84
    assert len(data["vectors"]) == 1
    assert len(data["snapshots"]) < 14
    with xarray.open_dataset(folder / "sweep.nc", engine="h5netcdf") as stored:
        assert dict(stored.sizes)["mu"] == 21
        assert stored.growth.attrs["units"] == "1/s"
        at = stored.isel(mu=3, P=2).growth.values
        np.testing.assert_array_equal(at, spectra.growth[3 * 4 + 2])
    for i in (13 * 4 + 1, *RNG.integers(0, 84, 4)):
        there = spectra.there[i]
        modes = scene.driver.solve(0.42, scene.point(points.values[i]), left=True)
        rows, columns = assert_within_bounds(swept, i, modes)
        assert (spectra.mean_error[i][there] < 1e-8).all()
        if i != 13 * 4 + 1:  # where none coalesce
            continue
        for field, name in enumerate((MU, P)):
            slope = spectra.growth_slope[i][there, field]
            slope = slope + 2j * np.pi * spectra.frequency_slope[i][there, field]
            expected = modes.sensitivity(name)
            off = np.abs(slope[rows] - expected[columns])
            bound = 1e-4 * np.abs(expected[columns]) + 1e-7 * np.abs(expected).max()
            assert (off < bound).all()


def test_thresholds_of_a_map_are_those_of_full_solves(made):
    swept, _, folder = made
    data, again = swept.record, read_sweep(folder)
    assert again.record["thresholds"] == data["thresholds"]
    np.testing.assert_array_equal(again.spectra.growth, swept.spectra.growth)
    assert any(each["kind"] == "flutter" and each["change"] > 0 for each in data["thresholds"])
    assert not data["unresolved"]
    confirmed = [each for each in data["thresholds"] if "full_solve_differs" in each]
    assert confirmed
    for each in confirmed:
        assert abs(each["full_solve_differs"]) < min(1e-8, each["error"] + 1e-11)


@pytest.mark.slow
def test_a_sweep_that_is_killed_goes_on_where_it_was(tmp_path):
    """SIGKILL once three full solves are stored: all of them serve again."""
    out = tmp_path / "out"
    settings = [part for each in sine_blocks("iga", *TOP) for part in ("--set", each)]
    line = "sweep blocks mu=0:2:21 P=0.01:5e4:log:9 --checks 1 --confirm 0"
    words = [Path(sys.executable).with_name("cea"), *line.split(), *settings, "--out", out]
    running = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    third = tmp_path / "out.unfinished" / "solve-0002.rank0"
    begun = monotonic()
    while not third.exists() and running.poll() is None and monotonic() - begun < 120:
        sleep(0.005)
    running.send_signal(signal.SIGKILL)
    running.wait()
    assert third.exists()
    assert not (out / "result.json").exists()
    stored = len(list(third.parent.glob("solve-*")))
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    data = json.loads((out / "result.json").read_text())
    assert data["stored_before"] == stored
    assert data["certified"] == data["values"]
    assert not third.parent.exists()


def test_what_was_solved_before_an_interruption_is_not_solved_again(tmp_path):
    """Full solves, those that tested the map too, and finished lines serve again."""
    wanted = asked("iga", "mu=0:2:3", "P=0.005:50:log:5", checks=3, confirm=0)
    work = list[str](), list[str]()
    first, again = (run(wanted, tmp_path / "out", steps.append) for steps in work)
    assert sum("lines" in step for step in work[0]) >= 5
    assert not work[1]
    again.store.discard()
    assert again.record["stored_before"] == len(first.record["snapshots"]) > 3
    assert again.record["snapshots"] == first.record["snapshots"]
    np.testing.assert_array_equal(again.spectra.growth, first.spectra.growth)


def test_the_fingerprint_of_a_changed_scene_is_another(backend):
    marks = []
    for more in ((), (), ("bodies.lower.material.E=1.5",), (f"{WAY}={{vector=[-1.0,0.0]}}",)):
        scene = mapped("blocks", [read_axis("mu=0:1:3")], sine_blocks(backend, *TOP, *more))
        marks.append("\n".join(fingerprint(scene)))
        scene.driver.free()
    assert marks[0] == marks[1]
    assert len(set(marks)) == 3


def test_what_is_left_uncertified_is_told(tmp_path):
    few = asked("iga", "mu=0:2:5", "P=0.01:5e4:log:5", most=2, checks=0, confirm=0)
    swept = run(few, tmp_path / "out")
    data = swept.record
    assert len(data["snapshots"]) == 2
    assert data["certified"] < data["values"]
    assert "not-certified" in [each["kind"] for each in data["warnings"]]
    assert swept.spectra.bound.max() == data["worst"] > 1e-8


def test_doublets_begin_to_flutter_with_friction_itself(tmp_path):
    coarse = [
        f"bodies.{name}.mesh.iga={{degree=[2,2],elements=[2,12]}}" for name in ("outer", "inner")
    ]
    words = (*coarse, "analysis.max_frequency=0.3", "analysis.growth_threshold=0.0")
    wanted = Asked("drum", (read_axis("mu=0:0.5:3"),), words, confirm=9)
    data = run(wanted, tmp_path / "out").record
    assert not data["unresolved"]
    at_once = [each for each in data["thresholds"] if each["value"] == 0]
    assert at_once
    for each in at_once:
        assert each["change"] > 0
        assert 0 < each["error"] < 1e-6
        assert abs(each["full_solve_differs"]) < each["error"]


@pytest.mark.grid
@pytest.mark.parametrize("name", ["sweep", "threshold"])
def test_the_commands_run_on_a_backend(name, backend, tmp_path, cea):
    coarse = (*plane_meshes(backend, 2, MESHES[backend]), "analysis.max_frequency=0.3")
    settings = [part for each in coarse for part in ("--set", each)]
    chosen = ["--backend", backend, *settings, "--out", tmp_path / "out"]
    code, _, fault = cea(name, "blocks", "mu=0:0.2:3", *chosen)
    assert not code, fault
    found = json.loads((tmp_path / "out" / "result.json").read_text())
    assert f'bodies.upper.backend="{backend}"' in found["inputs"]["set"]
    picture = tmp_path / "out" / "sweep.png"
    assert picture.exists()
    assert "sweep.png" in (tmp_path / "out" / "report.html").read_text()
    if name == "sweep":
        picture.unlink()
        code, _, fault = cea(name, "blocks", "mu=0:0.2:3", "--redraw", "--out", tmp_path / "out")
        assert picture.exists(), fault


def test_maps_that_are_none_are_refused():
    for twice in ("mu=0:1:5", f"{MU}=0:1:3"):
        with pytest.raises(InputError, match="other parameters than mu"):
            mapped("blocks", [read_axis("mu=0:1:3"), read_axis(twice)])
    with pytest.raises(InputError, match="zero or positive"):
        mapped("blocks", [read_axis("mu=-1:1:3")])
    modal = "bodies.upper.damping={modal={ratio=0.01,max_frequency=0.4}}"
    with pytest.raises(NoMapError, match="modal damping"):
        mapped("blocks", [read_axis("bodies.upper.material.E=1:2:3")], (modal,))


def stiff_sweep(backend, axis, out, *overrides):
    """A sweep, and its scene."""
    bodies = (f"bodies.{name}.backend='{backend}'" for name in ("base", "mid", "cap"))
    overrides = (*bodies, *overrides)
    made = sweep_of(BONDED, [axis], out / "out", overrides, checks=1, confirm=9)
    return made, load_scene(BONDED, overrides)


DAMPED = "bodies.cap.damping={alpha=0.02,modal={ratio=0.01,max_frequency=0.4}}"


SLOW = [("contacts.low.P=1e-1:1e13:log:4",), ("contacts.low.mu=0:0.8:4", TIED)]
CASES = [
    ("contacts.tie.P=1e-1:1e13:log:4",),
    ("contacts.low.P=1e-1:1e13:log:3", DAMPED),
    ("bodies.cap.damping.modal.ratio=0.005:0.04:3", DAMPED),
]


@pytest.mark.parametrize(
    ("backend", "case"),
    [
        *covering(["fe", "iga"], CASES, strength=1),
        *(pytest.param("fe", case, marks=pytest.mark.slow) for case in SLOW),
    ],
)
def test_fresh_runs_lie_within_the_bounds_of_stiff_tied_and_damped_scenes(tmp_path, backend, case):
    assert_fresh_runs_within_bounds(backend, tmp_path, *case)


def assert_fresh_runs_within_bounds(backend, out, axis, *overrides):
    """Runs at every value of a sweep, which is returned with its scene."""
    made, scene = stiff_sweep(backend, axis, out, *overrides)
    assert made.record["certified"] == made.record["values"]
    assert made.spectra.bound.max() < 1e-6
    for i, value in enumerate(made.record["axes"][0]["values"]):
        modes = run_modes(scene.change(axis.partition("=")[0], value)).modes
        rows, _ = assert_within_bounds(made, i, modes)
        assert len(rows) == len(modes.eigenvalues)
    for each in made.record["thresholds"]:
        assert abs(each["full_solve_differs"]) <= each["error"] + 1e-9 * each["value"]
    return made, scene


def test_tied_contacts_have_thresholds(tmp_path):
    axis = "contacts.low.P=1e-1:1e6:log:6"
    made, scene = assert_fresh_runs_within_bounds("fe", tmp_path, axis, TIED)
    assert made.record["thresholds"]
    assert not made.record["unresolved"]
    for each in made.record["thresholds"]:
        change = 0
        for way in (-1, 1):
            at = run_modes(scene.change("contacts.low.P", each["value"] * (1 + way * 1e-6)))
            change += way * (at.growth_rates > 10 * at.modes.growth_uncertainties).sum()
        assert change * 2 == each["change"] or each["kind"] != "flutter"
