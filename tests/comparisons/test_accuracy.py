"""The study of accuracy: exact lists, cases, honest measuring, what its page says."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cea.errors import ConvergenceError
from comparisons.accuracy import cases
from comparisons.accuracy import study as page
from comparisons.accuracy.cases import Options, refinements, scene_of
from comparisons.accuracy.problems import PROBLEMS, exact
from comparisons.study.matching import match_spectrum
from comparisons.study.result import StudyResult
from comparisons.study.session import Session
from exact_cea.reference import exact_eigenvalues
from scenes import run_modes


@pytest.mark.parametrize(
    ("name", "stiffness", "top", "parameters"),
    [("drum", 1.0, 2.0, {"m": 2, "mu": 0.3}), ("blocks", 1.0, 2.2, {"mu": 1.0})],
)
def test_stored_lists_hold_each_harmonic(name, stiffness, top, parameters):
    """Of one harmonic; test_exact.py compares whole lists."""
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


BLOCKS = {"problem": "blocks", "p": 1.0, "backend": "fe", "degree": 2, "rule": "mortar"}


def test_a_mesh_is_measured():
    case = BLOCKS | {"backend": "iga", "degree": 3, "rule": "GPTS"}
    chosen = PROBLEMS["blocks"]
    row = cases.measure(case, 2, repeats=2)
    assert row["points"] == 4 * 2 * 4
    assert 0 < row["assembly"] < row["seconds"]
    values = exact("blocks", 1.0).imag
    assert row["modes"] == np.sum((values >= chosen.band[0]) & (values <= chosen.band[1]))
    assert row["missing"] == row["spurious"] == 0
    assert 1e-6 < row["lambda_median"] < row["lambda_worst"] < 0.02
    json.dumps(row, allow_nan=False)
    found = cases.errors(np.array([1.01j, 5j]), np.array([1j, 2j]), (0.0, 6.0))
    assert found["lambda_worst"] is found["lambda_median"] is None
    assert (found["modes"], found["missing"], found["spurious"]) == (2, 1, 1)


def test_a_line_ends_where_a_mesh_fails(monkeypatch):
    case = BLOCKS | {"problem": "drum"}
    first, second, *_ = refinements(case, Options())

    def measure(case, refinement, repeats):
        if refinement == second:
            raise ConvergenceError("no luck")
        return {"refinement": refinement}

    monkeypatch.setattr(cases, "measure", measure)
    found = cases.evaluate(case, Session(Options()))
    assert [row["refinement"] for row in found["runs"]] == [first]
    assert found["omissions"] == [{"refinement": second, "reason": "no luck"}]


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


def made(*rows):
    """A result of runs at p = 1 on blocks with elements of degree 2."""
    cases = []
    for rule, refinement, error in rows:
        row = {"refinement": refinement, "growth_worst": error}
        cases.append({"labels": BLOCKS | {"rule": rule}, "tables": {"runs": [row]}})
    return StudyResult({"cases": cases, "inputs": {"stiffnesses": [1.0]}})


def test_rules_are_usable_where_their_yardstick_is_hardly_better():
    """Never with lost modes; a yardstick that failed gives way to the other."""
    yardsticks = ("mortar", 2, 0.05), ("segments", 4, 0.01)
    rules = {"grid": None, "GPTS": 0.019, "GPTS, lumped": 0.03}
    others = [(rule, 4, error) for rule, error in rules.items()]
    result = made(*yardsticks, ("grid", 2, 0.01), *others)
    found = page.uses(result).set_index("rule").loc[[*rules]]
    assert set(found["refinement"]) == {4}
    assert set(found["yardstick"]) == {"segments"}
    assert found["usable"].tolist() == [False, True, False]
    expected = ["✗ modes lost", "✓ 0.019", "✗ 0.030", "0.010"]
    assert page.matrix(result)[1.0].tolist() == expected
