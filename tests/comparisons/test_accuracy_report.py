"""Running the study of error against run time, with invented numbers, and its report."""

import gzip
import json
import re
from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest
from typer.testing import CliRunner

from cea.errors import InputError
from comparisons.accuracy import page, words
from comparisons.accuracy.analysis import lines, observed_order, pareto, uses
from comparisons.accuracy.matrix import matrix_lines, matrix_table
from comparisons.accuracy.no_flutter import NO_FLUTTER
from comparisons.accuracy.no_flutter import measure as measure_no_flutter
from comparisons.accuracy.problems import problem
from comparisons.accuracy.runner import run_study
from comparisons.accuracy.study import Method, Study, cases
from comparisons.cli.app import app
from comparisons.kit.numbers import number
from comparisons.kit.worker import WorkerError

TINY = Study(
    stiffnesses=(1.0, 0.1), dofs={2: (1, 400), 3: (1, 1)}, levels=2, repeats=3, minutes=1.0
)


class Invented:
    """Measures without computing: NURBS of degree p have error n^-2p; some rules fail."""

    def __init__(self):
        self.measured = []

    def measure(self, case, exact, repeats, seconds):
        """Invent, or fail."""
        self.measured.append(case)
        if case.method.rule == "grid":
            raise WorkerError("no grid today")
        n, degree = case.refinement, case.method.degree
        error = (2.0 * n) ** (-2 * degree) * (1 if case.method.rule == "mortar" else 30)
        missing = [[0.0, 1.0]] if case.method.rule == "segments" else []
        worst = None if missing else error
        return {
            "dofs": 100 * n**2,
            "points": 10 * n,
            "seconds": [0.01 * n**2 * degree * (1 + 0.1 * i) for i in range(repeats)],
            "stages": {"meshing": 0.01, "assembly": 0.02},
            "memory": 1.5,
            "memory_process": None,
            "modes": 3,
            "missing": missing,
            "spurious": [],
            **{q: {"worst": worst, "median": worst} for q in ("lambda", "frequency", "growth")},
        }


@pytest.fixture(scope="module")
def data():
    """A study of the drum with invented numbers."""
    return run_study(replace(TINY, dofs={2: (1, 1500)}, levels=3), ["drum"], worker=Invented())


def test_every_case_is_a_run_or_an_omission(data):
    study = replace(TINY, dofs={2: (1, 1500)}, levels=3)
    assert len(data["runs"]) + len(data["omissions"]) == len(cases(study, problem("drum")))
    reasons = {o["reason"] for o in data["omissions"]}
    assert reasons == {"no grid today", "a coarser mesh was left out: no grid today"}
    assert {o["method"]["rule"] for o in data["omissions"]} == {"grid"}
    listed = data["problems"]["drum"]["exact"]
    assert [part["stiffness"] for part in listed] == [1.0, 0.1]
    assert all(len(part["lambda"]) > 5 for part in listed)


def test_time_that_one_problem_leaves_is_given_to_the_others(monkeypatch):
    class Slow(Invented):
        def measure(self, case, *others, **times):
            clock[0] += 1.0 if case.problem == "drum" else 0.0
            return super().measure(case, *others, **times)

    clock, worker = [0.0], Slow()
    monkeypatch.setattr("comparisons.accuracy.runner.perf_counter", lambda: clock[0])
    found = run_study(replace(TINY, minutes=0.5), ["drum", "blocks"], worker=worker)
    turns = [name for name, _ in groupby(case.problem for case in worker.measured)]
    assert turns == ["drum", "blocks", "drum"]
    assert found["seconds"] == pytest.approx(31.0)
    told = {o["problem"] for o in found["omissions"] if "time" in o["reason"]}
    assert told == {"drum"}
    runs = len(found["runs"]) + len(found["omissions"])
    assert runs == sum(len(cases(TINY, problem(n))) for n in ("drum", "blocks"))


def test_what_the_time_does_not_allow_is_told(tmp_path):
    worker = Invented()
    none = run_study(replace(TINY, minutes=0.0), ["drum"], worker=worker)
    assert not worker.measured
    assert {o["reason"] for o in none["omissions"]} == {"the time of the study was up"}
    assert "the time of the study was up" in page.write(none, tmp_path).read_text()
    slow = run_study(replace(TINY, case_seconds=0.01), ["drum"], worker=worker)
    assert {o["reason"] for o in slow["omissions"]} >= {"more than 0.01 s expected for its runs"}


def test_observed_order():
    n = [1, 2, 4]
    assert observed_order(n, [3.0 * k**-4 for k in n]) == pytest.approx(4)
    assert observed_order([1], [0.1]) is None


