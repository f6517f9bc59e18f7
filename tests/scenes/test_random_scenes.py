"""Random small scenes agree with dense eigenvalues, in what they list and in what they conclude."""

import time

import pytest
from random_runs import scene_outcome, statistics, tell

FIRST = 20_000
"""Seed of the first scene."""
CHUNK = 10
_REFUSED = 0.08
"""Part of the scenes that may be refused: random ones ask for what cannot be had."""


def _judged(first, count):
    """Run so many scenes; faults in any of them, told together, are a failure."""
    begin = time.process_time()
    outcomes = [scene_outcome(seed) for seed in range(first, first + count)]
    seconds = time.process_time() - begin
    told = f"{count} random scenes from seed {first} in {seconds:.1f} s\n{statistics(outcomes)}"
    tell(told)
    assert not any(outcome.faults for outcome in outcomes), "\n".join(
        [told, *(str(outcome) for outcome in outcomes if outcome.faults)]
    )
    return outcomes


@pytest.mark.parametrize(
    "chunk", [0, *(pytest.param(chunk, marks=pytest.mark.slow) for chunk in range(1, 10))]
)
def test_a_hundred_random_scenes(chunk):
    _judged(FIRST + CHUNK * chunk, CHUNK)


@pytest.mark.slow
def test_a_thousand_random_scenes():
    outcomes = _judged(0, 1000)
    assert sum(outcome.refused is not None for outcome in outcomes) <= _REFUSED * len(outcomes)
    assert not any(outcome.unsure for outcome in outcomes)
    assert {outcome.verdict for outcome in outcomes} >= {"stable", "unstable"}
