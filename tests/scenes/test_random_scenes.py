"""Random small scenes agree with dense eigenvalues, in what they list and in what they conclude."""

import numpy as np
import pytest
from blocks import rectangle
from random_runs import judged, outcome_of_scene, scene_outcome

from scenes.spec.reading import read_scene

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
    """A full pass of mortar on meshes that hardly differ, 1e12 times as stiff as the base.

    One sum of closures has a size of 1e-6, so that its compliance and that of the bodies are about
    equal; a factorisation alone has four digits of them.
    """
    angle, size = 357.424, [0.470255, 1.45505831845]
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    upper = rectangle("iga", size, [4, 1], origin=[-size[0], 0.0])
    upper |= {"material": {"E": 0.0522248, "nu": 0.3, "rho": 1.14917}}
    upper |= {"supports": [{"surface": "y_max"}], "placement": {"angle": angle}}
    base = rectangle("iga", [3.0, 1.0], [5, 1], origin=[-1.5, -1.0])
    base |= {"material": {"E": 0.00417021, "nu": 0.3, "rho": 0.56096}}
    base |= {"placement": {"angle": angle}}
    contact = {
        "a": "upper.y_min",
        "b": "base.y_max",
        "formulation": {"method": "mortar"},
        "full_pass": True,
        "p": 3.12564e9,
        "mu": 1e-12,
        "friction_direction_on_a": {"vector": [c, s]},
    }
    data = {
        "name": "nearly dependent",
        "bodies": {"upper": upper, "base": base},
        "contacts": {"between": contact},
        "analysis": {"kind": "cea", "max_frequency": 0.164527},
    }
    judged([read_scene(data)], lambda scene: outcome_of_scene(scene.name, scene))


@pytest.mark.slow
def test_a_thousand_random_scenes():
    outcomes = judged(range(1000), scene_outcome)
    assert sum(outcome.refused is not None for outcome in outcomes) <= _REFUSED * len(outcomes)
    assert not any(outcome.unsure for outcome in outcomes)
    assert {outcome.verdict for outcome in outcomes} >= {"stable", "unstable"}
