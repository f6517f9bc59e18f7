"""The catalogue of stability: every case is found and says what it expects; its report."""

import csv
import json
from html import unescape
from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest

from cea.errors import InputError
from comparisons.stability import cases
from comparisons.stability.catalogue import catalogue, numbers_of, runs_of
from comparisons.stability.parts.case import REFUSED, Run
from comparisons.stability.parts.problems import OfMatrices, OfScene
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.scenes import layers
from comparisons.stability.parts.ways import ALONE, OPEN, WAYS
from comparisons.stability.study import (
    STUDY,
    Options,
    by_case,
    digits,
    fault,
    not_met,
    runs,
)
from comparisons.stability.verdicts import judged
from comparisons.study.page import write_study
from comparisons.study.result import StudyResult
from comparisons.study.run import run


def test_every_table_of_cases_is_in_the_catalogue():
    tables = [
        import_module(f"{cases.__name__}.{each.name}") for each in iter_modules(cases.__path__)
    ]
    names = [name for table in tables for name in table.CASES]
    assert sorted(names) == list(catalogue())
    assert all(case.title and case.subject for case in catalogue().values())


@pytest.mark.parametrize("name", catalogue())
def test_every_run_says_what_it_expects(name):
    found = runs_of(name)
    assert found
    for each in found:
        assert each.expected
        assert "WRONG" not in each.expected
        assert (each.reference is None) == (each.expected == REFUSED)
        assert 0 < each.tolerance < 0.1
        assert each.way in (*WAYS, *OPEN, *ALONE)
    assert len({(run.row, run.way.backend, run.way.name) for run in found}) == len(found)
    assert 0 < len(numbers_of(name, quick=True)) <= len(found)


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
def result(tmp_path_factory):
    """A quick study of a case."""
    options = Options(("exceptional_point",), every=False)
    return run(STUDY, options, tmp_path_factory.mktemp("stability") / "out")


def test_every_run_is_in_the_tables_and_in_a_heat_map(result, tmp_path):
    page = write_study(STUDY, result, tmp_path)
    with (tmp_path / "runs.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(numbers_of("exceptional_point", quick=True))
    assert all(row["verdict"] in ("accurate", "warned") for row in rows)
    assert catalogue()["exceptional_point"].title in unescape(page.read_text(encoding="utf-8"))
    drawn = {file.name for file in tmp_path.glob("*.png")}
    assert drawn == {"digits_friction_and_spectra.png"}
    assert fault(result) == ""


def test_runs_without_an_answer_or_not_as_expected_are_told(result):
    record = json.loads(json.dumps(result.record))
    first, second = record["cases"][:2]
    first["tables"]["runs"][0] |= {"met": False, "verdict": "WRONG", "reason": "planted"}
    second |= {"tables": {}, "failed": "ended with code 5"}
    told = StudyResult(record)
    assert list(not_met(told)["reason"]) == ["planted", "ended with code 5"]
    assert "exceptional_point" in fault(told)
    assert by_case(told)["WRONG"].sum() == 2


@pytest.mark.slow
def test_a_representative_part_comes_out_as_expected(tmp_path):
    options = Options(("inverted", "units", "overhang"), every=False)
    found = runs(run(STUDY, options, tmp_path / "out"))
    assert list(found.loc[~found["met"].astype(bool), "reason"]) == []
    assert set(found["verdict"]) == {"accurate", "refused"}


def test_digits_end_where_those_of_a_double_do():
    assert [digits(e) for e in (0.0, 1e-5, float("inf"), None)] == [16, 5, 0, None]
