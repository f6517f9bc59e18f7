"""Rayleigh damping: its factors from damping ratios, and its pieces of the pencil."""

import numpy as np
import pytest
from blocks import assemble, two_blocks
from petsc_matrices import to_numpy

from cea.errors import InputError
from cea.motion import RayleighDamping

GPTS = {"method": "gpts", "points": 3}
ALPHA, BETA = 0.3, 0.07


def scene(backend, *, damping=None, E=2.0, rho=1.5):
    data = two_blocks(backend, GPTS, held=True)
    upper = data["bodies"]["upper"]
    upper["material"] |= {"E": E, "rho": rho}
    upper["springs"] = [{"surface": "x_min", "stiffness": [0.3, 0.2, 0.1]}]
    if damping is not None:
        upper["damping"] = damping
    return assemble(data)


@pytest.mark.parametrize("frequencies", [(100.0, 2500.0), (2500.0, 100.0)])
def test_ratios_are_met_at_their_frequencies(frequencies):
    ratios = (0.02, 0.03)
    damping = RayleighDamping.of_ratios(ratios, frequencies)
    omega = 2 * np.pi * np.array(frequencies)
    found = damping.alpha / (2 * omega) + damping.beta * omega / 2
    assert found == pytest.approx(ratios, rel=1e-14)


@pytest.mark.parametrize("ratios", [(0.01, 0.031), (0.031, 0.01)])
def test_ratios_that_no_damping_has_are_refused(ratios):
    with pytest.raises(InputError, match=r"damping\.ratios"):
        RayleighDamping.of_ratios(ratios, (100.0, 300.0))


def test_the_damping_matrix_is_that_of_the_body(backend):
    damped = scene(backend, damping={"alpha": ALPHA, "beta": BETA})
    matrices = damped.pencil().at()
    n = damped.bodies["upper"].stiffness().getSize()[0]
    expected = np.zeros_like(to_numpy(matrices.mass))
    upper = damped.bodies["upper"]
    expected[:n, :n] = ALPHA * to_numpy(upper.mass()) + BETA * to_numpy(upper.stiffness())
    found = to_numpy(matrices.damping)
    difference = np.abs(found - expected)
    assert (difference <= np.maximum(1e-14 * np.abs(expected), 1e-16)).all()
    assert (found == found.T).all()
    assert matrices.gyroscopic is None
    assert matrices.quadratic


@pytest.mark.parametrize(
    ("change", "options"),
    [
        ({"bodies.upper.damping.alpha": 2.0}, {"damping": {"alpha": 2.0, "beta": BETA}}),
        ({"bodies.upper.damping.beta": 0.0}, {"damping": {"alpha": ALPHA, "beta": 0.0}}),
        ({"bodies.upper.material.E": 5.0}, {"E": 5.0}),
        ({"bodies.upper.material.rho": 0.7}, {"rho": 0.7}),
    ],
)
def test_a_changed_parameter_gives_the_matrices_of_a_changed_scene(backend, change, options):
    damping = {"alpha": ALPHA, "beta": BETA}
    changed = scene(backend, damping=damping).pencil().at(change).damping
    assembled = scene(backend, **{"damping": damping} | options).pencil().at().damping
    expected = to_numpy(assembled)
    assert np.abs(to_numpy(changed) - expected).max() <= 1e-13 * np.abs(expected).max()
