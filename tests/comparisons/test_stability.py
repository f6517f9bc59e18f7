"""The catalogue of stability: every case is found and says what it expects; verdicts are right."""

import csv
import json
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from stability_workers import dying
from typer.testing import CliRunner

from cea.errors import ConvergenceError, InputError
from comparisons.cli.app import app
from comparisons.stability import cases
from comparisons.stability.catalogue import catalogue, numbers_of, runs_of
from comparisons.stability.measure import judged, window_end
from comparisons.stability.page import read_stability, write_stability
from comparisons.stability.parts.answers import ModesAnswer, StressAnswer
from comparisons.stability.parts.case import ACCURATE, HONEST, MESH, NONE, REFUSED, WARNED, Run
from comparisons.stability.parts.dense import dense_eigenvalues, dense_kappas, lambdas
from comparisons.stability.parts.problems import OfMatrices, OfScene
from comparisons.stability.parts.references import Reference, copies, dense, formula
from comparisons.stability.parts.scenes import in_units, layers, moved, sprag
from comparisons.stability.parts.ways import ALONE, OPEN, WAYS, chosen
from comparisons.stability.study import StabilityStudy, run_stability
from comparisons.stability.tables import digits
from comparisons.stability.verdicts import compare
from scenes.read import read_scene
from scenes.run import run_modes

TRUE = np.array([1j, 2j, 0.2 + 3j, -0.2 + 3j, 8j])
"""Eigenvalues up to and beyond a window of 4 rad/s, one pair fluttering."""
SAID = ("stable", "stable", "unstable", "stable")


def answer(values=TRUE[:4], verdicts=SAID, **fields):
    """A claim of modes in a window of 4 rad/s."""
    values = np.asarray(values, dtype=complex)
    told = {
        "eigenvalues": values,
        "verdicts": tuple(verdicts),
        "verdict": "unstable" if "unstable" in verdicts else "stable",
        "thresholds": np.full(len(values), 1e-3),
        "uncertainties": np.zeros(len(values)),
        "complete": True,
        "max_frequency": 4 / (2 * np.pi),
        "residual": 1e-12,
        "condition": 1.0,
        "warnings": (),
        "dofs": 10,
    }
    return ModesAnswer(**{**told, **fields})


class Planted:
    """A problem that answers, or fails, as it is told."""

    def __init__(self, outcome):
        self.outcome = outcome

    def solve(self, max_frequency):
        """Answer or raise."""
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome


def verdict_of(outcome, expected=ACCURATE, true=TRUE, **fields):
    reference = None if true is None else formula(list(true))
    run = Run("planted", ALONE[0], Planted(outcome), reference, expected, 1e-6, **fields)
    return judged(run)


def test_every_file_of_cases_is_found_and_holds_runs():
    files = {file.stem for file in Path(cases.__file__).parent.glob("*.py")} - {"__init__"}
    assert set(catalogue()) == files
    assert len(files) >= 30
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


def test_quick_takes_both_backends_of_a_row_in_turn():
    runs, numbers = runs_of("units"), numbers_of("units", quick=True)
    taken = [(runs[i].way.backend, runs[i].way.name) for i in numbers]
    assert sorted(taken[:2]) == [("fe", "GPTS, penalty"), ("iga", "mortar, saddle")]
    assert sorted(taken[2:4]) == [("fe", "mortar, saddle"), ("iga", "GPTS, penalty")]


def test_an_unknown_case_is_refused():
    with pytest.raises(InputError, match="no_such_case"):
        runs_of("no_such_case")


def test_a_right_answer_is_accurate():
    found = verdict_of(answer())
    assert (found["verdict"], found["met"], found["error"]) == ("accurate", True, 0)


def test_a_right_answer_with_a_warning_is_not_easy():
    found = verdict_of(answer(warnings=("locking",)))
    assert (found["verdict"], found["met"], found["says"]) == ("accurate", False, ["locking"])
    assert verdict_of(answer(warnings=("locking",)), warnings=("locking",))["met"]


