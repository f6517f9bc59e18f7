"""Commands on matrices from files: one run, a sweep, a race with scipy."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from external_data import external
from matrix_files import dense, inside, pieces, scene, write
from scipy.io import mmwrite
from scipy.linalg import eig
from scipy.sparse import csr_array

from cea.errors import ConvergenceError, InputError
from comparisons.bench import matrices
from comparisons.cli.app import main
from comparisons.study.run import run
from comparisons.sweep import page as sweep_page
from comparisons.sweep.page import read_sweep, write_sweep
from comparisons.sweep.study import Curves, Sweep, curves_of, run_sweep
from comparisons.sweep.tables import unstable_table, values_table
from scenes.spec.problems import SceneError

STORED = Path(sweep_page.__file__).with_name("results")
PUBLISHED = """
    119.2 74.83 5.474 0.5738 9.587e-5 -0.04333 -1.122 -1.433 -1.834 -1.913 -2.367 -3.983 -6.571
"""
"""Growth rates of the brake at 2 turns a second."""
SPEEDS = [1.0, 1.5, 2.0, 2.5, 3.0]


def cea(*arguments):
    return subprocess.run(
        [Path(sys.executable).with_name("cea"), *map(str, arguments)],
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Files of matrices, and a scene of them that lies elsewhere."""
    folder = write(tmp_path_factory.mktemp("matrices"), pieces())
    (folder / "elsewhere").mkdir()
    (folder / "elsewhere" / "speed.toml").write_text(toml_of(scene()))
    return folder


def toml_of(data):
    """A scene of matrices as TOML."""
    lines = [f"name = {json.dumps(data['name'])}"]
    for name in ("files", "parameters", "mass", "damping", "stiffness", "analysis"):
        lines += [f"[{name}]", *(f"{k} = {json.dumps(v)}" for k, v in data[name].items())]
    return "\n".join(lines)


@pytest.fixture(scope="module")
def swept(folder):
    toml = folder / "elsewhere" / "speed.toml"
    return run_sweep(Sweep(toml, "parameters.v", 1.0, 3.0, 5, data=str(folder)))


def test_solve_takes_matrices_and_writes_a_result(folder, tmp_path):
    made = pieces()
    for name, matrix in {"C": made["D"] + made["G"], "K": made["K"] + made["F"]}.items():
        mmwrite(tmp_path / f"{name}.mtx", csr_array(matrix), precision=17)
    files = ["--mass", folder / "M.mtx", "--stiffness", tmp_path / "K.mtx"]
    files += ["--damping", tmp_path / "C.mtx"]
    window = ["--max-frequency", 0.6, "--min-growth", -1.0, "--growth-threshold", 0.01]
    done = cea("solve", *files, *window, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "left out, not needed: " in done.stdout
    assert "pictures" in done.stdout.partition("left out, not needed: ")[2].splitlines()[0]
    assert done.stdout.startswith("▲ solve: ")
    stored = json.loads((tmp_path / "result.json").read_text())
    found = np.array([v["re"] + 1j * v["im"] for v in stored["eigenvalues"]])
    M, K = made["M"], made["K"] + made["F"]
    one, zero = np.eye(len(M)), np.zeros_like(M)
    left = np.block([[zero, one], [-K, -made["D"] - made["G"]]])
    true = inside(eig(left, np.block([[one, zero], [zero, M]]))[0])
    np.testing.assert_allclose(found, true, rtol=1e-9)
    assert stored["inputs"]["min_growth"] == -1.0
    assert stored["verdict"] == "unstable"


def test_run_takes_a_scene_with_its_folder_and_settings(folder, tmp_path):
    toml = folder / "elsewhere" / "speed.toml"
    options = ["--data", folder, "--set", "parameters.v=pi - 2", "--out", tmp_path]
    done = cea("run", toml, *options)
    assert done.returncode == 0, done.stderr
    stored = json.loads((tmp_path / "result.json").read_text())
    found = np.array([v["re"] + 1j * v["im"] for v in stored["eigenvalues"]])
    np.testing.assert_allclose(found, inside(dense(pieces(), np.pi - 2)), rtol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "field", "told"),
    [
        (["solve", "--mass", "no.mtx", "--stiffness", "no.mtx", "--max-frequency", "1"], "files.M",
         "there is none"),
        (["solve", "--mass", "a", "--stiffness", "b", "--max-frequency", "-1"],
         "analysis.max_frequency", "greater than 0"),
        (["run", "tu_berlin"], "data", "does not come with the project"),
        (["run", "tu_berlin", "--data", "nowhere"], "files.M", "there is none"),
        (["run", "tu_berlin", "--data", "x", "--set", "parameters.Omega=0"], "damping.DR",
         "finite value"),
        (["run", "tu_berlin", "--data", "x", "--set", "damping.DG=Omega^2"], "damping.DG", "**"),
        (["run", "tu_berlin", "--data", "x", "--backend", "fe"], "backend", "no bodies"),
        (["run", "disc", "--data", "x"], "data", "reads no matrices"),
        (["sweep", "disc", "bodies.disc.material.E=1:1:3"], "bodies.disc.material.E",
         "another last value"),
        (["sweep", "disc", "bodies.disc.material.E", "1", "3"], "axis", "first:last:count"),
        (["bench", "matrices", "--scene", "disc"], "scene", "a scene of matrices"),
    ],
)  # fmt: skip
def test_faults_are_told_in_a_line(arguments, field, told, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["cea", *arguments, "--out", str(tmp_path)])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 1
    first = capsys.readouterr().err.splitlines()[0]
    assert first.startswith(f"error: {field} = ")
    assert told in first
    assert not (tmp_path / "result.json").exists()


