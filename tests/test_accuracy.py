"""The accuracy study: exact lists, cases, honest measuring, omissions, and what is drawn."""

import gzip
import json
from dataclasses import replace
from itertools import groupby, product
from pathlib import Path

import numpy as np
import pytest
from accuracy_workers import failing
from typer.testing import CliRunner

from cea.errors import InputError
from comparisons.accuracy import page, words
from comparisons.accuracy.analysis import lines, observed_order, pareto, uses
from comparisons.accuracy.lists import FILE, computed, exact
from comparisons.accuracy.measure import Measurer, errors, peak_memory, start_memory
from comparisons.accuracy.problems import PROBLEMS, problem
from comparisons.accuracy.runner import run_study
from comparisons.accuracy.still import STILL
from comparisons.accuracy.still import measure as measure_still
from comparisons.accuracy.study import (
    FULL,
    QUICK,
    RULES,
    Case,
    Method,
    Study,
    cases,
    estimated_dofs,
    methods,
    overrides,
    refinements,
)
from comparisons.accuracy.worker import CaseError, Worker
from comparisons.cli import app
from comparisons.exact.reference import exact_eigenvalues
from comparisons.scene import load_scene
from comparisons.spectra import match_spectrum

TINY = Study(
    stiffnesses=(1.0, 0.1), dofs={2: (1, 400), 3: (1, 1)}, levels=2, repeats=3, minutes=1.0
)


@pytest.mark.parametrize(
    ("name", "stiffness", "top", "parameters"),
    [
        ("drum", 1.0, 2.0, {"m": 2, "mu": 0.3}),
        ("drum", 1000.0, 2.5, {"m": -3, "mu": 0.3}),
        ("drum_3d", 0.1, 2.0, {"m": 1, "mu": 0.7, "kz": "pi"}),
        ("blocks", 1.0, 3.6, {"mu": 1.0}),
        ("blocks_3d", 10.0, 2.8, {"mu": 1.0, "kz": "pi/2"}),
        ("ring", 1.0, 8e4, {"m": 1, "mu": 0.3}),
    ],
)
def test_stored_lists_hold_each_harmonic(name, stiffness, top, parameters):
    p = stiffness * problem(name).unit
    solver = name.removesuffix("_3d")
    family = exact_eigenvalues(solver, max_frequency=top, p=p, **parameters)
    values = exact(name, stiffness)
    assert len(family)
    match = match_spectrum(values, family)
    assert not len(match.missing)
    assert match.errors.max() < 1e-9
    if name == "blocks":  # one harmonic is all
        assert (values.imag <= top).sum() == len(family)


def test_a_stored_list_is_what_is_computed():
    data = computed([problem("blocks")], [10.0])
    assert data["blocks"].keys() == {"parameters", "lists"}
    values = np.array([complex(*value) for value in data["blocks"]["lists"]["10"]])
    np.testing.assert_allclose(exact("blocks", 10.0), values, rtol=1e-12)


def test_every_list_of_the_study_is_stored():
    stored = json.loads(FILE.read_text())
    assert stored.keys() == PROBLEMS.keys()
    for chosen in PROBLEMS.values():
        assert stored[chosen.name]["lists"].keys() == {f"{p:g}" for p in FULL.stiffnesses}
        for p in FULL.stiffnesses:
            values = exact(chosen.name, p)
            assert (values.imag <= chosen.highest_exact).all()
            assert len(chosen.listed(values)) > 5


def test_a_stored_list_is_not_taken_for_other_parameters(monkeypatch):
    other = replace(problem("blocks"), mu=0.3, band=(0.0, 2.0))
    monkeypatch.setitem(PROBLEMS, "blocks", other)
    values = exact.__wrapped__("blocks", 1.0)
    expected = exact_eigenvalues("blocks", max_frequency=2.3, p=1.0, mu=0.3)
    np.testing.assert_allclose(values, expected, rtol=1e-12, atol=1e-12)


def test_exact_lists_hold_mirror_images():
    values = exact("drum", 1.0)
    growing, decaying = values[values.real > 0], values[values.real < 0]
    assert len(growing) == len(decaying) > 5
    assert match_spectrum(-decaying.conj(), growing).errors.max() < 1e-12


def test_problems_are_known_by_name():
    with pytest.raises(InputError, match="one of drum"):
        problem("violin")


def test_every_method_of_every_problem_is_a_scene():
    for chosen, method in product(PROBLEMS.values(), methods()):
        case = Case(chosen.name, method, 2, 10.0)
        scene = load_scene(Path(chosen.name), overrides(chosen, case), method.backend)
        contact = scene.contacts[chosen.contact]
        assert contact.p == 10 * chosen.unit
        assert contact.full_pass == RULES[method.rule].full_pass
        assert scene.analysis.max_frequency > chosen.band[1] / (2 * np.pi)
        for name, body in zip(("a", "b"), chosen.bodies, strict=True):
            assert getattr(contact, name).startswith(body.name + ".")
            mesh = getattr(scene.bodies[body.name].mesh, method.backend)
            assert mesh.elements == body.elements(2)
            degree = mesh.degree if method.backend == "fe" else mesh.degree[0]
            assert degree == method.degree