def test_a_warning_that_may_come_excuses_no_error():
    wrong = answer(TRUE[:4] * (1 + 1e-4), warnings=("short-modes",))
    assert verdict_of(wrong, HONEST, warnings=MESH)["verdict"] == "WRONG"
    assert verdict_of(wrong, HONEST, warnings=NONE)["verdict"] == "warned"


@pytest.mark.parametrize(
    "wrong",
    [
        answer(TRUE[:4] * (1 + 1e-4)),
        answer(TRUE[[0, 2, 3]], SAID[1:]),
        answer([*TRUE[:4], 3.5j], [*SAID, "stable"]),
        answer([TRUE[0], *TRUE[:4]], ["stable", *SAID]),
    ],
    ids=["digits", "missing", "spurious", "twice"],
)
def test_a_wrong_answer_is_wrong_without_a_word_and_warned_with_one(wrong):
    assert verdict_of(wrong, HONEST)["verdict"] == "WRONG"
    assert not verdict_of(wrong, HONEST)["met"]
    said = verdict_of(replace(wrong, warnings=("residual",)), HONEST)
    assert (said["verdict"], said["met"]) == ("warned", True)
    assert not verdict_of(replace(wrong, warnings=("residual",)), ACCURATE)["met"]
    open_end = verdict_of(replace(wrong, complete=False, verdict="undecided"), HONEST)
    assert (open_end["verdict"], open_end["says"]) == (
        "warned",
        ["undecided", "window-not-complete"],
    )


def test_an_error_that_the_uncertainty_admits_is_warned():
    off = answer(TRUE[:4] * (1 + 1e-4), uncertainties=np.full(4, 1e-3))
    assert verdict_of(off, WARNED)["verdict"] == "warned"
    small = answer(TRUE[:4] * (1 + 1e-4), uncertainties=np.full(4, 1e-5))
    assert verdict_of(small, WARNED)["verdict"] == "WRONG"
    missing = answer(TRUE[[0, 2, 3]], SAID[1:], uncertainties=np.ones(3))
    assert verdict_of(missing, WARNED)["verdict"] == "WRONG"


@pytest.mark.parametrize(
    "verdicts",
    [
        ("stable", "stable", "stable", "stable"),
        ("unstable", "stable", "unstable", "stable"),
        ("stable", "stable", "unstable", "unstable"),
    ],
)
def test_a_false_claim_is_wrong_whatever_is_warned_of(verdicts):
    found = verdict_of(answer(verdicts=verdicts, warnings=("residual",)), HONEST)
    assert (found["verdict"], found["met"]) == ("WRONG", False)
    assert "called" in found["reason"]


def test_a_window_called_stable_with_a_growing_mode_missing_is_wrong():
    found = verdict_of(answer(TRUE[:2], SAID[:2], warnings=("window-not-complete",)), HONEST)
    assert found["verdict"] == "WRONG"
    assert "window called stable" in found["reason"]
    honest = answer(TRUE[:2], SAID[:2], complete=False, verdict="undecided")
    assert verdict_of(honest, HONEST)["verdict"] == "warned"


def test_a_mode_that_may_be_another_makes_no_false_claim():
    """One beyond the window grows; what stands nearest to it inside is far off, and warned of."""
    true = [1j, 2j, 0.2 + 4.5j, -0.2 + 4.5j, 8j]
    found = answer([1j, 2j, 3.8j], 3 * ("stable",), warnings=("residual",))
    assert verdict_of(found, HONEST, true)["verdict"] == "warned"
    assert verdict_of(answer([1j, 2j, 3.8j], 3 * ("stable",)), HONEST, true)["verdict"] == "WRONG"


def test_a_divergence_belongs_to_every_window():
    true = [5.0 + 0j, *TRUE]
    assert verdict_of(answer(), HONEST, true)["missing"] == 1
    found = answer([5.0 + 0j, *TRUE[:4]], ("unstable", *SAID))
    assert verdict_of(found, true=true)["verdict"] == "accurate"