def test_a_sweep_finds_at_each_value_what_lapack_finds(swept):
    assert [point["value"] for point in swept["points"]] == SPEEDS
    for point in swept["points"]:
        found = [mode["re"] + 1j * mode["im"] for mode in point["modes"]]
        np.testing.assert_allclose(found, inside(dense(pieces(), point["value"])), rtol=1e-9)
        assert point["failed"] == ""
    assert swept["command"] == "sweep"


def test_what_a_sweep_leaves_behind_is_drawn_anew(swept, tmp_path, monkeypatch, capsys):
    picture = write_sweep(swept, tmp_path)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert read_sweep(tmp_path)["points"] == swept["points"]
    with (tmp_path / "modes.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == sum(len(point["modes"]) for point in swept["points"])
    picture.unlink()
    given = swept["inputs"]
    axis = "{field}={start}:{stop}:{points}".format(**given)
    asked = [given["scene"], axis]
    options = ["--redraw", "--out", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["cea", "sweep", *asked, *options])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code
    assert picture.exists()
    capsys.readouterr()
    for arguments, field in (
        ([asked[0], axis.replace("parameters.v", "parameters.mu")], "field"),
        ([asked[0], axis.replace(":3.0:", ":17.5:")], "stop"),
        ([*asked, "--data", "x"], "data"),
    ):
        monkeypatch.setattr(sys, "argv", ["cea", "sweep", *arguments, *options])
        with pytest.raises(SystemExit):
            main()
        assert capsys.readouterr().err.startswith(f"error: {field} = ")


def test_terminals_without_letters_for_marks_end_no_run(tmp_path):
    for name, matrix in {"M": np.eye(2), "K": np.array([[4.0, 1.0], [-1.0, 4.0]])}.items():
        mmwrite(tmp_path / f"{name}.mtx", csr_array(matrix))
    files = ["--mass", tmp_path / "M.mtx", "--stiffness", tmp_path / "K.mtx"]
    arguments = ["solve", *files, "--max-frequency", "1", "--out", tmp_path]
    done = subprocess.run(
        [Path(sys.executable).with_name("cea"), *map(str, arguments)],
        capture_output=True,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"? solve: 2 modes up to 1 Hz: 1 unstable")


def test_unstable_curves_are_told_with_where_they_are(swept):
    rows = unstable_table(swept).rows
    assert rows
    for frequency, first, last, count, growth, at in rows:
        near = [
            mode["re"]
            for point in swept["points"]
            if point["value"] == at
            for mode in point["modes"]
            if mode["im"] == pytest.approx(2 * np.pi * frequency)
        ]
        assert near == [growth]
        assert 1.0 <= first <= last <= 3.0
        assert count <= 5
    table = values_table(swept)
    fastest = [row[[column.name for column in table.columns].index("growth")] for row in table.rows]
    assert max(fastest) == max(row[4] for row in rows)


def test_curves_cross_without_changing_places():
    curves, t = Curves(), np.linspace(0, 1, 21)
    crossing = np.stack([1j * (1 + 0.3 * t), 1j * (1.3 - 0.3 * t)], axis=1)
    for i, values in enumerate(crossing):
        order = np.argsort(values.imag)
        numbers = curves.follow(values[order])
        if i != 10:  # they meet
            assert [numbers[k] for k in np.argsort(order)] == [0, 1]


def test_a_mode_that_enters_is_a_new_curve_and_one_that_leaves_ends():
    curves = Curves()
    assert curves.follow(np.array([1j, 2j])) == [0, 1]
    assert curves.follow(np.array([1.001j, 1.5j, 2.001j])) == [0, 2, 1]
    assert curves.follow(np.array([1.502j])) == [2]
    assert curves.follow(np.array([1.002j, 1.503j])) == [3, 2]
    curves.interrupt()
    assert curves.follow(np.array([1.503j])) == [4]
    assert curves.follow(np.array([], dtype=complex)) == []
    assert curves.follow(np.array([1j])) == [5]


def test_a_value_without_an_answer_is_told(folder, monkeypatch, tmp_path):
    asked = Sweep(
        folder / "elsewhere" / "speed.toml", "parameters.v", 1.0, 3.0, 3, data=str(folder)
    )
    assembled = asked.assembled()
    modes = assembled.modes

    def failing(changes):
        if changes["parameters.v"] == 2.0:
            raise ConvergenceError("no more digits")
        return modes(changes)

    monkeypatch.setattr(assembled, "modes", failing)
    monkeypatch.setattr(Sweep, "assembled", lambda _: assembled)
    data = run_sweep(asked)
    assert [point["failed"] for point in data["points"]] == ["", "no more digits", ""]
    before, after = ({m["curve"] for m in data["points"][i]["modes"]} for i in (0, 2))
    assert before
    assert not before & after
    assert values_table(data).rows[1][-1] == "no more digits"
    assert write_sweep(data, tmp_path).exists()


def test_scenes_of_bodies_are_swept_too():
    window = ("analysis.max_frequency=0.3",)
    data = run_sweep(Sweep("blocks", "contacts.interface.p", 1.0, 2.0, 2, window))
    low, high = (point["modes"][0]["im"] for point in data["points"])
    assert low < high
    assert set(curves_of(data)) == {mode["curve"] for mode in data["points"][0]["modes"]}


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"count": 1}, "points"),
        ({"count": 10**6}, "points"),
        ({"stop": 1.0}, "stop"),
        ({"start": np.nan}, "start"),
    ],
)
def test_sweeps_that_are_none_are_refused(changes, field):
    with pytest.raises(InputError, match=field):
        Sweep(**{"scene": "x", "field": "y", "start": 1.0, "stop": 2.0, "count": 3} | changes)


