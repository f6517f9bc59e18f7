"""`cea bench assembly`: what programs are asked, what they give, what is shown of it."""

import json
import sys
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scipy.sparse import csr_array

from cea.errors import InputError
from comparisons.bench.annulus import EXACT_VOLUME, MATERIAL, Discretisation
from comparisons.bench.assembly import study
from comparisons.bench.assembly.catalogue import ENTRANTS, OURS, Entrant, discretisations
from comparisons.bench.assembly.page import REPORT
from comparisons.bench.assembly.programs.checks import checked, of_every_component
from comparisons.bench.assembly.programs.measured import answers
from comparisons.bench.assembly.study import AssemblyStudy
from comparisons.bench.assembly.tables import apart, left_out_table, ratio, times_table
from comparisons.bench.rigid import motion_fields, rigid_motions
from comparisons.cli.app import main
from comparisons.kit.progress import Progress
from comparisons.kit.worker import Worker, WorkerError

BOXES = (2, 3, 1)
QUIET = Progress(step=lambda name: None, stage=lambda stage: None)


def given(program, discretisation):
    """What the matrices of a program give; skips where it is not installed."""
    if not program.installed:
        pytest.skip(f"{program.needs} is not installed")
    return answers()("check", program.path, discretisation, 4)


PAIRS = [
    pytest.param(program, family, id=f"{program.module}-{family}")
    for program in ENTRANTS[1:]
    for family in program.degrees
]


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(("program", "family"), PAIRS)
def test_programs_give_the_same_matrices(program, family):
    discretisation = Discretisation(family, 2, BOXES)
    theirs = given(program, discretisation)
    ours = given(ENTRANTS[0], discretisation)
    distance = apart(theirs, ours)
    assert distance["inertia"] < 1e-12
    assert distance["eigenvalues"] < 1e-11
    assert theirs["rigid"] < 1e-12
    assert theirs["asymmetry"] < 1e-14


@pytest.mark.parametrize(("family", "degree"), [("Q", 1), ("P", 3), ("NURBS", 3)])
def test_a_free_body_has_its_mass_and_no_force_in_rigid_motion(family, degree):
    found = given(ENTRANTS[0], Discretisation(family, degree, BOXES))
    assert found["rigid"] < 1e-12
    assert found["asymmetry"] == 0
    mass, *others = found["inertia"][:3]
    assert others == pytest.approx([mass, mass], rel=1e-13)
    if family == "NURBS":  # Gauss points integrate the rational Jacobian nearly
        assert mass / MATERIAL.rho == pytest.approx(EXACT_VOLUME, rel=1e-4)
    else:
        chords = np.sin(np.pi / 6) / (np.pi / 6)  # three straight edges round a quarter
        assert mass / MATERIAL.rho == pytest.approx(chords * EXACT_VOLUME, rel=1e-13)
    assert min(found["eigenvalues"]) > 0.01


def test_wrong_matrices_are_seen():
    found = given(ENTRANTS[0], Discretisation("Q", 1, BOXES))
    points = np.random.default_rng(0).random((4, 3))
    K = np.diag(np.arange(1.0, 13.0))
    K[0, 1] = 2.0
    seen = checked(csr_array(K), csr_array(np.eye(12)), rigid_motions(points))
    assert seen["rigid"] > 0.05
    assert seen["asymmetry"] == pytest.approx(2 / 12)
    worse = found | {"eigenvalues": [1.01 * value for value in found["eigenvalues"]]}
    assert apart(worse, found)["eigenvalues"] == pytest.approx(0.01)


def test_rigid_motions_are_the_same_as_values_and_as_functions():
    points = np.random.default_rng(1).random((5, 3))
    values = np.stack([motion(points.T) for motion in motion_fields()], axis=-1)
    assert np.allclose(rigid_motions(points), values.transpose(1, 0, 2).reshape(-1, 6), atol=0)
    assert np.allclose(rigid_motions(points, "blocked"), values.reshape(-1, 6), atol=0)


def test_the_mass_of_one_component_stands_for_all():
    M = csr_array(np.array([[2.0, 1.0], [1.0, 3.0]]))
    whole = of_every_component(M, 6).toarray()
    assert np.array_equal(whole[::3, ::3], M.toarray())
    assert np.array_equal(whole[2::3, 2::3], M.toarray())
    assert not whole[::3, 1::3].any()
    assert of_every_component(M, 2) is M


