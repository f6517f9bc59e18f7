"""Random damped, rotating and rubbing pencils agree with dense eigenvalues, verdicts too."""

import time

import pytest
from random_runs import low_rank_outcome, quadratic_outcome, statistics, tell


def _judged(seeds, outcome_of=quadratic_outcome):
    begin = time.process_time()
    outcomes = [outcome_of(seed) for seed in seeds]
    seconds = time.process_time() - begin
    told = f"{len(seeds)} random damped pencils, {seeds}, in {seconds:.1f} s"
    told = f"{told}\n{statistics(outcomes)}"
    tell(told)
    wrong = [str(outcome) for outcome in outcomes if outcome.faults or outcome.refused]
    assert not wrong, "\n".join([told, *wrong])
    assert all(outcome.complete for outcome in outcomes)
    assert sum(outcome.modes for outcome in outcomes) > 3 * len(seeds)


def test_twenty_random_damped_pencils():
    _judged(range(20))


def test_twenty_random_pencils_with_modes_damped():
    _judged(range(20), low_rank_outcome)


@pytest.mark.slow
def test_five_hundred_random_pencils_with_modes_damped():
    _judged(range(500), low_rank_outcome)


@pytest.mark.slow
def test_a_thousand_random_damped_pencils():
    _judged(range(1000))


def test_free_motions_whose_lambda_is_zero_to_the_last_digit_are_modes():
    """Left vectors, which are scaled by lambda, judge them."""
    _judged([226, 496, 939])
