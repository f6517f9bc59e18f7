"""Random small scenes agree with dense eigenvalues, in what they list and in what they conclude."""

from pathlib import Path

import pytest
from random_runs import judged, outcome_of_scene, scene_outcome

from scenes import load_scene

FIRST, CHUNK = 20_000, 10
"""Seed of the first scene, scenes of a test."""
_REFUSED = 0.08
"""Part of the scenes that may be refused: random ones ask for what cannot be had."""


@pytest.mark.parametrize(
    "chunk", [0, *(pytest.param(chunk, marks=pytest.mark.slow) for chunk in range(1, 10))]
)
def test_a_hundred_random_scenes(chunk):
    first = FIRST + CHUNK * chunk
    judged(range(first, first + CHUNK), scene_outcome)


def test_closures_that_nearly_depend_on_each_other():
    file = Path(__file__).parents[1] / "data" / "nearly_dependent.toml"
    judged([load_scene(file)], lambda scene: outcome_of_scene(scene.name, scene))


@pytest.mark.slow
def test_a_thousand_random_scenes():
    outcomes = judged(range(1000), scene_outcome)
    assert sum(outcome.refused is not None for outcome in outcomes) <= _REFUSED * len(outcomes)
    assert not any(outcome.unsure for outcome in outcomes)
    assert {outcome.verdict for outcome in outcomes} >= {"stable", "unstable"}
