"""Maps: ``cea sweep`` over parameters of a pencil, its files, and interruptions of it."""

import json
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest
import xarray
from reference_data import plane_meshes

from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.eigen.pencil import Pencil
from cea.errors import InputError
from cea.reduced.full_solves import first_threshold
from comparisons.cli.app import main
from comparisons.sweep.axes import Axis, read_axis
from comparisons.sweep.map_page import write_result
from comparisons.sweep.map_study import AskedMap, run_map
from comparisons.sweep.map_tables import modes_table, summary_table, thresholds_table, values_table
from comparisons.sweep.mapped import NoMapError, mapped
from comparisons.sweep.netcdf import read_map
from comparisons.sweep.sensitivities import sensitivities_table
from comparisons.sweep.study import Sweep, run_sweep
from scenes.running.swept import parameters_meant

MESHES = {
    "fe": {"upper": [8, 2], "lower": [5, 3]},
    "iga": {"upper": [10, 2], "lower": [7, 3]},
}
COARSE_PAD = (
    "bodies.pad.mesh.iga.elements=[3,6,2]",
    "bodies.disc.mesh.iga.elements=[5,32,1]",
)
MU, P = "contacts.interface.mu", "contacts.interface.P"
RNG = np.random.default_rng(5)


def overrides(backend):
    """The blocks with friction that flutters at mu0 below one, on coarse meshes."""
    return (
        "contacts.interface.mu='sin(pi*x/2)'",
        "analysis.max_frequency=0.4",
        "analysis.growth_threshold=0.0",
        *(f"bodies.{name}.backend='{backend}'" for name in ("upper", "lower")),
        *plane_meshes(backend, 2, MESHES[backend]),
    )


