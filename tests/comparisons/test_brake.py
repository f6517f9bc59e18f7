"""The study of the ventilated brake on few elements: meshes matched, what is written."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from mpi import cea_on_ranks
from typer.testing import CliRunner

from cea.errors import InputError
from comparisons.brake.page import read_brake, write_brake
from comparisons.brake.study import SCENE, BrakeStudy, run_brake, scene_of_size
from comparisons.brake.tables import (
    damping_ratio,
    modes_table,
    runs_table,
    stiffness_table,
    unstable_modes,
    unstable_table,
)
from comparisons.cli.app import app, main
from comparisons.kit.progress import Progress
from scenes.memory import estimated_memory
from scenes.read import load_scene
from scenes.scene_error import SceneError

BODIES = ("disc", "lower_pad", "upper_pad")
ROUGH = BrakeStudy(
    sizes=(0.03, 0.025),
    stiffnesses=(5e13, 5e14),
    overrides=tuple(f"bodies.{name}.mesh.fe.degree=1" for name in BODIES),
    pictures=0,
)
"""Linear elements, of which 12,000 dofs hold all parts."""
PLAIN = replace(
    ROUGH,
    sizes=(0.04, 0.03),
    overrides=(
        *ROUGH.overrides,
        "bodies.disc.geometry={shape='annulus',inner_radius=0.08,outer_radius=0.18,bottom=0,top=0.035}",
        "bodies.disc.supports=[{surface='inner'}]",
        "contacts.lower.b=disc.bottom",
        "contacts.upper.b=disc.top",
    ),
)
"""A disc without vanes and holes, of a tenth of the dofs."""


def last_of(study, out):
    progress = Progress(step=lambda _: None, stage=lambda _: None)
    *before, last = run_brake(study, progress, out)
    assert [len(data["runs"]) for data in before] == [1]  # what is done is told mesh by mesh
    return last


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """The study on rough meshes."""
    return last_of(ROUGH, tmp_path_factory.mktemp("brake"))


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The study of the plain disc."""
    return last_of(PLAIN, tmp_path_factory.mktemp("plain"))


def test_every_run_is_in_the_warnings_of_the_record(plain):
    every = [*plain["runs"], *({"size": 0.04, **run} for run in plain["stiffnesses"])]
    given = {(run["size"], run["p"], kind) for run in every for kind in run["warnings"]}
    assert "short-modes" in {kind for _, _, kind in given}
    assert given == {
        (place["point"]["size"], place["point"]["p"], warning["kind"])
        for warning in plain["warnings"]
        for place in warning["data"]["places"]
    }


def test_the_brake_is_what_its_scene_says():
    scene = load_scene(SCENE)
    assert {contact.p for contact in scene.contacts.values()} == {5e13}
    assert {contact.mu for contact in scene.contacts.values()} == {0.3}
    assert scene.analysis.max_frequency == 9000
    directions = {contact.friction_direction_on_a for contact in scene.contacts.values()}
    assert len(directions) == 1  # both pads are pushed the same way round
    assert {b.mesh.fe.degree for b in scene.bodies.values()} == {2}


@pytest.mark.slow
def test_meshes_and_stiffnesses_are_all_run(result):
    assert [run["size"] for run in result["runs"]] == [0.03, 0.025]
    assert [run["p"] for run in result["stiffnesses"]] == [5e13, 5e14]
    for run in (*result["runs"], *result["stiffnesses"]):
        assert run["complete"]
        assert len(run["modes"]) > 20
        frequencies = [mode["frequency"] for mode in run["modes"]]
        assert frequencies == sorted(frequencies)
        assert frequencies[-1] <= 9000
    same, stiffer = (run["modes"][0]["frequency"] for run in result["stiffnesses"])
    assert same == result["runs"][0]["modes"][0]["frequency"] < stiffer
    assert same == pytest.approx(992, rel=2e-2)


@pytest.mark.slow
def test_modes_are_followed_over_the_meshes(result):
    table = modes_table(result)
    names = [column.name for column in table.columns]
    rows = [dict(zip(names, row, strict=True)) for row in table.rows]
    numbers = [int(n) for row in rows for n in row["modes"].split(", ")]
    assert sorted(numbers) == list(range(1, len(result["runs"][-1]["modes"]) + 1))
    paired = [row for row in rows if row["frequency_30mm"] is not None]
    assert len(paired) > 0.8 * len(rows)
    assert all(row["spread"] < 0.03 for row in paired)
    grows = [row for row in rows if row["verdict"] == "unstable"]
    assert all(row["damping_ratio"] < 0 for row in grows)


