"""Random pencils with multiple eigenvalues agree with dense eigenvalues, every copy counted."""

import time

import pytest
from random_runs import matrix_outcome, statistics, tell


def _judged(seeds):
    begin = time.process_time()
    outcomes = [matrix_outcome(seed) for seed in seeds]
    seconds = time.process_time() - begin
    told = f"{len(seeds)} random pencils, {seeds}, in {seconds:.1f} s\n{statistics(outcomes)}"
    tell(told)
    wrong = [str(outcome) for outcome in outcomes if outcome.faults or outcome.refused]
    assert not wrong, "\n".join([told, *wrong])


def test_twelve_random_pencils():
    _judged(range(12))


@pytest.mark.slow
def test_a_thousand_random_pencils():
    _judged(range(1000))
