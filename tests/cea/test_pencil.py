"""The parametric pencil: the matrices of a changed scene without assembling it again."""

from copy import deepcopy

import numpy as np
import pytest
from blocks import GPTS, assemble, coarse, two_blocks
from covering import covering
from petsc_matrices import dense_pencil, to_numpy

from cea.errors import InputError
from scenes.spec.plain import set_fields

UPPER, CONTACT = "bodies.upper", "contacts.interface"
CHANGES = [
    *((f"{UPPER}.material.E", 5.0), (f"{UPPER}.material.rho", 0.7)),
    *((f"{UPPER}.damping.alpha", 2.0), (f"{UPPER}.damping.beta", 0.0)),
    *((f"{CONTACT}.P", 40.0), (f"{CONTACT}.mu", 0.9), (f"{CONTACT}.mu", 0.0)),
    *((f"{CONTACT}.sliding.pressure", 7.0), (f"{CONTACT}.sliding.pressure", 0.0)),
    *((f"{CONTACT}.sliding.speed", 0.1), (f"{CONTACT}.sliding.mu_slope", 0.3)),
]
DAMPING = {"alpha": 0.3, "beta": 0.07}


def scene(backend, **contact):
    """Two blocks that slide, one of them damped and on springs."""
    sliding = {"pressure": 3.0, "speed": 0.5, "mu_slope": -0.2}
    data = coarse(two_blocks(backend, GPTS, held=True, sliding=sliding, max_missed=0.9, **contact))
    springs = [{"surface": "x_min", "stiffness": [0.3, 0.2, 0.1]}]
    data["bodies"]["upper"] |= {"springs": springs, "damping": DAMPING}
    return data


@pytest.mark.parametrize(
    ("backend", "form", "full_pass", "change"),
    covering(["fe", "iga"], ["penalty", "saddle"], [False, True], CHANGES, strength=1),
)
def test_a_changed_parameter_gives_the_matrices_of_a_changed_scene(
    backend, form, full_pass, change
):
    """Those of a scene that is assembled with it."""
    data, (name, value) = scene(backend, form=form, full_pass=full_pass), change
    changed, fresh = deepcopy(data), {"leave_out": False}
    set_fields(changed, [f"{name}={value}"])
    ours = assemble(data, **fresh).pencil().at({name: value})
    theirs = assemble(changed, **fresh).pencil().at()
    for part in ("stiffness", "unsymmetric", "mass", "damping"):
        found, expected = getattr(ours, part), getattr(theirs, part)
        if expected is None or found is None:
            assert not any(m is not None and m.norm() for m in (found, expected))
            continue
        expected = to_numpy(expected)
        assert np.abs(to_numpy(found) - expected).max() <= 1e-13 * np.abs(expected).max()
    for found, expected in zip(dense_pencil(ours), dense_pencil(theirs), strict=True):
        assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()


def test_two_contacts_have_their_own_friction(backend):
    data = coarse(two_blocks(backend, GPTS, mu=0.4))
    data["contacts"]["again"] = data["contacts"]["interface"] | {"mu": 0.2, "P": 7.0}
    pencil = assemble(data, together=False).pencil()
    one, both = (to_numpy(pencil.at({"contacts.again.mu": mu}).unsymmetric) for mu in (0.0, 0.8))
    # Equal points: the second adds 7/3 * 0.8/0.4 of what the first is.
    expected = one * (1 + 7 / 3 * 2)
    assert (np.abs(both - expected) <= np.maximum(1e-12 * np.abs(expected), 1e-15)).all()


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("contacts.interface.nu", 0.1, "contacts.interface.mu"),
        ("contacts.interface.mu", -0.1, "zero or positive"),
        ("contacts.interface.mu", float("nan"), "zero or positive"),
        ("contacts.interface.P", 0.0, "positive"),
        ("contacts.interface.P", float("inf"), "finite"),
        ("bodies.upper.material.E", float("inf"), "finite"),
    ],
)
def test_parameters_that_cannot_be_are_refused(name, value, told):
    pencil = assemble(scene("iga")).pencil()
    with pytest.raises(InputError, match=told):
        pencil.at({name: value})