def test_orders_and_theory_of_lines(data):
    found = {(ln.method, ln.stiffness): ln for ln in lines(data["runs"])}
    mortar = found[Method("iga", 3, "mortar"), 1.0]
    assert mortar.order == pytest.approx(6, abs=1e-3)
    assert mortar.theory(None) == 6
    assert mortar.theory(2.0) == 2
    assert found[Method("iga", 2, "gpts"), 1.0].theory(None) is None
    lost = found[Method("iga", 2, "segments"), 1.0]
    assert lost.order is None
    assert np.isnan(lost.errors()).all()


def test_pareto_front_is_what_nothing_beats(data):
    runs = [r for r in data["runs"] if r["lambda"]["worst"] is not None]
    front = pareto(data["runs"])

    def beaten(run):
        seconds, error = np.median(run["seconds"]), run["lambda"]["worst"]
        return any(
            (np.median(r["seconds"]), r["lambda"]["worst"]) != (seconds, error)
            and np.median(r["seconds"]) <= seconds
            and r["lambda"]["worst"] <= error
            for r in runs
        )

    assert not any(beaten(run) for run in front)
    assert len({(np.median(r["seconds"]), r["lambda"]["worst"]) for r in front}) == len(
        {(np.median(r["seconds"]), r["lambda"]["worst"]) for r in runs if not beaten(r)}
    )
    assert len(front) > 2


def test_uses_stand_beside_a_yardstick_on_the_same_mesh(data):
    found = {(u.method, u.stiffness): u for u in uses(data["runs"])}
    use = found[Method("iga", 2, "greville"), 1.0]
    assert use.yardstick == "mortar"
    assert use.error == pytest.approx(30 * use.floor, rel=1e-3)
    assert use.floor == pytest.approx((2.0 * use.refinement) ** -4, rel=1e-3)
    assert use.usable == (use.error <= 0.01)
    assert not found[Method("fe", 2, "segments"), 1.0].usable


def test_the_matrix_says_which_formulation_may_be_used_where(data):
    found = {(u.method.label, u.stiffness): u for u in uses(data["runs"])}
    lines = [line.strip("| ").split(" | ") for line in matrix_lines(data) if line]
    assert lines[0] == ["formulation", "p = 0.1", "p = 1"]
    judged = {row[0]: row[1:] for row in lines[2:] if "yardstick" not in row[0]}
    assert len(judged) > 8
    assert not any("grid" in label for label in judged)  # it gave no numbers
    for label, row in judged.items():
        for p, text in zip((0.1, 1.0), row, strict=True):
            use = found[label, p]
            assert text == f"{'✓' if use.usable else '✗'} {number(use.error, 2)}"
    assert {text[0] for row in judged.values() for text in row} == {"✓", "✗"}
    assert [row[0] for row in lines[2:] if "yardstick" in row[0]] == [
        "*FE 2, yardstick*",
        "*NURBS 2, yardstick*",
    ]
    assert words.in_short(data).count("Usable") == len(set(map(tuple, marks(judged))))


def marks(judged):
    return [[text[0] for text in row] for row in judged.values()]


def test_a_formulation_that_loses_modes_in_one_problem_is_not_usable(data):
    gpts = {"backend": "iga", "degree": 2, "rule": "gpts"}
    runs = [
        run | {"growth": {"worst": None, "median": None}} if run["method"] == gpts else run
        for run in data["runs"]
    ]
    lines = matrix_lines(data | {"runs": runs})
    (line,) = (line for line in lines if "NURBS 2, GPTS |" in line)
    assert line.count("✗ modes lost") == 2
    table = {row[:2]: row for row in matrix_table(data | {"runs": runs}).rows}
    assert table["NURBS 2, GPTS", 1.0][2:5] == ("no", None, "drum")


def test_a_mesh_too_coarse_for_the_yardstick_says_nothing(data):
    greville = Method("iga", 2, "greville"), 1.0
    for floor in (None, 0.5):
        runs = [
            run | {"growth": {"worst": floor, "median": floor}}
            if run["method"]["rule"] == "mortar"
            else run
            for run in data["runs"]
        ]
        assert greville not in {(u.method, u.stiffness) for u in uses(runs)}
    assert greville in {(u.method, u.stiffness) for u in uses(data["runs"])}


