"""Random small scenes agree with dense eigenvalues, in what they list and in what they conclude."""

from contextlib import suppress

import numpy as np
import pytest
from random_scenes import random_data

from cea.errors import InputError
from comparisons.stability.case import EXPECTED, Reference, Run
from comparisons.stability.dense import dense_eigenvalues
from comparisons.stability.problems import NOT_COMPLETE, OfScene
from comparisons.stability.verdicts import judged
from comparisons.stability.ways import Way
from scenes.spec.problems import SceneError

FIRST, CHUNK = 20_000, 10
"""Seed of the first scene, scenes of a test."""
_REFUSED = 0.08
"""Part of the scenes that may be refused: random ones ask for what cannot be had."""


_ROUNDING = 3e-13
"""Rounding of matrices and of the dense reference, relative to its 24th lowest kappa."""
_DEPENDENT = 1e-7
"""Relative rounding of the dense reference where gaps at more points than a side has traces are
stiff and friction varies along them."""
_RIGID = 2e-4
"""Part of the kappa of the window to which errors of lower modes are relative."""


def judged_by_dense(data, least=_DEPENDENT):
    """Verdict on a run: no mode is missing, none made up or misjudged."""
    values = np.empty(0)
    with suppress(InputError, SceneError):  # it is refused by the run too
        values = dense_eigenvalues(data)
    size, top = np.abs(values) ** 2, (2 * np.pi * data["analysis"]["max_frequency"]) ** 2
    rounding = _ROUNDING * np.sort(size)[:24].max(initial=0.0)
    run = Run(
        row=data["name"],
        way=Way("", ""),
        problem=OfScene(data),
        reference=Reference("dense", lambda: values),
        expected=EXPECTED["honest"],
        tolerance=max(least, rounding / (_RIGID * top)),
    )
    row = judged(run)
    assert row["verdict"] != "WRONG", (data["name"], row)
    told = row["verdict"] == "refused" or NOT_COMPLETE in row["says"]
    assert told or not (row["missing"] or row["spurious"]), (data["name"], row)
    return row["verdict"]


@pytest.mark.parametrize(
    "chunk", [0, *(pytest.param(chunk, marks=pytest.mark.slow) for chunk in range(1, 10))]
)
def test_a_hundred_random_scenes(chunk):
    first = FIRST + CHUNK * chunk
    for seed in range(first, first + CHUNK):
        judged_by_dense(random_data(seed))


def test_closures_that_nearly_depend_on_each_other():
    """A full pass of mortar on meshes that hardly differ, 1e12 times as stiff as the base.

    One sum of closures has a size of 1e-6, so that its compliance and that of the bodies are about
    equal; a factorisation alone has four digits of them.
    """
    angle, length = 357.424, 0.470255
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))

    def body(size, origin, elements, E, rho, supports):
        return {
            "backend": "iga",
            "geometry": {"shape": "rectangle", "size": size, "origin": origin},
            "placement": {"angle": angle},
            "material": {"E": E, "nu": 0.3, "rho": rho},
            "mesh": {"iga": {"degree": [2, 2], "elements": elements}},
            "supports": supports,
        }

    upper = (
        [length, 1.45505831845],
        [-length, 0.0],
        [4, 1],
        0.0522248,
        1.14917,
        [{"surface": "y_max"}],
    )
    lower = [3.0, 1.0], [-1.5, -1.0], [5, 1], 0.00417021, 0.56096, []
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
        "bodies": {"upper": body(*upper), "base": body(*lower)},
        "contacts": {"between": contact},
        "analysis": {"kind": "cea", "max_frequency": 0.164527},
    }
    judged_by_dense(data, least=1e-8)


@pytest.mark.slow
def test_a_thousand_random_scenes():
    verdicts = [judged_by_dense(random_data(seed)) for seed in range(1000)]
    assert verdicts.count("refused") <= _REFUSED * len(verdicts)
    assert verdicts.count("accurate") >= 0.7 * len(verdicts)