def test_a_field_that_is_none_is_refused(folder):
    toml = folder / "elsewhere" / "speed.toml"
    with pytest.raises(SceneError, match=r"files\.w"):
        run_sweep(Sweep(toml, "files.w", 1.0, 2.0, 2, data=str(folder)))
    with pytest.raises(SceneError, match="no such field"):
        run_sweep(Sweep(toml, "speed", 1.0, 2.0, 2, data=str(folder)))


def test_a_race_is_one_of_the_same_eigenvalues(folder):
    toml = str(folder / "elsewhere" / "speed.toml")
    options = matrices.Options(toml, data=str(folder), repeats=1)
    result = run(matrices.STUDY, options, folder / "out")
    assert result.failed().empty
    found = matrices.seconds(result)
    assert found["found"].tolist() == found["modes"].tolist() == 3 * [len(inside(dense(pieces())))]
    assert (found["processor"] > 0).all()
    undamped = scene() | {"damping": {}}
    for name in "DG":
        undamped["files"].pop(name)
    (folder / "undamped.toml").write_text(toml_of(undamped))
    with pytest.raises(InputError, match="damping"):
        matrices.loaded(matrices.Options(str(folder / "undamped.toml"), data=str(folder)))


def test_other_files_of_matrices_are_other_cases(tmp_path):
    write(tmp_path, pieces())
    (tmp_path / "speed.toml").write_text(toml_of(scene()))
    options = matrices.Options(str(tmp_path / "speed.toml"), data=str(tmp_path))
    before = list(matrices.cases(options))
    assert list(matrices.cases(options)) == before
    changed = {name: 2 * matrix for name, matrix in pieces().items()}
    write(tmp_path, changed)
    assert list(matrices.cases(options)) != before


