"""The form of a contact that a scene leaves open, and what the penalty form costs."""

from dataclasses import replace

import numpy as np
import pytest
from blocks import assemble, coarse, two_blocks
from covering import covering

from cea.contact.interface import pair
from cea.errors import InputError
from scenes import run_modes
from scenes.spec.reading import read_scene

GPTS = {"method": "gpts", "points": 3}
LUMPED = GPTS | {"lumped": True}


def contact_of(backend, P, formulation=GPTS, **fields):
    data = coarse(two_blocks(backend, formulation, held=True, P=P, mu=0.3))
    data["contacts"]["interface"] |= fields
    return data


def forms(system):
    return {contact.form for contact in system.contacts}


@pytest.mark.parametrize(
    ("backend", "P", "full_pass"), covering(["fe", "iga"], [3.0, 1e5, 1e9], [False, True])
)
def test_saddle_where_a_penalty_costs_more_than_six_digits(backend, P, full_pass):
    form = "saddle" if P == 1e9 else "penalty"
    system = assemble(contact_of(backend, P, full_pass=full_pass))
    assert forms(system) == {form}
    assert not system.warnings_at({})


@pytest.mark.parametrize("fields", [{"formulation": LUMPED}, {"form": "penalty"}])
def test_a_penalty_that_stays_says_how_many_digits_it_costs(backend, fields):
    system = assemble(contact_of(backend, 1e9, **fields))
    assert forms(system) == {"penalty"}
    (warning,) = system.warnings_at({})
    assert warning.kind == "penalty-rounding"
    assert warning.data["contact"] == "interface"
    stiffness = system.pencil().at().stiffness
    bodies = [body.stiffness().getDiagonal().array for body in system.bodies.values()]
    largest = stiffness.getDiagonal().array / np.concatenate(bodies)
    assert warning.data["digits"] == pytest.approx(np.log10(largest.max()), abs=1e-3)
    assert not assemble(contact_of(backend, 1e5, **fields)).warnings_at({})


@pytest.mark.parametrize(
    "moduli",
    [{"upper": 2e-3, "lower": 2e5}, {"upper": 2e5, "lower": 2e4}, {"upper": 3.0}],
    ids=str,
)
def test_digits_at_other_moduli_are_those_of_a_scene_assembled_there(backend, moduli):
    """Springs do not grow with them, and the stiffer side does not count."""
    data = contact_of(backend, 1e9, form="penalty")
    data["bodies"]["upper"]["springs"] = [{"surface": "z_min", "stiffness": [1e3] * 3}]
    values = {f"bodies.{name}.material.E": E for name, E in moduli.items()}
    (found,) = assemble(data).warnings_at(values | {"contacts.interface.P": 1e11})
    for name, E in moduli.items():
        data["bodies"][name]["material"]["E"] = E
    data["contacts"]["interface"]["P"] = 1e11
    (fresh,) = assemble(data).warnings_at({})
    assert found.data["digits"] == pytest.approx(fresh.data["digits"], abs=1e-9)


@pytest.mark.parametrize(
    ("backend", "method"), covering(["fe", "iga"], ["gpts", "mortar"], strength=1)
)
def test_halves_of_unequal_area_keep_their_own_stiffness(backend, method):
    """A full pass at a given p: the larger side has more area and more of P."""
    both = []
    for form in ("penalty", "saddle"):
        formulation = GPTS if method == "gpts" else {"method": "mortar"}
        data = contact_of(backend, 1.0, formulation, full_pass=True, form=form)
        del data["contacts"]["interface"]["P"]
        data["contacts"]["interface"]["p"] = "10 + 30*x"
        both.append(run_modes(read_scene(data)))
    matrices = [result.matrices() for result in both]
    assert both[1].eigenvalues == pytest.approx(both[0].eigenvalues, rel=1e-9, abs=1e-9)
    K_n = [m["K_n"].toarray() for m in matrices]
    assert np.abs(K_n[1] - K_n[0]).max() <= 1e-12 * np.abs(K_n[0]).max()


def weighted(backend, change):
    """An interface whose weights are changed."""
    interface = assemble(contact_of(backend, 3.0)).contacts[0].interface
    points = interface.a.gauss_points(3)
    weight = points.weight.copy()
    change(weight)
    return pair(interface.a, interface.b, replace(points, weight=weight)), points


@pytest.mark.parametrize("wrong", [-1e-3, np.nan, np.inf])
def test_weights_that_are_negative_or_no_numbers_are_refused(backend, wrong):
    def change(weight):
        weight[5] = wrong

    with pytest.raises(InputError, match=r"contact\.formulation\.weights"):
        weighted(backend, change)


def test_points_without_weight_are_dropped(backend):
    def change(weight):
        weight[[3, 8]] += weight[[2, 7]]
        weight[[2, 7]] = 0.0

    interface, points = weighted(backend, change)
    assert len(interface.points) == len(points) - 2
    assert interface.points.weight.min() > 0