def test_the_study_holds_every_degree_and_rule():
    for study, chosen in product((FULL, QUICK), PROBLEMS.values()):
        listed = cases(study, chosen)
        assert len(set(listed)) == len(listed)
        assert {case.method.rule for case in listed} == set(RULES)
        assert {case.stiffness for case in listed} == {0.1, 1.0, 10.0, 1000.0}
        fewest, most = study.dofs[chosen.dim]
        wide = chosen.most_dofs or most if study is FULL else most
        for case in listed:
            limit = wide if case.stiffness == study.stiffnesses[0] else most
            assert fewest <= estimated_dofs(chosen, case.method, case.refinement) <= limit
    thorough = {case.method for case in cases(FULL, problem("drum"))}
    assert thorough == set(methods())
    line = refinements(FULL, problem("blocks"), Method("fe", 1, "mortar"))
    assert len(line) == FULL.levels
    assert line == sorted(line)


def test_cheap_meshes_come_before_dear_ones():
    first = [c for c in cases(TINY, problem("drum")) if c.stiffness == 1.0]
    yardsticks = [c.refinement for c in first if c.method == Method("iga", 2, "mortar")]
    assert yardsticks == sorted(yardsticks)
    assert len(yardsticks) > 1


def test_a_case_is_measured():
    case = Case("blocks", Method("iga", 3, "gpts"), 2, 1.0)
    chosen = problem("blocks")
    run = Measurer().measure(case, exact("blocks", 1.0), repeats=3)
    assert run["dofs"] <= estimated_dofs(chosen, case.method, 2)
    assert run["points"] == 4 * 2 * 4
    assert len(run["seconds"]) == 3
    assert sum(run["stages"].values()) == pytest.approx(np.median(run["seconds"]), rel=0.5)
    assert run["stages"]["assembly"] > 0
    # Of one thread, and free of what other processes do meanwhile.
    assert all(s <= 1.1 * c for s, c in zip(run["seconds"], run["clock"], strict=True))
    assert run["modes"] == len(chosen.listed(exact("blocks", 1.0)))
    assert run["missing"] == run["spurious"] == []
    assert 1e-6 < run["lambda"]["median"] < run["lambda"]["worst"] < 0.02
    json.dumps(run, allow_nan=False)


def test_peak_memory_sees_an_allocation():
    before = start_memory()
    if before is None:
        pytest.skip("the system does not tell")
    block = np.ones(20_000_000)
    assert 150 < peak_memory() - before < 300
    del block
    assert start_memory() - before < 50


def test_errors_of_missing_modes_are_not_numbers():
    found = errors(np.array([1.01j, 5j]), np.array([1j, 2j]), (0.0, 6.0))
    assert found["lambda"] == {"worst": None, "median": None}
    assert found["missing"] == [[0.0, 2.0]]
    assert found["spurious"] == [[0.0, 5.0]]


def test_the_worker_outlives_every_failure():
    values, worker = np.array([1j, 2j]), Worker(failing)

    def measure(rule, seconds=30.0):
        return worker.measure(Case("drum", Method("fe", 1, rule), 1, 1.0), values, 4, seconds)

    try:
        assert measure("mortar") == {"threads": "1", "modes": 2, "repeats": 4}
        with pytest.raises(CaseError, match=r"^ValueError: no nodes here$"):
            measure("node")
        with pytest.raises(CaseError, match="ended with code 3"):
            measure("grid")
        assert measure("mortar")["modes"] == 2  # in a new process
        with pytest.raises(CaseError, match=r"more than 0\.2 s"):
            measure("greville", seconds=0.2)
    finally:
        worker.end()


class Invented:
    """Measures without computing: NURBS of degree p have error n^-2p; some rules fail."""

    def __init__(self):
        self.measured = []

    def measure(self, case, exact, repeats, seconds):
        """Invent, or fail."""
        self.measured.append(case)
        if case.method.rule == "grid":
            raise CaseError("no grid today")
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
    said = "\n".join(words.where_each_may_be_used(data))
    assert "NURBS 2, Greville** (drum)" in said
    assert "p = 0.1" in said


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


def test_the_page_is_drawn_anew_without_running(data, tmp_path):
    report = page.write(data, tmp_path)
    files = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert {"report.md", "result.json", "runs.csv", "omissions.csv", "error_drum.png"} <= set(files)
    text = report.read_text()
    assert "## Omissions" in text
    assert "no grid today" in text
    assert "FE 1, segments" in text  # lost modes
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
    layers, drum = STILL
    for still, method in ((layers, Method("fe", 2, "grid")), (drum, Method("iga", 2, "mortar"))):
        run = measure_still(still, method, refinement=2)
        assert run["unexplained"] == 0
        assert run["growth"] <= run["rounding"] < 1e-10
        assert run["modes"] == {None: 22, 0: 2}[still.order]
    lumped = measure_still(layers, Method("iga", 2, "gpts_lumped"), refinement=2)
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
    text = page.write(data | {"finest": runs, "still": [still, grown]}, tmp_path).read_text()
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
    assert "| drum | NURBS 8, mortar | outer 16, 48 |" in text


def test_a_compressed_result_is_read(data, tmp_path):
    (tmp_path / "result.json.gz").write_bytes(gzip.compress(json.dumps(data).encode()))
    assert page.read(tmp_path)["runs"] == data["runs"]


def test_redraw_needs_a_result(tmp_path):
    with pytest.raises(InputError, match=r"result\.json"):
        page.read(tmp_path)
    (tmp_path / "result.json").write_text('{"command": "compare"}')
    with pytest.raises(InputError, match="accuracy"):
        page.read(tmp_path)


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