def test_what_is_undecided_is_not_accurate_unless_it_may_be():
    shy = answer(verdicts=("stable", "undecided", "unstable", "stable"))
    assert verdict_of(shy, WARNED)["verdict"] == "warned"
    assert verdict_of(shy, WARNED)["met"]
    assert not verdict_of(shy)["met"]
    assert verdict_of(shy, warnings=("undecided",))["verdict"] == "accurate"


def test_rounding_of_rigid_motions_does_not_grow():
    true = [0j, 0j, *TRUE]
    values = [1e-7 + 0j, 1e-7j, *TRUE[:4]]
    right = answer(values, ("stable", "stable", *SAID))
    assert verdict_of(right, true=true)["verdict"] == "accurate"
    wrong = answer(values, ("unstable", "stable", *SAID))
    assert verdict_of(wrong, true=true)["verdict"] == "WRONG"
    assert verdict_of(answer(), true=true)["missing"] == 2


def test_members_near_a_coalescence_may_lose_half_the_digits_of_their_mean():
    true = [1j, 1j, *TRUE[1:]]
    pair = answer([(1 + 3e-7) * 1j, (1 - 3e-7) * 1j, *TRUE[1:4]], ("stable", *SAID))
    assert compare(pair, np.array(true), 1e-8).error < 1e-8
    both = answer([(1 + 3e-7) * 1j, (1 + 3e-7) * 1j, *TRUE[1:4]], ("stable", *SAID))
    assert compare(both, np.array(true), 1e-8).error > 1e-7


@pytest.mark.parametrize(
    "fault", [InputError("bodies.b.material.nu", 0.5, "less"), ConvergenceError("no convergence")]
)
def test_a_refusal_is_no_answer_and_no_crash(fault):
    assert verdict_of(fault, HONEST)["verdict"] == "refused"
    assert verdict_of(fault, HONEST)["met"]
    assert not verdict_of(fault, ACCURATE)["met"]
    assert verdict_of(fault, REFUSED, None)["met"]


def test_a_refusal_must_name_what_is_wrong():
    fault = InputError("bodies.b.material.nu", 0.5, "less")
    assert verdict_of(fault, REFUSED, None, names="material.nu")["met"]
    other = verdict_of(fault, REFUSED, None, names="material.rho")
    assert (other["verdict"], other["met"]) == ("WRONG", False)


def test_a_crash_is_wrong():
    found = verdict_of(ValueError("inf is not JSON"), HONEST)
    assert (found["verdict"], found["met"]) == ("WRONG", False)
    assert "ValueError: inf is not JSON" in found["reason"]


def test_an_answer_to_what_has_none_is_wrong():
    assert verdict_of(answer(), REFUSED, None)["verdict"] == "WRONG"
    assert not verdict_of(StressAnswer(np.array([3e14]), (), 4), REFUSED, None)["met"]


def test_a_reference_that_fails_is_a_fault_and_one_that_is_refused_has_no_answer():
    def fails(error):
        def values():
            raise error

        return Reference("dense", values)

    run = Run("planted", ALONE[0], Planted(answer()), fails(ZeroDivisionError()), HONEST)
    assert "no reference" in judged(run)["reason"]
    run = replace(run, reference=fails(InputError("P", 0, "positive")))
    assert judged(run)["reason"] == "answered what has no answer"


def test_stresses_are_compared_with_the_uniform_one():
    right = StressAnswer(np.array([-1000.0, -1000.0 * (1 + 1e-9)]), (), 4)
    assert verdict_of(right, true=[-1000.0])["verdict"] == "accurate"
    wrong = StressAnswer(np.array([-1000.0, -900.0]), (), 4)
    assert verdict_of(wrong, HONEST, [-1000.0])["verdict"] == "WRONG"


