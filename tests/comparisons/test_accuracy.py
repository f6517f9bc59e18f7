"""The study of accuracy: exact lists, cases, honest measuring, what its page says."""

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from reference_data import both_signs, eigenvalues, stored

from cea.errors import ConvergenceError
from comparisons.accuracy import errors
from comparisons.accuracy import study as page
from comparisons.accuracy.cases import Options, estimated_dofs, methods, refinements, scene_of
from comparisons.accuracy.problems import PROBLEMS, exact
from comparisons.accuracy.study import STUDY
from comparisons.study.matching import match_spectrum
from comparisons.study.result import StudyResult, read
from comparisons.study.run import run
from comparisons.study.session import Session
from exact_cea.reference import exact_eigenvalues
from scenes import load_scene, run_modes


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
    p = stiffness * PROBLEMS[name].unit
    family = exact_eigenvalues(name.removesuffix("_3d"), max_frequency=top, p=p, **parameters)
    values = exact(name, stiffness)
    assert len(family)
    match = match_spectrum(values, family)
    assert not len(match.missing)
    assert match.errors.max() < 1e-9
    if name == "blocks":  # one harmonic is all
        assert (values.imag <= top).sum() == len(family)


def test_a_stored_list_is_not_taken_for_other_parameters(monkeypatch):
    other = replace(PROBLEMS["blocks"], mu=0.3, band=(0.0, 2.0))
    monkeypatch.setitem(PROBLEMS, "blocks", other)
    values = exact.__wrapped__("blocks", 1.0)
    expected = exact_eigenvalues("blocks", max_frequency=2.3, p=1.0, mu=0.3)
    np.testing.assert_allclose(values, expected, rtol=1e-12, atol=1e-12)


def test_every_method_of_every_problem_is_a_scene():
    for chosen, method in product(PROBLEMS.values(), methods()):
        scene = scene_of(chosen, method | {"p": 10.0}, 2)
        contact = scene.contacts["interface"]
        assert contact.p == 10 * chosen.unit
        assert contact.full_pass == (method["rule"] == "GPTS, full pass")
        assert scene.analysis.max_frequency > chosen.band[1] / (2 * np.pi)
        assert [side.partition(".")[0] for side in (contact.a, contact.b)] == list(chosen.bodies)
        for name, coarsest in chosen.bodies.items():
            mesh = getattr(scene.bodies[name].mesh, method["backend"])
            assert mesh.elements == tuple(2 * n for n in coarsest)
            assert np.max(mesh.degree) == method["degree"]


BLOCKS = {"problem": "blocks", "p": 1.0, "backend": "fe", "degree": 2, "rule": "mortar"}


def test_a_line_has_as_many_meshes_as_asked_for():
    every = refinements(BLOCKS, Options(levels=99))
    assert refinements(BLOCKS, Options(levels=1)) == every[:1]
    assert refinements(BLOCKS, Options(levels=2)) == [every[0], every[-1]]
    stiff, both = BLOCKS | {"p": 10.0}, Options(levels=1, stiffnesses=(1.0, 10.0))
    assert refinements(stiff, both) == every[:1]


def test_a_mesh_is_measured():
    case = BLOCKS | {"backend": "iga", "degree": 3, "rule": "GPTS"}
    chosen = PROBLEMS["blocks"]
    row = errors.measure(case, 2, repeats=2)
    assert row["dofs"] <= estimated_dofs(chosen, case, 2)
    assert row["points"] == 4 * 2 * 4
    assert 0 < row["assembly"] < row["seconds"]
    values = exact("blocks", 1.0).imag
    assert row["modes"] == np.sum((values >= chosen.band[0]) & (values <= chosen.band[1]))
    assert row["missing"] == row["spurious"] == 0
    assert 1e-6 < row["lambda_median"] < row["lambda_worst"] < 0.02
    json.dumps(row, allow_nan=False)
    found = errors.errors(np.array([1.01j, 5j]), np.array([1j, 2j]), (0.0, 6.0))
    assert found["lambda_worst"] is found["lambda_median"] is None
    assert (found["modes"], found["missing"], found["spurious"]) == (2, 1, 1)


def test_a_line_ends_where_a_mesh_fails(monkeypatch):
    case = BLOCKS | {"problem": "drum"}
    first, second, *_ = refinements(case, Options())

    def measure(case, refinement, repeats):
        if refinement == second:
            raise ConvergenceError("no luck")
        return {"refinement": refinement}

    monkeypatch.setattr(errors, "measure", measure)
    found = errors.evaluate(case, Session(Options()))
    assert [row["refinement"] for row in found["runs"]] == [first]
    assert found["omissions"] == [{"refinement": second, "reason": "no luck"}]


def test_lines_run_in_a_process_and_are_shown(tmp_path):
    options = Options(problems=("blocks",), most_dofs_2d=900, levels=2, repeats=1)
    only = {"degree": "2", "rule": "mortar", "backend": "iga"}
    result = run(STUDY, options, tmp_path, only=only)
    assert result.failed().empty
    assert set(result.frame()["p"]) == {1.0, 0.1, 10.0, 1000.0}


