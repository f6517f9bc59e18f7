"""The catalogue of stability: what runs expect, its references, its report."""

import json
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

from cea.errors import InputError
from comparisons.stability import study
from comparisons.stability.dense import dense_eigenvalues
from comparisons.stability.scenes import layers, sprag
from comparisons.stability.verdicts import judged, window_end
from comparisons.stability.ways import ALONE, OPEN, WAYS, chosen
from comparisons.study.page import write_study
from comparisons.study.result import StudyResult
from comparisons.study.run import run
from scenes import read_scene, run_modes

EVERY_WAY = (*WAYS, *OPEN, *ALONE)


def test_every_run_says_what_it_expects_and_every_way_is_taken():
    found = {name: study.runs_of(name) for name in study.catalogue()}
    for name, runs in found.items():
        assert study.title_of(name)
        assert len({(run.row, run.way.backend, run.way.name) for run in runs}) == len(runs) > 0
    every = [each for runs in found.values() for each in runs]
    assert len(every) >= 3750
    for each in every:
        assert each.expected
        assert "WRONG" not in each.expected
        assert (each.reference is None) == (each.expected == ("refused",))
        assert 0 < each.tolerance < 0.1
    for way in EVERY_WAY:
        assert any(each.way == way for each in every)
    assert not any(run.warnings for run in found["everyday"])
    quick = sum(len(study.numbers_of(name, quick=True)) for name in found)
    assert len(found) < quick < len(every) / 4
    with pytest.raises(InputError, match="no_such_case"):
        study.runs_of("no_such_case")


# References: windows, dense eigenvalues, limits and other units.


def test_a_window_ends_in_a_gap_and_never_cuts_copies():
    true = np.array([1j, 1j, 1j, 1.01j, 5j, 5j])
    assert 1.01 < 2 * np.pi * window_end(true, 3) < 5
    assert all(2 * np.pi * window_end(true, lowest) > 5 for lowest in (6, 100))


@pytest.mark.parametrize("way", WAYS[::2], ids=lambda way: f"{way.backend} {way.name}")
def test_dense_eigenvalues_are_those_of_the_scene(way):
    """Of every second way: every formulation, on both backends, in both forms."""
    data = way.of(layers(p=10.0)) | {"analysis": {"kind": "cea", "max_frequency": 0.4}}
    found = run_modes(read_scene(data)).modes.eigenvalues
    true = dense_eigenvalues(data)
    assert np.abs(found - true[: len(found)]).max() < 1e-9 * np.abs(true[len(found)])


@pytest.mark.parametrize("way", chosen(WAYS, "mortar, saddle"), ids=("fe", "iga"))
def test_a_tie_is_the_limit_of_stiff_contact(way):
    stiff, tied = (dense_eigenvalues(way.of(layers(P=P)))[:8] for P in (1e11, np.inf))
    assert np.abs(stiff - tied).max() < 1e-8


def test_a_sprag_diverges_above_the_cotangent_of_its_angle(backend):
    (way,) = chosen(WAYS, "mortar, penalty", backend=backend)
    values = [dense_eigenvalues(way.of(sprag(60.0, mu))) for mu in (0.3, 1.5)]
    assert [np.sum((v.imag < 1e-9) & (v.real > 1e-3)) for v in values] == [0, 1]


# Runs and the report.


def test_an_easy_scene_comes_out_accurate():
    found = judged(study.runs_of("everyday")[0])
    assert (found["verdict"], found["met"], found["says"]) == ("accurate", True, "")
    assert found["error"] < 1e-10


def test_rigid_bodies_meet_at_a_corner_as_the_closed_form_says(backend):
    """From a mesh file, and as NURBS patches."""
    runs = [run for run in study.runs_of("contact_corner") if run.way.backend == backend]
    runs = [run for run in runs if run.row == "rigid bodies" and "saddle" in run.way.name]
    assert {run.way.name.split(",")[0] for run in runs} == {"GPTS", "segments", "mortar"}
    assert [run.way.name for run in runs if not judged(run)["met"]] == []


@pytest.mark.parametrize("name", ["damped_maps", "graded", "mesh_files", "patch_test"])
def test_a_stiff_run_of_each_kind_of_problem_comes_out_as_expected(name):
    found = judged(study.runs_of(name)[-1])
    assert found["met"], found["reason"]


def quick_study(out, *cases, **fields):
    """A quick study of some cases."""
    return run(replace(study.STUDY, **fields), study.Options(cases, every=False), out)


def test_runs_without_an_answer_or_not_as_expected_are_told(tmp_path):
    result = quick_study(tmp_path / "out", "aspect", process=None)
    page = write_study(study.STUDY, result, tmp_path).read_text(encoding="utf-8")
    assert study.title_of("aspect") in unescape(page)
    assert set(study.runs(result)["verdict"]) <= {"accurate", "warned"}
    assert study.fault(result) == ""
    record = json.loads(json.dumps(result.record))
    first, second = record["cases"][:2]
    first["tables"]["runs"][0] |= {"met": False, "verdict": "WRONG", "reason": "planted"}
    second |= {"tables": {}, "failed": "ended with code 5"}
    told = StudyResult(record)
    assert list(study.not_met(told)["reason"]) == ["planted", "ended with code 5"]
    assert "aspect" in study.fault(told)
    assert study.by_case(told)["WRONG"].sum() == 2


@pytest.mark.slow
def test_a_representative_part_comes_out_as_expected(tmp_path):
    found = study.runs(quick_study(tmp_path / "out", "inverted", "units", "overhang"))
    assert list(found.loc[~found["met"].astype(bool), "reason"]) == []
    assert set(found["verdict"]) == {"accurate", "refused"}
