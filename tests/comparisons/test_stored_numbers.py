"""Stored numbers are still those of the program: of each stored file something cheap is run anew.

What is stored cannot outlive what made it: seconds, versions and rounding errors (residuals) may
differ, nothing else.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from same_numbers import assert_same

import comparisons.accuracy
from comparisons.accuracy.exact_lists import exact
from comparisons.accuracy.measure import Measurer
from comparisons.accuracy.study import Case, Method
from comparisons.reference.study import LEVELS, STUDY, graded_scene
from comparisons.study.result import read
from scenes import run_modes
from scenes.results.record import read_record

ACCURACY = Path(comparisons.accuracy.__file__).parent / "results" / "result.json.gz"
DIGITS = 5e-4
"""The study of accuracy keeps four digits."""


@cache
def accuracy():
    """The stored study of accuracy."""
    return read_record(ACCURACY)


def cheapest_run(problem, backend):
    """The run that was fastest, of those that find every mode where there are any."""
    return min(
        (
            run
            for run in accuracy()["runs"]
            if (run["problem"], run["method"]["backend"]) == (problem, backend)
        ),
        key=lambda run: (run["lambda"]["worst"] is None, run["seconds"][0]),
    )


@pytest.mark.slow
@pytest.mark.parametrize("problem", accuracy()["problems"])
def test_a_case_of_each_problem_has_its_stored_errors(problem, backend):
    expected = cheapest_run(problem, backend)
    method = Method(**expected["method"])
    case = Case(problem, method, expected["refinement"], expected["stiffness"])
    found = Measurer().measure(case, exact(problem, case.stiffness), repeats=1)
    kept = ("dofs", "points", "modes", "lambda", "frequency", "growth", "missing", "spurious")
    assert_same({key: found[key] for key in kept}, {key: expected[key] for key in kept}, rel=DIGITS)


@pytest.mark.slow
def test_the_cheapest_run_of_the_reference_has_its_stored_modes():
    coarse = f"backend == 'iga' and degree == {LEVELS['iga'][0].degree}"
    stored = read("reference", STUDY.shipped)
    expected = stored.frame("run_modes").query(coarse)
    result = run_modes(graded_scene("iga", LEVELS["iga"][0]))
    assert [result.system.size] == stored.frame("runs").query(coarse)["dofs"].tolist()
    for quantity, values in (
        ("frequency", result.modes.frequencies),
        ("growth", result.modes.growth_rates),
    ):
        kept = expected[quantity].to_numpy()
        np.testing.assert_allclose(values, kept, rtol=1e-8, atol=1e-8 * np.abs(kept).max())