@pytest.mark.grid(quick=1)
def test_axisymmetric_modes_do_not_grow(backend):
    """Friction does no work on them: the modes of the drum next to exact ones of order zero."""
    method = {"p": 1.0, "backend": backend, "degree": 2, "rule": "mortar"}
    scene = scene_of(PROBLEMS["drum"], method, 3).change("contacts.interface.mu", 0.9)
    modes = run_modes(scene).modes
    exact_ones = exact_eigenvalues("drum", m=0, max_frequency=2.5, p=1.0, mu=0.9)
    near = np.abs(modes.eigenvalues[:, None] - exact_ones).argmin(axis=0)
    assert np.abs(modes.eigenvalues[near] / exact_ones - 1).max() < 0.05
    assert (np.abs(modes.growth_rates[near]) <= modes.growth_uncertainties[near]).all()


def test_orders_are_those_of_theory():
    """Where theory knows one: of NURBS and Lagrange elements of degree 2 and 3, within a half."""
    found = page.orders(read(STUDY.name, STUDY.shipped))
    found = found.query("p == 1 and degree in (2, 3) and problem == 'blocks'")
    found = found.dropna(subset="theory")
    assert len(found) == 8
    assert ((found["order"] - found["theory"]).abs() < 0.6).all(), found


def made(*rows):
    """A result of runs at p = 1 on blocks with elements of degree 2."""
    cases = []
    for rule, refinement, error in rows:
        row = {"refinement": refinement, "growth_worst": error}
        cases.append({"labels": BLOCKS | {"rule": rule}, "tables": {"runs": [row]}})
    return StudyResult({"cases": cases, "inputs": {"stiffnesses": [1.0]}})


@pytest.mark.parametrize(
    ("error", "floor", "usable"),
    [(0.009, 1e-4, [True]), (0.03, 0.02, [True]), (0.05, 0.02, [False]), (0.3, 0.2, [])],
)
def test_a_rule_is_usable_where_its_yardstick_is_hardly_better(error, floor, usable):
    found = page.uses(made(("mortar", 4, floor), ("grid", 4, error)))
    assert found.loc[found["rule"] == "grid", "usable"].tolist() == usable


def test_lost_modes_are_never_usable_and_a_failed_yardstick_gives_way():
    yardsticks = ("mortar", 2, 0.05), ("segments", 4, 0.01)
    result = made(*yardsticks, ("grid", 2, 0.01), ("grid", 4, None))
    found = page.uses(result).set_index("rule").loc["grid"]
    assert (found["refinement"], found["yardstick"], found["usable"]) == (4, "segments", False)
    assert page.matrix(result)[1.0].tolist() == ["✗ modes lost", "0.010"]


FINEST = {
    ("drum", "iga"): (8, {"outer": [19, 48], "inner": [13, 52]}, 1e-10),
    ("drum", "fe"): (4, {"outer": [24, 56], "inner": [17, 60]}, 1e-8),
    ("blocks", "iga"): (8, {"upper": [23, 6], "lower": [16, 8]}, 1e-10),
    ("blocks", "fe"): (4, {"upper": [28, 7], "lower": [17, 8]}, 1e-8),
}
"""Degree and elements of fine meshes, and the error of lambda."""


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("problem", "p", "mu"),
    [("blocks", 1.0, 0.7), ("blocks", 0.1, 0.7)]
    + [pytest.param("drum", *values, marks=pytest.mark.slow)
       for values in product((0.1, 1000.0), (0.3, 0.7))],
)  # fmt: skip
def test_every_listed_eigenvalue_is_found_to_its_digits(problem, p, mu, backend):
    degree, meshes, bound = FINEST[problem, backend]
    families = [
        both_signs(eigenvalues(each), each.get("m", 0))
        for each in stored({"drum": "drum_2d", "blocks": "blocks_sine_mu"}[problem])
        if (float(each["p"]), float(each.get("mu", each.get("mu0")))) == (p, mu)
        and not each.get("kz")
        and each.get("m") in (None, 1, 2, 3, 4, 5, 6)
    ]
    assert families
    highest = 1.02 * max(values.imag.max() for values in families)
    fine = {"fe": {"degree": degree, "cell": "quadrilateral"}, "iga": {"degree": [degree] * 2}}
    changes = {
        f"bodies.{body}.mesh.{backend}": fine[backend] | {"elements": elements}
        for body, elements in meshes.items()
    }
    changes["contacts.interface.formulation"] = {"method": "mortar"}
    changes["contacts.interface.p"] = p
    changes["contacts.interface.mu"] = mu if problem == "drum" else f"{mu}*sin(pi*x/2)"
    changes["analysis.max_frequency"] = highest / (2 * np.pi)
    found = run_modes(load_scene(problem, backend=backend).change(changes)).eigenvalues
    for values in families:
        match = match_spectrum(found, values, (0.0, highest), reach=1e-3)
        assert not len(match.missing)
        assert match.errors.max() < bound