@pytest.mark.slow
def test_memory_and_time_of_an_assembly_are_told():
    worker = Worker(answers)  # this process has freed memory, which no new peak would show
    try:
        question = ("time", ENTRANTS[0].path, Discretisation("Q", 2, (6, 6, 4)))
        found = worker.ask(*question, seconds=120)
    finally:
        worker.end()
    assert found["dofs"] == 3 * 13 * 13 * 9
    assert found["finished"] > 12 * found["dofs"]
    assert 0 < found["peak"] < 100 * found["finished"]
    assert found["stiffness"] > 0
    assert found["mass"] > 0


class Here:
    """A program that answers in this process: what processes of their own do, without them."""

    def __init__(self, make):
        self._answer = make()

    def ask(self, *question, seconds):
        """Answer; what a process could not do is a failure, as from there."""
        try:
            return self._answer(*question)
        except ImportError as error:
            raise WorkerError(str(error)) from error

    def end(self):
        """Nothing to end."""


@pytest.fixture(scope="module")
def record():
    """A study of two discretisations, one program of which fails."""
    broken = Entrant("broken", "missing", {"Q": (1,)})
    absent = Entrant("absent", "missing", {"Q": (1,)}, "a_package_that_is_nowhere")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "Worker", Here)
        patch.setattr(study, "ENTRANTS", (*ENTRANTS[:2], broken, absent))
        return _run()


def _run():
    *_, whole = study.run_assembly(
        AssemblyStudy(
            ("Q1", "NURBS2"), boxes=(2, 2, 1), checked_boxes=(2, 1, 1), modes=2, repeats=2
        ),
        QUIET,
    )
    return whole


@pytest.mark.slow
def test_a_study_is_stored_drawn_and_told(record, tmp_path):
    page = REPORT.write(record, tmp_path)
    text = page.read_text()
    assert REPORT.read(tmp_path)["runs"] == record["runs"]
    assert {"times.csv", "checks.csv", "times.png", "memory.png"} <= {
        file.name for file in tmp_path.iterdir()
    }
    assert "NURBS2" in text
    assert "![times](times.png)" in text
    first = REPORT.write(REPORT.read(tmp_path), tmp_path / "again").read_text()
    assert first == text
    assert len(times_table(record).rows) == 3


@pytest.mark.slow
def test_what_fails_or_is_missing_is_named(record):
    reasons = {row[1]: row[2] for row in left_out_table(record).rows}
    assert "a_package_that_is_nowhere" in reasons["absent"]
    assert "missing" in reasons["broken"]


def test_ratios_are_to_the_yardstick_of_the_same_round():
    run = {"stiffness": [4.0, 9.0], "mass": [2.0, 3.0], "elements": 3, "yardstick": [1.0, 2.0]}
    assert ratio(run) == 2.0


def test_degree_4_has_a_coarser_body():
    found = discretisations(["Q3", "Q4", "NURBS4"], (4, 4, 2), (2, 2, 1))
    assert [each.boxes for each in found] == [(4, 4, 2), (2, 2, 1), (4, 4, 2)]
    assert replace(found[0], family="P").elements == 6 * 32


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"only": ("Q9",)}, "only"),
        ({"programs": ("abacus",)}, "programs"),
        ({"repeats": 0}, "repeats"),
        ({"boxes": (0, 1, 1)}, "boxes"),
        ({"modes": 0}, "modes"),
    ],
)
def test_a_wrong_study_is_refused(change, field):
    with pytest.raises(InputError) as caught:
        AssemblyStudy(**change)
    assert caught.value.field == field


def test_every_program_has_its_module():
    for each in ENTRANTS[:3]:
        assert callable(import_module(each.path).lay_out)


@pytest.mark.slow
def test_the_command_runs_programs_in_processes_of_their_own(tmp_path, monkeypatch, capsys):
    out = tmp_path / "bench"
    line = ["bench", "assembly", "--only", "Q1", "--program", OURS, "--boxes", "1", "1", "1"]
    monkeypatch.setattr(sys, "argv", ["cea", *line, "--repeats", "1", "--out", str(out)])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code
    (run,) = json.loads((out / "result.json").read_text())["runs"]
    assert (run["discretisation"], run["program"], run["failed"]) == ("Q1", OURS, "")
    assert str(out / "report.md") in capsys.readouterr().out.replace("\n", "")