@pytest.mark.slow
def test_the_page_is_drawn_anew_without_running(data, tmp_path):
    report = page.write(data, tmp_path)
    files = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert {"report.md", "result.json", "runs.csv", "omissions.csv", "error_drum.png"} <= set(files)
    text = report.read_text()
    assert "## Omissions" in text
    assert "no grid today" in text
    assert text.index("| formulation |") < text.index("## Contents") < text.index("## drum")
    assert "FE 1, segments" in (tmp_path / "incomplete.csv").read_text()  # lost modes
    links = re.findall(r"\]\(([^)#]+)\)", text)
    assert set(links) >= {"matrix.csv", "uses.csv", "orders.csv", "incomplete.csv"}
    assert set(links) <= set(files)
    titles = re.findall(r"^## (.+)$", text, re.MULTILINE)
    anchors = re.findall(r"\]\(#([^)]+)\)", text)
    assert anchors == [title.lower().replace(" ", "-") for title in titles[2:]]
    assert text.count("\n- p = ") == 2
    assert len(files["runs.csv"].splitlines()) == 1 + len(data["runs"])
    for file in tmp_path.iterdir():
        if file.name != "result.json":
            file.unlink()
    result = CliRunner().invoke(app, ["accuracy", "--redraw", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    again = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert again.keys() == files.keys()
    assert all(again[n] == files[n] for n in files if not n.endswith(".png"))


def test_nothing_grows_but_with_lumped_splines():
    layers, drum = NO_FLUTTER
    for still, method in ((layers, Method("fe", 2, "grid")), (drum, Method("iga", 2, "mortar"))):
        run = measure_no_flutter(still, method, refinement=2)
        assert run["unexplained"] == 0
        assert run["growth"] <= run["rounding"] < 1e-10
        assert run["modes"] == {None: 22, 0: 2}[still.order]
    lumped = measure_no_flutter(layers, Method("iga", 2, "gpts_lumped"), refinement=2)
    assert lumped["unexplained"] >= 2
    assert lumped["growth"] > 1e-3


def test_the_page_tells_of_finest_meshes_and_of_what_grew(data, tmp_path):
    finest = {
        **{"problem": "drum", "backend": "iga", "degree": 8, "elements": {"outer": [16, 48]}},
        **{
            "bound": 1e-10,
            "formulation": "mortar",
            "p": 1.0,
            "mu": 0.3,
            "dofs": 100,
            "seconds": 2.0,
            "modes": 9,
        },
        **{"compared": 5, "errors": {}, "worst": 2e-12, "residual": 1e-13, "condition": 2.0},
    }
    still = {
        **{"problem": "layers", "method": {"backend": "iga", "degree": 2, "rule": "mortar"}},
        **{"modes": 20, "growth": 0.0, "rounding": 1e-14, "unexplained": 0},
    }
    grown = still | {"unexplained": 3, "growth": 0.05}
    runs = [
        finest,
        finest | {"worst": 3e-10},
        finest | {"problem": "ring", "worst": None},
        finest | {"problem": "blocks"},
    ]
    text = page.write(data | {"finest": runs, "no_flutter": [still, grown]}, tmp_path).read_text()
    assert (
        "**drum, NURBS 8, mortar** (p = 1): 10 eigenvalues, worst error 3.0 · 10⁻¹⁰, not within"
        in text
    )
    assert "some not found in 1 run" in text
    assert (
        "**blocks, NURBS 8, mortar** (p = 1): 5 eigenvalues, worst error 2.0 · 10⁻¹², within"
        in text
    )
    assert "In 1 of 2 runs" in text
    assert "Exception: NURBS 2, mortar (layers) lets 3 modes of 20 grow" in text
    assert 'drum,"NURBS 8, mortar","outer 16, 48"' in (tmp_path / "finest.csv").read_text()


def test_a_compressed_result_is_read(data, tmp_path):
    (tmp_path / "result.json.gz").write_bytes(gzip.compress(json.dumps(data).encode()))
    assert page.read(tmp_path)["runs"] == data["runs"]


def test_redraw_needs_a_result(tmp_path):
    with pytest.raises(InputError, match=r"result\.json"):
        page.read(tmp_path)
    (tmp_path / "result.json").write_text('{"command": "compare"}')
    with pytest.raises(InputError, match="accuracy"):
        page.read(tmp_path)


@pytest.mark.slow
def test_a_tiny_study_from_the_command_line(tmp_path, monkeypatch):
    tiny = Study(
        stiffnesses=(1.0,),
        thorough=False,
        dofs={2: (300, 420)},
        levels=1,
        minutes=0.1,
        case_seconds=20.0,
    )
    monkeypatch.setattr("comparisons.accuracy.study.QUICK", tiny)
    result = CliRunner().invoke(app, ["accuracy", "blocks", "--quick", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    found = page.read(tmp_path)
    assert found["runs"]
    assert all(len(run["seconds"]) == 3 for run in found["runs"])
    assert all(run["lambda"]["worst"] < 0.1 for run in found["runs"] if not run["missing"])
