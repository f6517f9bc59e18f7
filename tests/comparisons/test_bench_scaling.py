"""`cea bench scaling`: runs by stage, inverses by factors and by multigrid, the model."""

from dataclasses import replace

import numpy as np
import pytest

from cea.errors import ConvergenceError, InputError
from comparisons.bench import launch
from comparisons.bench.scaling import inverse, process, study
from comparisons.bench.scaling.cases import Case, boxes, cases
from comparisons.bench.scaling.model import RANKS, UNKNOWNS, exponents, needs
from comparisons.bench.scaling.page import REPORT
from comparisons.bench.scaling.study import ScalingStudy
from comparisons.bench.scaling.tables import left_out_table, ranks_table
from comparisons.bench.scaling.words import limit
from comparisons.kit.progress import Progress

QUIET = Progress(step=lambda name: None, stage=lambda stage: None)

TINY = Case("size", 1, *boxes(1.0))


def question(way):
    return {"case": TINY.plain(), "way": way, "shift": 0.0, "wanted": 4, "tolerance": 1e-10}


def made(kind, ranks, unknowns, seconds):
    """A run with the same seconds in two stages."""
    stages = {"assembly": seconds, "factorisation": seconds**2}
    one = {
        "unknowns": unknowns,
        "busiest": stages,
        "processor": stages,
        "whole": sum(stages.values()),
        "longest": sum(stages.values()),
    }
    one |= {"peak": 1e9, "program": 1e8, "eigenvalues": [[0.0, 1.0]]}
    case = replace(TINY, kind=kind, ranks=ranks).plain()
    return {**case, "failed": "", "answers": [one]}


def inverted(way, unknowns, **changes):
    found = {"way": way, "shift": 0.0, "unknowns": unknowns, "setup": 2.0, "solve": 0.1}
    found |= {"steps": 1, "solves": 40, "whole": 5.0, "memory": 1e9, "failed": ""}
    return found | {"kappa": [[1.0, 0.0]], "disc": [3, 16, 1]} | changes


DATA = {
    "command": "bench scaling",
    "inputs": {"wanted": 20},
    "versions": {},
    "commit": "",
    "machine": {},
    "seconds": 1.0,
    "warnings": [],
    "runs": [
        made("size", 1, 1_000, 1.0),
        made("size", 1, 8_000, 8.0),
        made("strong", 1, 8_000, 8.0),
        made("strong", 2, 8_000, 5.0),
        made("weak", 1, 1_000, 1.0),
        made("weak", 2, 2_000, 1.25),
        made("degree", 1, 1_000, 1.0),
        {**made("degree", 1, 1, 1.0), "failed": "took more than 1 s", "answers": []},
    ],
    "inverses": [
        inverted("mumps", 10_000),
        inverted("gamg", 10_000, kappa=[[1.001, 0.0]]),
        inverted("gamg", 10_000, shift=1e9, failed="not solved after 1000 steps of GMRES"),
    ],
}


@pytest.mark.slow
def test_both_inverses_find_the_same_eigenvalues():
    direct, iterative = (inverse.answer(question(way)) for way in study.WAYS)
    for found in (direct, iterative):
        assert found["failed"] == ""
        assert found["solves"] >= 4
    assert direct["steps"] == 1 < iterative["steps"]
    values = [np.array(found["kappa"]) for found in (direct, iterative)]
    assert values[1] == pytest.approx(values[0], rel=1e-6, abs=1e-6 * np.abs(values[0]).max())


def test_a_run_tells_its_stages():
    found = process.answer(TINY.plain())
    assert found["unknowns"] == 3 * (7 * 32 * 3 - 32 * 3 + 5 * 7 * 3 - 5 * 7)
    for name in ("meshing", "assembly", "factorisation", "krylov"):
        assert found["busiest"][name] > 0
    assert found["peak"] >= found["program"]
    assert len(found["eigenvalues"]) > 5