def test_partners_stay_one_row_whatever_they_were_before():
    """Two modes that meet on the finer mesh: their mean is compared with the mean before."""
    still = {"uncertainty": 0.0, "growth": 0.0, "verdict": "stable"}
    grows = {"frequency": 101.0, "uncertainty": 0.0, "growth": 3.0, "verdict": "unstable"}
    decays = grows | {"growth": -3.0, "verdict": "stable"}
    runs = [
        {"size": 0.2, "modes": [still | {"frequency": f} for f in (50.0, 100.0, 104.0)]},
        {"size": 0.1, "modes": [still | {"frequency": 49.0}, decays, grows]},
    ]
    groups = [{"first": [i], "second": [i], "assurance": 1.0} for i in range(3)]
    table = modes_table({"runs": runs, "matches": [{"groups": groups}]})
    assert [row[0] for row in table.rows] == ["1", "2, 3"]
    assert table.rows[1][1:4] == pytest.approx((102.0, 101.0, 1 / 101))
    assert table.rows[1][4:6] == (0.0, 3.0)
    assert table.rows[1][-1] == "unstable"


@pytest.mark.slow
def test_unstable_pairs_are_told_with_their_damping_ratio(result):
    rows = unstable_table(result).rows
    runs = [*result["runs"], result["stiffnesses"][1]]
    assert len(rows) == sum(len(unstable_modes(run)) for run in runs)
    assert rows, "the rough meshes have unstable pairs"
    for row in rows:
        assert row[3] > 1.0  # the threshold of the scene, 1/s
        assert row[4] == pytest.approx(-row[3] / (6.283185307 * row[2]), rel=1e-3)
    assert damping_ratio({"frequency": 100.0, "growth": 0.0}) == 0


def test_the_result_is_written_and_drawn_anew(plain, tmp_path):
    figure = write_brake(plain, tmp_path)
    assert read_brake(tmp_path)["runs"] == plain["runs"]
    for make in (runs_table, modes_table, unstable_table, stiffness_table):
        table = make(plain)
        assert (tmp_path / f"{table.name}.csv").read_text().count("\n") == len(table.rows) + 1
    figure.unlink()
    told = CliRunner().invoke(app, ["brake", "--redraw", "--out", str(tmp_path)])
    assert told.exit_code == 0, told.output
    assert figure.stat().st_size > 10_000


def test_options_of_a_run_are_refused_where_nothing_runs(plain, tmp_path, monkeypatch, capsys):
    write_brake(plain, tmp_path)
    for option in (["--size", "0.02"], ["--set", "contacts.*.mu=0.1"]):
        asked = ["cea", "brake", "--redraw", *option, "--out", str(tmp_path)]
        monkeypatch.setattr(sys, "argv", asked)
        with pytest.raises(SystemExit):
            main()
        assert capsys.readouterr().err.startswith(f"error: {option[0][2:]} = ")


@pytest.mark.slow
@pytest.mark.mpi
def test_two_ranks_find_what_one_finds(result, tmp_path):
    overrides = [f"--set={override}" for override in ROUGH.overrides]
    done = cea_on_ranks(2, "brake", "--size", "0.03", *overrides, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("The figure to open: ") == 1
    found = read_brake(tmp_path)
    ours, theirs = (
        {run["p"]: run for run in (*each["runs"], *each["stiffnesses"])} for each in (found, result)
    )
    for p in (5e13, 5e14):
        for key in ("frequency", "growth"):
            one, two = ([mode[key] for mode in each[p]["modes"]] for each in (ours, theirs))
            np.testing.assert_allclose(one, two, rtol=1e-8, atol=1e-5)
        assert ours[p]["complete"]


@pytest.mark.parametrize("sizes", [(), (0.01, 0.02), (0.01, 0.01), (-0.01,)])
def test_sizes_that_do_not_fall_are_refused(sizes):
    with pytest.raises(InputError) as caught:
        BrakeStudy(sizes)
    assert caught.value.field == "sizes"


def assert_estimated(degree, size, dofs):
    scene = scene_of_size(size, [f"bodies.{name}.mesh.fe.degree={degree}" for name in BODIES])
    assert estimated_memory(scene).dofs == pytest.approx(dofs, rel=0.25)


def test_the_estimate_knows_how_fine_the_disc_is():
    """Its dofs are those of the mesh, whatever the size: walls and holes bound that."""
    assert_estimated(2, 0.0055, 483_000)


@pytest.mark.slow
def test_the_estimate_knows_how_rough_the_disc_is(result):
    assert_estimated(1, 0.03, result["runs"][0]["dofs"])


@pytest.mark.parametrize(
    ("override", "field"),
    [
        ("bodies.disc.backend='iga'", "bodies.disc.backend"),
        ("bodies.disc.mesh.fe={cell='hexahedron',elements=[2,8,2]}", "bodies.disc.mesh.fe.cell"),
        ("bodies.disc.mesh.fe={cell='tetrahedron',elements=[2,8,2]}", "mesh.fe.elements"),
        ("bodies.disc.mesh.fe.degree=3", "bodies.disc.mesh.fe.geometry_degree"),
        ("bodies.disc.geometry.vanes=0", "vanes"),
        ("bodies.disc.geometry.holes=0", "bodies.disc.supports.1.surface"),
    ],
)
def test_discs_that_cannot_be_meshed_are_refused(override, field):
    with pytest.raises(SceneError) as caught:
        load_scene(SCENE, [override])
    assert field in str(caught.value)
