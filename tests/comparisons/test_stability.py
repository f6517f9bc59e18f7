"""The catalogue of stability: every case says what it expects; its report; loads are borne."""

import json
from copy import deepcopy
from html import unescape

import numpy as np
import pytest

from cea.errors import ConvergenceError, InputError
from cea.matrices import destroy
from comparisons.stability import study
from comparisons.stability.verdicts import judged
from comparisons.stability.ways import ALONE, OPEN, WAYS
from comparisons.study.page import write_study
from comparisons.study.result import StudyResult
from comparisons.study.run import run
from scenes import read_scene
from scenes.running.static import run_static
from scenes.running.system import coupled


@pytest.mark.parametrize("name", study.catalogue())
def test_every_run_says_what_it_expects(name):
    found = study.runs_of(name)
    assert study.title_of(name)
    for each in found:
        assert each.expected
        assert "WRONG" not in each.expected
        assert (each.reference is None) == (each.expected == ("refused",))
        assert 0 < each.tolerance < 0.1
        assert each.way in (*WAYS, *OPEN, *ALONE)
    assert len({(run.row, run.way.backend, run.way.name) for run in found}) == len(found)
    assert 0 < len(study.numbers_of(name, quick=True)) <= len(found)


def test_the_catalogue_covers_every_way_and_quick_takes_both_backends_in_turn():
    every = [run for name in study.catalogue() for run in study.runs_of(name)]
    assert len(every) >= 3750
    assert [way for way in (*WAYS, *OPEN, *ALONE) if way not in [run.way for run in every]] == []
    assert (
        sum(len(study.numbers_of(name, quick=True)) for name in study.catalogue()) < len(every) / 4
    )
    assert not any(run.warnings for run in study.runs_of("everyday"))
    units = study.runs_of("units")
    taken = [units[i].way for i in study.numbers_of("units", quick=True)[:4]]
    assert [way.backend for way in taken] == ["fe", "iga", "fe", "iga"]
    assert [way.name.split(",")[0] for way in taken] == ["GPTS", "mortar", "mortar", "GPTS"]
    with pytest.raises(InputError, match="no_such_case"):
        study.runs_of("no_such_case")


def test_an_easy_scene_comes_out_accurate():
    found = judged(study.runs_of("everyday")[0])
    assert (found["verdict"], found["met"], found["says"]) == ("accurate", True, [])
    assert found["error"] < 1e-10
    assert [study.digits(e) for e in (0.0, 1e-5, float("inf"), None)] == [16, 5, 0, None]


def test_rigid_bodies_meet_at_a_corner_as_the_closed_form_says(backend):
    """From a mesh file, and as NURBS patches."""
    runs = [run for run in study.runs_of("contact_corner") if run.way.backend == backend]
    runs = [run for run in runs if run.row == "rigid bodies" and "saddle" in run.way.name]
    assert {run.way.name.split(",")[0] for run in runs} == {"GPTS", "segments", "mortar"}
    assert [run.way.name for run in runs if not judged(run)["met"]] == []


@pytest.mark.parametrize("name", ["damped_maps", "graded", "maps", "mesh_files", "patch_test"])
def test_a_stiff_run_of_each_kind_of_problem_comes_out_as_expected(name):
    found = judged(study.runs_of(name)[-1])
    assert found["met"], found["reason"]


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """A quick study of a case."""
    options = study.Options(("exceptional_point",), every=False)
    return run(study.STUDY, options, tmp_path_factory.mktemp("stability") / "out")


def test_runs_without_an_answer_or_not_as_expected_are_told(result, tmp_path):
    page = write_study(study.STUDY, result, tmp_path).read_text(encoding="utf-8")
    assert study.title_of("exceptional_point") in unescape(page)
    assert set(study.runs(result)["verdict"]) <= {"accurate", "warned"}
    assert study.fault(result) == ""
    record = json.loads(json.dumps(result.record))
    first, second = record["cases"][:2]
    first["tables"]["runs"][0] |= {"met": False, "verdict": "WRONG", "reason": "planted"}
    second |= {"tables": {}, "failed": "ended with code 5"}
    told = StudyResult(record)
    assert list(study.not_met(told)["reason"]) == ["planted", "ended with code 5"]
    assert "exceptional_point" in study.fault(told)
    assert study.by_case(told)["WRONG"].sum() == 2


@pytest.mark.slow
def test_a_representative_part_comes_out_as_expected(tmp_path):
    options = study.Options(("inverted", "units", "overhang"), every=False)
    found = study.runs(run(study.STUDY, options, tmp_path / "out"))
    assert list(found.loc[~found["met"].astype(bool), "reason"]) == []
    assert set(found["verdict"]) == {"accurate", "refused"}


def outside(scene):
    """Forces on all bodies from outside (N), and what rounding makes of their sum.

    Loads and supports; contacts are between bodies, and in no sum.
    """
    if scene.analysis.kind == "static":
        result = run_static(scene)
        system, x, reactions = result.system, result.displacement, result.reactions
    else:
        system = coupled(scene)[0]
        x, reactions = system.steady.displacement, system.steady.reactions
    forces, rounding, eps = [], 0.0, np.finfo(float).eps
    for name, body in system.bodies.items():
        load, stiffness = body.full_load(), body.full_stiffness()
        u = system.displacement(x, name)
        forces.append(body.comm.allreduce(load.reshape(-1, body.dim).sum(axis=0)))
        forces += list(reactions.get(name, ()))
        rounding += eps * stiffness.norm() * np.linalg.norm(u) * np.sqrt(len(u))
        destroy(stiffness)
    for contact in system.contacts:
        if contact.lumped is None and np.isfinite(contact.P) and not contact.has_multipliers:
            u = max(np.abs(system.displacement(x, name)).max() for name in system.bodies)
            rounding += eps * contact.P * u  # of a penalty
    return np.array(forces), rounding


LOADED = ("load_steps", "patch_test", "prescribed", "prestress", "steady_sliding", "unsupported")


@pytest.mark.parametrize(
    ("name", "quick"),
    [(n, True) for n in LOADED] + [pytest.param(n, False, marks=pytest.mark.slow) for n in LOADED],
)
def test_what_is_outside_holds_the_bodies(name, quick):
    for number in study.numbers_of(name, quick=quick):
        each = study.runs_of(name)[number]
        data = deepcopy(dict(each.problem.data))
        if data["analysis"]["kind"] == "cea":
            data["analysis"].setdefault("max_frequency", 1.0)
        try:
            forces, rounding = outside(read_scene(data))
        except ConvergenceError as error:
            forces, rounding, refusal = np.zeros((1, 2)), 0.0, str(error)
        else:
            refusal = ""
        assert not refusal or "refused" in each.expected, each.row
        assert "add up to zero" not in refusal, each.row
        largest = np.linalg.norm(forces, axis=1).max()
        assert np.linalg.norm(forces.sum(axis=0)) <= 1e-11 * largest + rounding, each.row
