"""Stored numbers are still those of the program: of each stored file something cheap is run anew.

What is stored cannot outlive what made it: seconds, versions and rounding errors (residuals) may
differ, nothing else.
"""

import numpy as np
import pytest
from same_numbers import assert_same

from comparisons.accuracy.errors import measure
from comparisons.accuracy.problems import PROBLEMS
from comparisons.accuracy.study import STUDY as ACCURACY
from comparisons.reference.study import LEVELS, STUDY, graded_scene
from comparisons.study.result import read
from scenes import run_modes

DIGITS = 5e-4
"""The study of accuracy keeps four digits."""


@pytest.mark.slow
@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_case_of_each_problem_has_its_stored_errors(problem, backend):
    """That which was fastest, of those that find every mode."""
    runs = read(ACCURACY.name, ACCURACY.shipped).frame()
    runs = runs[(runs["problem"] == problem) & (runs["backend"] == backend)]
    expected = runs.dropna(subset="lambda_worst").sort_values("seconds").to_dict("records")[0]
    found = measure(expected, expected["refinement"], repeats=1)
    kept = ("dofs", "points", "modes", "missing", "spurious", "lambda_worst", "growth_median")
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
