"""`cea bench solve`: every method finds the eigenvalues it should, and what is shown of it."""

import numpy as np
import pytest

from cea.errors import ConvergenceError, InputError
from comparisons.bench import launch, memory
from comparisons.bench.solve import process, study
from comparisons.bench.solve.methods.problem import Problem, scene_of_size, write_matrices
from comparisons.bench.solve.page import REPORT
from comparisons.bench.solve.study import METHODS, OURS, SolveStudy, errors_of, unstable
from comparisons.bench.solve.tables import left_out_table, methods_table
from comparisons.kit.progress import Progress
from scenes import run_modes

QUIET = Progress(step=lambda name: None, stage=lambda stage: None)


@pytest.fixture
def unlimited(monkeypatch):
    """Answers in this process, whose memory is not limited."""
    monkeypatch.setattr(memory, "limit", lambda size: None)


@pytest.fixture(scope="module")
def record():
    """A study whose methods run in this process; that of scipy fails."""

    def asked(module, question, folder, *, ranks, seconds):
        if question["method"] == "scipy_arpack":
            raise ConvergenceError("took more than 1 s")
        return process.answer(dict(question))

    kept = [m for m in METHODS if m.modes in (0, 100)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(memory, "limit", lambda size: None)
        patch.setattr(study, "asked", asked)
        patch.setattr(study, "METHODS", tuple(kept))
        return study.run_solve(SolveStudy("tiny"), QUIET)


def test_matrices_from_files_have_the_modes_of_the_scene(tmp_path):
    scene = scene_of_size("tiny")
    size = write_matrices(scene, tmp_path)
    problem = Problem.read(tmp_path, None)
    found = process.import_module("comparisons.bench.solve.methods.this_driver").solve(problem)
    own = run_modes(scene)
    assert size == own.system.size
    lambdas = np.sort_complex(-found.kappa)
    assert lambdas == pytest.approx(np.sort_complex(own.eigenvalues**2), rel=1e-8)


def test_methods_agree_and_projection_is_off(record):
    by_name = {method["name"]: method for method in record["methods"]}
    full = [by_name[OURS], by_name["SLEPc Krylov-Schur"]]
    for method in full:
        assert max(method["errors"]) < 1e-8
        assert max(method["backward_errors"]) < 1e-8
        assert method["missing"] == 0
    assert len({method["unstable"] for method in full}) == 1
    assert full[0]["unstable"] > 0
    projected = by_name["100 real modes"]
    assert 1e-6 < max(projected["errors"]) < 0.1
    assert record["tightest"] in {method["name"] for method in full}


def test_time_is_told_in_factorisations(record):
    for method in record["methods"]:
        if not method["failed"]:
            assert method["lu"][0] > 1e-4  # a factorisation that was made, not one kept
            assert method["counts"]["factorisations"] >= 1
            assert method["peak"] >= method["before"] > 0


def test_a_study_is_stored_drawn_and_told(record, tmp_path):
    text = REPORT.write(record, tmp_path).read_text()
    assert (tmp_path / "error_against_time.png").is_file()
    assert "SLEPc Krylov-Schur" in text
    assert len(methods_table(record).rows) == 3
    assert left_out_table(record).rows == [("scipy eigs, SuperLU", "took more than 1 s")]
    assert REPORT.write(REPORT.read(tmp_path), tmp_path / "again").read_text() == text


def test_errors_are_those_of_pairs():
    exact = np.array([1.0, 2.0, 4.0]) + 0j
    errors, missing = errors_of(np.array([4.4, 1.0 + 0j]), exact)
    assert sorted(errors) == pytest.approx([0, 0.1])
    assert missing == 1


def test_a_complex_pair_has_one_mode_that_grows():
    pair = -((np.array([1e3j + 1, 1e3j - 1])) ** 2)
    assert unstable(np.append(pair, 1e6)) == 1


@pytest.mark.parametrize(
    ("change", "field"),
    [({"size": "huge"}, "size"), ({"ranks": 0}, "ranks"), ({"memory": 0.0}, "memory")],
)
def test_a_wrong_study_is_refused(change, field):
    with pytest.raises(InputError) as caught:
        SolveStudy(**change)
    assert caught.value.field == field


def test_a_method_that_must_be_told_how_many_refuses_to_guess():
    problem = Problem(None, None, None, 1.0, None)
    with pytest.raises(InputError, match="wanted"):
        _ = problem.count


@pytest.mark.slow
@pytest.mark.mpi
@pytest.mark.parametrize("method", ["this_driver", "slepc_krylov_schur", "projection"])
def test_methods_give_the_same_on_two_ranks(method, tmp_path, unlimited):
    write_matrices(scene_of_size("tiny"), tmp_path)
    modes = 60 if method == "projection" else 0
    question = {"method": method, "modes": modes, "folder": str(tmp_path), "wanted": 20}
    question["memory"] = 8 * 10**9
    one = process.answer(dict(question))
    two = launch.asked("comparisons.bench.solve.process", question, tmp_path, ranks=2, seconds=300)
    serial, parallel = (np.array(answer["eigenvalues"]) @ [1, 1j] for answer in (one, two))
    errors, missing = errors_of(parallel, serial)
    assert len(parallel) == len(serial)
    assert missing == 0
    assert max(errors) < 1e-7


@pytest.mark.slow
def test_a_process_that_ends_in_want_of_memory_or_time_says_so(tmp_path):
    question = {"method": "this_driver", "modes": 0, "folder": str(tmp_path), "wanted": None}
    with pytest.raises(ConvergenceError, match="ended with code"):
        launch.asked(
            "comparisons.bench.solve.process",
            question | {"memory": 10**6},
            tmp_path,
            ranks=1,
            seconds=100,
        )
    with pytest.raises(ConvergenceError, match="took more than"):
        launch.asked("comparisons.bench.solve.process", question, tmp_path, ranks=1, seconds=0.01)
