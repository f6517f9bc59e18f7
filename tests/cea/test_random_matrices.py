"""Random pencils agree with dense eigenvalues, every copy counted, verdicts too."""

import pytest
from random_runs import judged, low_rank_outcome, matrix_outcome, quadratic_outcome


@pytest.mark.parametrize("seeds", [12, pytest.param(1000, marks=pytest.mark.slow)])
def test_random_pencils_with_multiple_eigenvalues(seeds):
    assert not any(outcome.refused for outcome in judged(range(seeds), matrix_outcome))


def check_damped(seeds, outcome_of):
    outcomes = judged(seeds, outcome_of)
    assert not any(outcome.refused for outcome in outcomes)
    assert all(outcome.complete for outcome in outcomes)
    assert sum(outcome.modes for outcome in outcomes) > 3 * len(seeds)


@pytest.mark.parametrize("seeds", [20, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("outcome_of", [quadratic_outcome, low_rank_outcome])
def test_random_damped_rotating_and_rubbing_pencils(outcome_of, seeds):
    check_damped(range(seeds), outcome_of)


def test_free_motions_whose_lambda_is_zero_to_the_last_digit_are_modes():
    """Left vectors, which are scaled by lambda, judge them."""
    check_damped([226, 496, 939], quadratic_outcome)
