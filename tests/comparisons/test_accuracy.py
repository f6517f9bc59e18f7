"""The accuracy study: exact lists, cases, honest measuring."""

import json
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from accuracy_workers import failing

from cea.eigen.matching import match_spectrum
from cea.errors import InputError
from comparisons.accuracy.exact_lists import FILE, computed, exact
from comparisons.accuracy.measure import Measurer, errors, peak_memory, start_memory
from comparisons.accuracy.problems import PROBLEMS, problem
from comparisons.accuracy.study import (
    FULL,
    QUICK,
    RULES,
    Case,
    Method,
    cases,
    estimated_dofs,
    methods,
    overrides,
    refinements,
)
from comparisons.accuracy.worker import CaseWorker
from comparisons.kit.worker import WorkerError
from exact_cea.reference import exact_eigenvalues
from scenes.spec.reading import load_scene


@pytest.mark.grid(quick=2)
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
    first = [
        c
        for c in cases(replace(FULL, dofs={2: (1, 400)}, levels=2), problem("drum"))
        if c.stiffness == 1.0
    ]
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
    values, worker = np.array([1j, 2j]), CaseWorker(failing)

    def measure(rule, seconds=30.0):
        return worker.measure(Case("drum", Method("fe", 1, rule), 1, 1.0), values, 4, seconds)

    try:
        assert measure("mortar") == {"threads": "1", "modes": 2, "repeats": 4}
        with pytest.raises(WorkerError, match=r"^ValueError: no nodes here$"):
            measure("node")
        with pytest.raises(WorkerError, match="ended with code 3"):
            measure("grid")
        assert measure("mortar")["modes"] == 2  # in a new process
        with pytest.raises(WorkerError, match=r"more than 0\.2 s"):
            measure("greville", seconds=0.2)
    finally:
        worker.end()