def asked(backend, *axes, **options):
    return AskedMap("blocks", tuple(map(read_axis, axes)), overrides(backend), **options)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A map for each backend, made once."""
    known = {}

    def of(backend):
        if backend not in known:
            folder = tmp_path_factory.mktemp("map") / "out"
            wanted = asked(backend, "mu=0:2:21", "P=0.5:500:log:4")
            data, rows, store = run_map(wanted, folder)
            write_result(data, rows, folder)
            store.discard()
            known[backend] = wanted, data, rows, folder
        return known[backend]

    return of


@pytest.mark.grid(quick=1)
def test_values_of_a_map_are_those_of_full_solves(made, backend):
    wanted, data, _, folder = made(backend)
    assert data["certified"] == data["values"] == 84
    assert len(data["snapshots"]) < 12
    scene = mapped(wanted.scene, wanted.axes, wanted.overrides, None)
    with xarray.open_dataset(folder / "sweep.nc", engine="h5netcdf") as stored:
        assert dict(stored.sizes)["mu"] == 21
        assert stored.growth.attrs["units"] == "1/s"
        for i, j in zip(RNG.integers(0, 21, 4), RNG.integers(0, 4, 4), strict=True):
            at = stored.isel(mu=i, P=j)
            there = np.isfinite(at.growth.values)
            found = at.growth.values[there] + 2j * np.pi * at.frequency.values[there]
            modes = scene.driver.solve(0.42, scene.point((float(at.mu), float(at.P))))
            rows, columns = assign(np.abs(found[:, None] - modes.eigenvalues))
            assert len(rows) == len(found)
            off = np.abs(found[rows] - modes.eigenvalues[columns])
            assert (off <= at.uncertainty.values[there] + modes.growth_uncertainties[columns]).all()
            means = at.mean_error.values[there] < 1e-8
            assert means.all()
    scene.driver.free()


@pytest.mark.grid(quick=1)
def test_thresholds_of_a_map_are_those_of_full_solves(made, backend):
    wanted, data, rows, _ = made(backend)
    scene = mapped(wanted.scene, wanted.axes, wanted.overrides, None)
    begun = [
        each for each in data["thresholds"] if each["kind"] == "flutter" and each["change"] > 0
    ]
    assert begun
    assert len(thresholds_table(data).rows) == sum(len(row.thresholds) for row in rows)
    assert not data["unresolved"]
    confirmed = [
        each["full_solve_differs"] for each in data["thresholds"] if "full_solve_differs" in each
    ]
    assert confirmed
    assert np.abs(confirmed).max() < 1e-8
    chosen = begun[len(begun) // 2]
    pencil = scene.pencil
    parameters = [
        replace(each, value=chosen["P"]) if each.name == P else each
        for each in pencil.parameters.values()
    ]
    driver = EigenSolver(Pencil(pencil.terms, parameters, pencil.forces, leave_out=False))
    near = (0.999 * chosen["value"], 1.001 * chosen["value"])
    expected = first_threshold(
        driver, MU, *near, max_frequency=0.4, frequency=chosen["im"] / (2 * np.pi)
    )
    assert chosen["value"] == pytest.approx(expected.value, rel=1e-8)
    assert abs(chosen["value"] - expected.value) <= chosen["error"] + 1e-11
    driver.free()


@pytest.mark.grid(quick=1)
def test_sensitivities_of_a_map_are_those_of_full_solves(made, backend):
    """Of every mode in both parameters, where none coalesce."""
    wanted, data, rows, _ = made(backend)
    scene = mapped(wanted.scene, wanted.axes, wanted.overrides, None)
    row, others, i = rows[1], scene.rows()[1], 13
    point = scene.point((wanted.axes[0].values[i], *others))
    modes = scene.driver.solve(scene.max_frequency, point, left=True)
    there = np.isfinite(row.growth[i])
    found = row.growth[i][there] + 2j * np.pi * row.frequency[i][there]
    ours, theirs = assign(np.abs(found[:, None] - modes.eigenvalues))
    assert len(ours) == there.sum()
    for axis, name in enumerate((MU, P)):
        slope = row.growth_slope[i][there, axis] + 2j * np.pi * row.frequency_slope[i][there, axis]
        expected = modes.sensitivity(name)
        off = np.abs(slope[ours] - expected[theirs])
        assert (off < 1e-4 * np.abs(expected[theirs]) + 1e-7 * np.abs(expected).max()).all()
    table = sensitivities_table(data, rows)
    assert len(table.rows) == sum((each.verdict == 1).any(axis=1).sum() for each in rows)
    scene.driver.free()


@pytest.mark.grid(quick=1)
def test_branches_keep_their_numbers_along_a_row(made, backend):
    _, _, rows, _ = made(backend)
    for row in rows:
        first, last = row.branch[0], row.branch[-1]
        assert len(np.intersect1d(first[first >= 0], last[last >= 0])) >= 3
        for before, after, numbers, others in zip(
            row.frequency[:-1], row.frequency[1:], row.branch[:-1], row.branch[1:], strict=True
        ):
            same, i, j = np.intersect1d(numbers, others, return_indices=True)
            real = same >= 0
            assert (np.abs(before[i] - after[j])[real] < 0.05).all()


@pytest.mark.slow
def test_a_map_leaves_tables_and_pictures_that_are_drawn_anew(made, backend, monkeypatch, capsys):
    _, data, rows, folder = made(backend)
    names = {"sweep.nc", "sweep.csv", "thresholds.csv", "full_solves.csv", "modes.csv", "map.png"}
    assert names <= {file.name for file in folder.iterdir()}
    assert len(values_table(data, rows).rows) == 84
    assert len(modes_table(data, rows).rows) == sum((row.branch >= 0).sum() for row in rows)
    assert dict(summary_table(data).rows)["values"] == 84
    again = read_map(data, folder / "sweep.nc")
    for one, other in zip(again, rows, strict=True):
        width = other.growth.shape[1]
        np.testing.assert_array_equal(one.growth[:, :width], other.growth)
        np.testing.assert_array_equal(one.branch[:, :width], other.branch)
        assert one.thresholds == other.thresholds
    (folder / "map.png").unlink()
    axes = ["mu=0:2:21", "P=0.5:500:log:4"]
    command = ["cea", "sweep", "blocks", *axes, "--redraw", "--out", str(folder)]
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code, capsys.readouterr().err
    assert (folder / "map.png").exists()


@pytest.mark.slow
def test_a_sweep_that_is_killed_goes_on_where_it_was(tmp_path):
    """SIGKILL once three full solves are stored: all of them serve again."""
    out = tmp_path / "out"
    settings = [part for each in overrides("iga") for part in ("--set", each)]
    command = [
        Path(sys.executable).with_name("cea"),
        *("sweep", "blocks", "mu=0:2:21", "P=0.01:5e4:log:9", "--checks", "1", "--confirm", "0"),
        *settings,
        *("--out", out),
    ]
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    third = tmp_path / "out.unfinished" / "snapshot-0002.json"
    begun = monotonic()
    while not third.exists() and running.poll() is None and monotonic() - begun < 120:
        sleep(0.005)
    running.send_signal(signal.SIGKILL)
    running.wait()
    assert third.exists()
    assert not (out / "result.json").exists()
    stored = len(list(third.parent.glob("snapshot-*.json")))
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    data = json.loads((out / "result.json").read_text())
    assert data["stored_before"] == stored
    assert data["certified"] == data["values"]
    assert not third.parent.exists()


def test_what_was_solved_before_an_interruption_is_not_solved_again(tmp_path):
    """Full solves that tested the map least of all: they are at the same random values."""
    wanted = asked("iga", "mu=0:2:7", "P=0.5:50:log:3", checks=3, confirm=0)
    first, before, _ = run_map(wanted, tmp_path / "out")
    again, after, store = run_map(wanted, tmp_path / "out")
    store.discard()
    assert again["stored_before"] == len(first["snapshots"]) > 3
    assert again["snapshots"] == first["snapshots"]
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one.growth, other.growth)


def test_the_command_threshold_confirms_what_it_finds(tmp_path, monkeypatch, capsys):
    chosen = (*overrides("iga"), "contacts.interface.p=0.25")
    settings = [part for each in chosen for part in ("--set", each)]
    out = str(tmp_path / "out")
    command = ["cea", "threshold", "blocks", "mu=0:1.2:13", *settings, "--out", out]
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code, capsys.readouterr().err
    found = json.loads((tmp_path / "out" / "result.json").read_text())["thresholds"]
    assert found
    assert all(abs(each["full_solve_differs"]) < 1e-8 for each in found)


def test_one_axis_gives_branches_and_a_root_locus(tmp_path):
    data, rows, store = run_map(asked("iga", "mu=0:2:11", checks=0, confirm=0), tmp_path / "out")
    page = write_result(data, rows, tmp_path / "out")
    store.discard()
    assert page.name == "report.html"
    for name in ("sweep.png", "sensitivities.png"):
        assert (page.parent / name).exists()
        assert name in page.read_text()
    assert len(rows) == 1


def test_what_is_left_uncertified_is_told(tmp_path):
    few = asked("iga", "mu=0:2:5", "P=0.01:5e4:log:5", most=2, checks=0, confirm=0)
    data, rows, store = run_map(few, tmp_path / "out")
    store.discard()
    assert len(data["snapshots"]) == 2
    assert data["certified"] < data["values"]
    assert "not-certified" in [each["kind"] for each in data["warnings"]]
    assert max(row.bound.max() for row in rows) == data["worst"] > 1e-8


@pytest.mark.parametrize(
    "text",
    ["mu", "mu=0", "mu=0:1", "mu=0:1:x", "mu=a:1:3", "=0:1:3", "mu=0:1:lin:3", "mu=0:1:3:4:5"],
)
def test_texts_that_are_no_axis_are_refused(text):
    with pytest.raises(InputError, match="first:last:count"):
        read_axis(text)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"last": 0.0}, "another last value"),
        ({"count": 1}, "2 to"),
        ({"last": np.inf}, "finite"),
        ({"logarithmic": True}, "positive"),
    ],
)
def test_axes_that_are_none_are_refused(changes, told):
    with pytest.raises(InputError, match=told):
        Axis(**{"name": "mu", "first": 0.0, "last": 1.0, "count": 3} | changes)


def test_axes_that_are_no_parameters_are_refused_or_solved_in_full():
    with pytest.raises(NoMapError, match="one of"):
        mapped("blocks", [read_axis("analysis.max_frequency=0.1:0.3:3")], (), None)
    modal = "bodies.disc.damping={modal={ratio=0.01,max_frequency=2000.0}}"
    axis = read_axis("bodies.disc.material.E=1e11:2e11:3")
    with pytest.raises(NoMapError, match="modes were found that are damped"):
        mapped("disc_pad_damped", [axis], (*COARSE_PAD, modal), None)
    with pytest.raises(InputError, match="other parameters than mu"):
        mapped("blocks", [read_axis("mu=0:1:3"), read_axis(f"{MU}=0:1:3")], (), None)
    with pytest.raises(InputError, match="zero or positive"):
        mapped("blocks", [read_axis("mu=-1:1:3")], (), None)


def test_a_field_without_a_map_is_solved_in_full(tmp_path, monkeypatch, capsys):
    settings = ["--set", "analysis.max_frequency=0.3", "--out", str(tmp_path / "out")]
    axis = "bodies.upper.material.nu=0.2:0.3:2"
    monkeypatch.setattr(sys, "argv", ["cea", "sweep", "blocks", axis, *settings])
    with pytest.raises(SystemExit) as end:
        main()
    told = capsys.readouterr()
    assert not end.value.code, told.err
    assert "Solved in full at each value: parameter = 'bodies.upper.material.nu'" in told.out


def test_short_names_are_solved_in_full_too():
    both = tuple(f"bodies.{name}.material.E=2.0" for name in ("upper", "lower"))
    ends = [run_sweep(Sweep("blocks", "E", 1.0, 2.0, 2, overrides("iga")))["points"][1]]
    ends.append(run_sweep(Sweep("blocks", MU, 1.0, 2.0, 2, overrides("iga") + both))["points"][0])
    modes = [[complex(mode["re"], mode["im"]) for mode in end["modes"]] for end in ends]
    np.testing.assert_allclose(*modes, rtol=1e-9)


def test_doublets_begin_to_flutter_with_friction_itself(tmp_path):
    coarse = [
        f"bodies.{name}.mesh.iga={{degree=[2,2],elements=[2,12]}}" for name in ("outer", "inner")
    ]
    wanted = AskedMap(
        "drum",
        (read_axis("mu=0:0.5:3"),),
        (*coarse, "analysis.max_frequency=0.3", "analysis.growth_threshold=0.0"),
        confirm=9,
    )
    data, _, _ = run_map(wanted, tmp_path / "out")
    assert not data["unresolved"]
    at_once = [each for each in data["thresholds"] if each["value"] == 0]
    assert at_once
    for each in at_once:
        assert each["change"] > 0
        assert 0 < each["error"] < 1e-6
        assert abs(each["full_solve_differs"]) < each["error"]


def test_warnings_of_full_solves_reach_the_map(tmp_path):
    """Collocation where the contact is soft, at every full solve that is told of it."""
    soft = asked("iga", "mu=0:0.5:3", "P=0.1:1:2", checks=0, confirm=0)
    crude = "contacts.interface.formulation={method='greville'}"
    soft = replace(soft, overrides=(*soft.overrides, crude))
    data, _, store = run_map(soft, tmp_path / "out")
    store.discard()
    told = {each["kind"]: each for each in data["warnings"]}
    assert set(told) == {"point-rule"}
    places = told["point-rule"]["data"]["places"]
    assert len(places) == len(data["snapshots"])
    for place in places:  # it is judged at the stiffness there
        assert place["data"]["stiffness"] == pytest.approx(3 * place["point"][P])
    given = [each["kind"] for solve in data["snapshots"] for each in solve["warnings"]]
    assert set(told) == set(given)


def test_short_names_mean_every_contact_and_body():
    scene = mapped("blocks", [read_axis("E=1:2:3"), read_axis("P=1:2:3")], (), None)
    both = ("bodies.upper.material.E", "bodies.lower.material.E")
    assert scene.names == (dict.fromkeys(both, 1.0), {P: 1.0})
    assert parameters_meant(scene.pencil, "bodies.*.material.rho") == [
        "bodies.upper.material.rho",
        "bodies.lower.material.rho",
    ]
    assert scene.point((1.5, 7.0)) == dict.fromkeys(scene.names[0], 1.5) | {P: 7.0}
    assert scene.box[P] == (1.0, 2.0)
    scene.driver.free()


def test_a_contact_that_becomes_too_stiff_for_a_penalty_keeps_its_forces():
    points = ("contacts.interface.formulation={method='gpts',points=3}",)
    soft = mapped("blocks", [read_axis("P=0.1:1:3")], points, None)
    assert not soft.pencil.forces
    stiff = mapped("blocks", [read_axis("P=0.1:1e12:log:3")], points, None)
    assert stiff.pencil.forces
    for each in (soft, stiff):
        each.driver.free()