def test_a_window_ends_in_a_gap_and_never_cuts_copies():
    true = np.array([1j, 1j, 1j, 1.01j, 5j, 5j])
    assert 1.01 < 2 * np.pi * window_end(true, 3) < 5
    assert 2 * np.pi * window_end(true, 6) > 5
    assert 2 * np.pi * window_end(true, 100) > 5


def test_dense_kappas_of_given_matrices():
    K = np.array([[2.0, -1.5], [1.5, 2.0]])
    kappa = dense_kappas(K, np.eye(2), [])
    assert np.allclose(np.sort_complex(kappa), [2 - 1.5j, 2 + 1.5j])
    constraint = (np.array([[1.0, -1.0]]), np.array([[1.0, -1.0]]), np.zeros((1, 1)))
    tied = dense_kappas(np.diag([1.0, 3.0]), np.eye(2), [constraint])
    assert np.allclose(tied, [2.0])


def test_dense_kappas_are_right_from_the_lowest_to_the_farthest():
    """The far ones too: stiff contact may diverge where its points are lumped."""
    true = np.sort([1.9, 3.3, 7.6e3, -2.3e3, -4.2e9, -1.1e15, -4.7e15, *range(4, 34)])
    upper = np.diag(true) + np.diag(np.full(len(true) - 1, 1e-3), 1)  # unsymmetric, nothing rounded
    kappa = np.sort(dense_kappas(upper, np.eye(len(true)), []).real)
    assert kappa == pytest.approx(true, rel=1e-7)


def test_lambdas_have_no_negative_frequency_and_grow_where_kappa_is_negative():
    values = lambdas(np.array([4.0, -9.0, 1 + 1j]))
    assert (values.imag >= 0).all()
    assert np.allclose(values[0], 3)


@pytest.mark.parametrize("way", WAYS, ids=lambda way: f"{way.backend} {way.name}")
def test_dense_eigenvalues_are_those_of_the_scene(way):
    data = way.of(layers(p=10.0)) | {"analysis": {"kind": "cea", "max_frequency": 0.4}}
    found = run_modes(read_scene(data)).modes.eigenvalues
    true = dense_eigenvalues(data)
    assert np.abs(found - true[: len(found)]).max() < 1e-9 * np.abs(true[len(found)])


@pytest.mark.parametrize("way", chosen(WAYS, "GPTS, saddle", "mortar, saddle"))
def test_a_tie_is_the_limit_of_stiff_contact(way):
    stiff, tied = (dense_eigenvalues(way.of(layers(P=P)))[:8] for P in (1e11, np.inf))
    assert np.abs(stiff - tied).max() < 1e-8


def test_other_units_and_places_have_the_same_eigenvalues():
    scene = WAYS[0].of(layers())
    true = dense_eigenvalues(scene)[:8]
    for other in (in_units(scene, metre=1e3, kilogram=1e-3), moved(scene, (10.0, -3.0))):
        assert np.abs(dense_eigenvalues(other)[:8] - true).max() < 1e-9


@pytest.mark.parametrize("backend", ["fe", "iga"])
def test_a_sprag_diverges_above_the_cotangent_of_its_angle(backend):
    (way,) = chosen(WAYS, "mortar, penalty", backend=backend)
    values = [dense_eigenvalues(way.of(sprag(60.0, mu))) for mu in (0.3, 1.5)]
    diverging = [v[(v.imag < 1e-9) & (v.real > 1e-3)] for v in values]
    assert [len(v) for v in diverging] == [0, 1]


def test_copies_are_those_of_one():
    data = ALONE[1].of({**layers(), "contacts": {}})
    values, once = copies(3, data).values(), dense(data).values()
    assert np.allclose(values, np.repeat(once, 3))


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
    """Data and folder of a quick run of some cases."""
    names = ("exceptional_point", "inverted", "units", "overhang")
    data = run_stability(StabilityStudy(names, quick=True))
    out = tmp_path_factory.mktemp("stability")
    return data, write_stability(data, out)


def test_a_representative_part_comes_out_as_expected(report):
    data, _ = report
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