@pytest.mark.slow
@pytest.mark.mpi
def test_a_run_on_two_ranks_has_the_same_eigenvalues(tmp_path):
    one, two = (
        launch.asked(
            "comparisons.bench.scaling.process", TINY.plain(), tmp_path, ranks=n, seconds=300
        )
        for n in (1, 2)
    )
    assert one["unknowns"] == two["unknowns"]
    first, second = (np.array(found["eigenvalues"]) for found in (one, two))
    assert second == pytest.approx(first, rel=1e-6, abs=1e-6 * np.abs(first).max())


def test_rows_differ_in_one_thing_each():
    rows = list(cases("medium", (1, 2)))
    strong = [case for case in rows if case.kind == "strong"]
    weak = [case for case in rows if case.kind == "weak"]
    assert [case.ranks for case in strong] == [case.ranks for case in weak] == [1, 2]
    assert replace(strong[0], ranks=2) == strong[1]
    assert weak[1].disc[1] == 2 * weak[0].disc[1]
    degrees = [(case.backend, case.degree) for case in rows if case.kind == "degree"]
    assert degrees == [*(("fe", q) for q in (1, 2, 3)), *(("iga", p) for p in (2, 3, 4))]


def test_growth_is_the_power_of_the_unknowns():
    runs = [run for run in DATA["runs"] if run["kind"] == "size"]
    assert exponents(runs, "assembly") == pytest.approx([1.0])
    assert exponents(runs, "factorisation") == pytest.approx([2.0])


def test_the_model_is_what_it_says():
    parts = {need.part: need for need in needs(DATA)}
    ratio = UNKNOWNS / 10_000
    setup = parts["MUMPS: setup"]
    assert setup.hours == pytest.approx(2.0 * ratio**2 / RANKS / 3600)
    assert parts["MUMPS: memory"].gigabytes == pytest.approx(ratio ** (4 / 3) / RANKS)
    assert parts["GMRES, multigrid: memory"].gigabytes == pytest.approx(ratio / RANKS)
    solves = parts["GMRES, multigrid: solves for 100 modes"]
    assert solves.hours == pytest.approx(0.1 * 200 * ratio / RANKS / 3600)  # 5 times 40 solves
    assert "MUMPS: memory 3" in limit(DATA)


def test_ratios_are_by_the_clock():
    rows = {(row[0], row[2]): row[-1] for row in ranks_table(DATA).rows}
    assert rows["strong", "assembly"] == pytest.approx(1.6)
    assert rows["weak", "assembly"] == pytest.approx(0.8)


def test_a_study_is_stored_drawn_and_told(tmp_path):
    text = REPORT.write(DATA, tmp_path).read_text()
    assert "A model, no measurement" in text
    assert "not solved after 1000 steps" in text
    assert {"unknowns.png", "degree.png", "needs.csv"} <= {f.name for f in tmp_path.iterdir()}
    assert any("took more than 1 s" in row[1] for row in left_out_table(DATA).rows)


def test_a_run_that_fails_leaves_the_others(monkeypatch, tmp_path):
    def asked(module, question, folder, *, ranks, seconds):
        if ranks == 2 or module.endswith("inverse"):
            raise ConvergenceError("no second core")
        return made("size", 1, 1_000, 1.0)["answers"][0]

    monkeypatch.setattr(study, "asked", asked)
    *before, data = study.run_scaling(ScalingStudy("tiny"), QUIET)
    assert [len(each["inverses"]) for each in before] == [0, 3]  # what a study cut short leaves
    assert before[0]["runs"] == data["runs"]
    assert "no second core" in REPORT.write(before[0], tmp_path).read_text()
    failed = [run for run in data["runs"] if run["failed"]]
    assert {run["ranks"] for run in failed} == {2}
    assert all(run["answers"] for run in data["runs"] if run["ranks"] == 1)
    assert all(found["failed"] == "no second core" for found in data["inverses"])
    assert limit(data) == ""


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"size": "huge"}, "size"),
        ({"ranks": ()}, "ranks"),
        ({"repeats": 0}, "repeats"),
        ({"tolerance": 1.0}, "tolerance"),
    ],
)
def test_a_wrong_study_is_refused(change, field):
    with pytest.raises(InputError) as caught:
        ScalingStudy(**change)
    assert caught.value.field == field