@pytest.mark.slow
def test_the_brake_is_faster_than_five_runs_of_scipy(tmp_path):
    """By the processor's time, medians of three runs by turns in one process."""
    options = matrices.Options(data=str(external("tu_berlin_brake")))
    found = matrices.seconds(run(matrices.STUDY, options, tmp_path))
    assert found["found"].tolist() == [13, 13, 13]
    assert (found["relative"][1:] > 1).all()


def test_the_stored_sweep_of_the_brake_passes_through_what_is_published():
    """At 2 turns a second, the ninth of 25 values from 1 to 4."""
    data = read_sweep(STORED)
    assert data["inputs"]["data"] == "tu_berlin_brake"
    assert not any(point["failed"] for point in data["points"])
    values = [point["value"] for point in data["points"]]
    np.testing.assert_allclose(values, np.linspace(2, 8, 25) * np.pi, rtol=1e-15)
    growths = sorted(f"{mode['re']:.3e}" for mode in data["points"][8]["modes"])
    assert growths == sorted(f"{float(growth):.3e}" for growth in PUBLISHED.split())
    assert [row[2] for row in values_table(data).rows] == [4, *[5] * 8, *[6] * 10, *[7] * 6]
    assert len(unstable_table(data).rows) == 7


@pytest.mark.slow
def test_the_stored_sweep_of_the_brake_is_what_is_computed():
    data = str(external("tu_berlin_brake"))
    swept = run_sweep(Sweep("tu_berlin", "parameters.Omega", 2 * np.pi, 8 * np.pi, 4, data=data))
    for point, stored in zip(swept["points"], read_sweep(STORED)["points"][::8], strict=True):
        assert point["value"] == pytest.approx(stored["value"])
        found, true = (
            np.array([mode["re"] + 1j * mode["im"] for mode in each["modes"]])
            for each in (point, stored)
        )
        np.testing.assert_allclose(found, true, rtol=1e-11)


@pytest.mark.parametrize("option", ["--symmetric", "--no-symmetric"])
def test_solve_is_told_what_a_triangle_is(tmp_path, option):
    """Eigenvalues of [[2, 1], [., 1]]: (3 +- sqrt(5)) / 2 of both triangles, 2 and 1 of one."""
    mmwrite(tmp_path / "M.mtx", csr_array(np.eye(2)))
    mmwrite(tmp_path / "K.mtx", csr_array([[2.0, 1.0], [0.0, 1.0]]), symmetry="general")
    files = ["--mass", tmp_path / "M.mtx", "--stiffness", tmp_path / "K.mtx"]
    refused = cea("solve", *files, "--max-frequency", 1)
    assert refused.returncode
    assert "--symmetric" in refused.stderr
    done = cea("solve", *files, "--max-frequency", 1, option, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    stored = json.loads((tmp_path / "result.json").read_text())
    values = np.array([value["im"] for value in stored["eigenvalues"]])
    expected = [(3 - 5**0.5) / 2, (3 + 5**0.5) / 2] if option == "--symmetric" else [1, 2]
    np.testing.assert_allclose(np.sort(values**2), expected, rtol=1e-9)
