"""The catalogue of stability: every case is found and says what it expects; its report."""

import csv
import json
from html import unescape
from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest
from stability_workers import dying
from typer.testing import CliRunner

from cea.errors import InputError
from comparisons.cli.app import app
from comparisons.stability import cases
from comparisons.stability.catalogue import catalogue, numbers_of, runs_of
from comparisons.stability.measure import judged
from comparisons.stability.page import read_stability, write_stability
from comparisons.stability.parts.case import REFUSED, Run
from comparisons.stability.parts.problems import OfMatrices, OfScene
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import ALONE, OPEN, WAYS
from comparisons.stability.study import StabilityStudy, run_stability
from comparisons.stability.tables import digits


def test_every_table_of_cases_is_in_the_catalogue():
    tables = [
        import_module(f"{cases.__name__}.{each.name}") for each in iter_modules(cases.__path__)
    ]
    names = [name for table in tables for name in table.CASES]
    assert sorted(names) == list(catalogue())
    assert all(case.title and case.subject for case in catalogue().values())


@pytest.mark.parametrize("name", catalogue())
def test_every_run_says_what_it_expects(name):
    runs = runs_of(name)
    assert runs
    for run in runs:
        assert run.expected
        assert "WRONG" not in run.expected
        assert (run.reference is None) == (run.expected == REFUSED)
        assert 0 < run.tolerance < 0.1
        assert run.way in (*WAYS, *OPEN, *ALONE)
    assert len({(run.row, run.way.backend, run.way.name) for run in runs}) == len(runs)
    assert 0 < len(numbers_of(name, quick=True)) <= len(runs)


def test_the_catalogue_covers_both_backends_and_every_way():
    every = [run for name in catalogue() for run in runs_of(name)]
    assert [way for way in (*WAYS, *OPEN, *ALONE) if way not in [run.way for run in every]] == []
    quick = sum(len(numbers_of(name, quick=True)) for name in catalogue())
    assert quick < len(every) / 4
    assert len([run for run in every if run.easy]) >= 100
    assert all(run.easy for run in runs_of("everyday"))


def test_rigid_bodies_meet_at_a_corner_as_the_closed_form_says(backend):
    """From a mesh file, and as NURBS patches."""
    runs = [run for run in runs_of("contact_corner") if run.way.backend == backend]
    runs = [run for run in runs if run.row == "rigid bodies" and "saddle" in run.way.name]
    assert {run.way.name.split(",")[0] for run in runs} == {"GPTS", "segments", "mortar"}
    assert [run.way.name for run in runs if not judged(run)["met"]] == []


def test_quick_takes_both_backends_of_a_row_in_turn():
    runs, numbers = runs_of("units"), numbers_of("units", quick=True)
    taken = [(runs[i].way.backend, runs[i].way.name) for i in numbers]
    assert sorted(taken[:2]) == [("fe", "GPTS, penalty"), ("iga", "mortar, saddle")]
    assert sorted(taken[2:4]) == [("fe", "mortar, saddle"), ("iga", "GPTS, penalty")]


def test_an_unknown_case_is_refused():
    with pytest.raises(InputError, match="no_such_case"):
        runs_of("no_such_case")


def test_an_easy_scene_and_matrices_come_out_accurate():
    found = judged(runs_of("everyday")[0])
    assert (found["verdict"], found["met"], found["says"]) == ("accurate", True, [])
    assert found["error"] < 1e-10
    matrices = OfMatrices(np.diag([1.0, 4.0, 100.0]), np.eye(3), np.zeros((3, 3)))
    run = Run("easy", ALONE[0], matrices, formula([1j, 2j, 10j]), lowest=2)
    assert judged(run)["verdict"] == "accurate"


def test_a_scene_that_is_refused_is_told_so():
    data = WAYS[0].of(layers(upper={"nu": 0.5}))
    run = Run("wrong", WAYS[0], OfScene(data), None, REFUSED, names="material.nu")
    assert judged(run)["met"]


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Data and folder of a quick run of a case."""
    data = run_stability(StabilityStudy(("exceptional_point",), quick=True))
    out = tmp_path_factory.mktemp("stability")
    return data, write_stability(data, out)


@pytest.mark.slow
def test_a_representative_part_comes_out_as_expected():
    names = ("exceptional_point", "inverted", "units", "overhang")
    data = run_stability(StabilityStudy(names, quick=True))
    assert [run["reason"] for run in data["runs"] if not run["met"]] == []
    assert data["failed"] == 0
    assert {run["verdict"] for run in data["runs"]} == {"accurate", "refused"}
    assert all(run["seconds"] < 5 for run in data["runs"])


def test_the_report_holds_every_run_and_is_drawn_anew(report):
    data, page = report
    out = page.parent
    with (out / "runs.csv").open(newline="", encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == len(data["runs"])
    assert json.loads((out / "result.json").read_text())["command"] == "stability"
    text = page.read_text(encoding="utf-8")
    assert all(case["title"] in unescape(text) for case in data["cases"].values())
    assert (out / "digits_friction_and_spectra.png").is_file()
    before = page.read_bytes()
    assert write_stability(read_stability(out), out).read_bytes() == before


def test_digits_end_where_those_of_a_double_do():
    assert digits({"error": 0.0}) == 16
    assert digits({"error": 1e-5}) == 5
    assert digits({"error": float("inf")}) == 0
    assert digits({"error": None}) is None


def test_a_run_that_kills_its_process_is_wrong_and_the_others_go_on():
    data = run_stability(StabilityStudy(("inverted",)), make=dying)
    verdicts = [run["verdict"] for run in data["runs"]]
    assert verdicts == ["accurate", "WRONG", *["accurate"] * (len(verdicts) - 2)]
    assert "ended with code 5" in data["runs"][1]["reason"]
    assert data["failed"] == 1


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(("failed", "code"), [(0, 0), (1, 1)])
def test_the_command_ends_with_code_1_where_a_run_is_not_as_expected(
    report, failed, code, tmp_path
):
    data = json.loads(json.dumps(report[0]))
    if failed:
        data["runs"][0] |= {"met": False, "verdict": "WRONG", "reason": "planted"}
        data["failed"] = failed
    write_stability(data, tmp_path)
    found = CliRunner().invoke(app, ["stability", "--redraw", "--out", str(tmp_path)])
    assert found.exit_code == code
    assert f"{tmp_path / 'report.html'}" in found.output.replace("\n", "")
    assert ("planted" in (tmp_path / "report.html").read_text()) == bool(failed)


def test_the_command_refuses_an_unknown_case(tmp_path):
    found = CliRunner().invoke(app, ["stability", "--case", "nothing", "--out", str(tmp_path)])
    assert isinstance(found.exception, InputError)
