"""Problems that cannot flutter: what grows there is rounding, and the results say so."""

import numpy as np
import pytest
from blocks import FORMULATIONS, rectangle
from covering import covering

from scenes import run_scene
from scenes.spec.reading import read_scene

SOFT = {"E": 0.1, "nu": 0.25, "rho": 0.35}


def layer(backend, low, fixed):
    """One of two layers that mirror each other in y = 0."""
    sides = [{"surface": name, "components": ["x"]} for name in ("x_min", "x_max")]
    body = rectangle(backend, [2.0, 0.5], [9, 3], origin=[0.0, low], material=SOFT)
    body["mesh"]["iga"] = {"degree": [3, 3], "elements": [11, 3]}
    return body | {"supports": [{"surface": fixed}, *sides]}


def mirrored_layers(backend, formulation, **contact):
    return {
        "name": "mirrored layers",
        "bodies": {
            "upper": layer(backend, 0.0, "y_max"),
            "lower": layer(backend, -0.5, "y_min"),
        },
        "contacts": {
            "interface": {
                "a": "upper.y_min",
                "b": "lower.y_max",
                "formulation": formulation,
                "p": 1.0,
                "mu": "0.9*sin(pi*x/2)",
                "friction_direction_on_a": {"vector": [1.0, 0.0]},
            }
            | contact
        },
        "analysis": {"kind": "cea", "max_frequency": 0.6},
    }


@pytest.mark.parametrize(
    ("full_pass", "backend", "formulation"),
    covering((False, True), ("fe", "iga"), FORMULATIONS, strength=1),
    indirect=["formulation"],
)
def test_layers_that_mirror_each_other_do_not_flutter(backend, formulation, full_pass):
    """Even modes load the contact, odd ones slide: friction couples them one way only.

    The spectrum is that without friction, though the matrices are not symmetric.
    """
    data = mirrored_layers(backend, formulation, full_pass=full_pass)
    modes = run_scene(read_scene(data)).modes
    assert len(modes.eigenvalues) > 15
    assert not modes.unstable(0.0).any()
    assert np.all(np.abs(modes.growth_rates) <= modes.growth_uncertainties)
    without = mirrored_layers(backend, formulation, full_pass=full_pass, mu=0.0)
    expected = run_scene(read_scene(without)).modes.eigenvalues
    assert modes.eigenvalues.imag == pytest.approx(expected.imag, rel=1e-6)
