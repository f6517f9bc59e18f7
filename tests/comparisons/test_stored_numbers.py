"""Stored numbers are still those of the program: of each stored file something cheap is run anew.

What is stored cannot outlive what made it: seconds, versions and rounding errors (residuals) may
differ, nothing else.
"""

import pytest
from same_numbers import assert_same

from comparisons.accuracy.errors import measure
from comparisons.accuracy.problems import PROBLEMS
from comparisons.accuracy.study import STUDY as ACCURACY
from comparisons.study.result import read

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
