"""Penalty and saddle form of a contact: the same eigenvalues, and which form is chosen."""

from pathlib import Path

import numpy as np
import pytest
from blocks import assemble, coarse, two_blocks
from covering import covering

from cea.eigen.driver import solve_modes
from scenes import run_modes, run_scene
from scenes.spec.reading import load_scene, read_scene

GPTS, MORTAR = {"method": "gpts", "points": 3}, {"method": "mortar"}
LUMPED = GPTS | {"lumped": True}


def scene(backend, formulation, **fields):
    """Two coarse blocks, held, whose contact has other fields."""
    return coarse(two_blocks(backend, formulation, held=True, **fields))


def modes_of(data, **options):
    return solve_modes(assemble(data, **options).pencil(), 1.0)


@pytest.mark.grid
@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_the_eigenvalues_are_those_of_the_penalty_form(backend, formulation, mu):
    penalty, saddle = (
        modes_of(scene(backend, formulation, mu=mu, form=form)) for form in ("penalty", "saddle")
    )
    assert len(penalty.eigenvalues) > 3
    assert saddle.eigenvalues == pytest.approx(penalty.eigenvalues, rel=1e-9, abs=1e-9)
    assert saddle.residuals.max() < 1e-9


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_infinite_stiffness_is_the_limit_of_finite_ones(backend):
    near, nearer, limit = (
        modes_of(scene(backend, MORTAR, form="saddle", P=P)).eigenvalues ** 2
        for P in (1e5, 1e6, float("inf"))
    )
    errors = [np.abs(kappa - limit).max() for kappa in (near, nearer)]
    assert errors[1] < 1e-4 * np.abs(limit).max()
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.05)  # first order in the compliance


@pytest.mark.parametrize(
    ("backend", "method", "P"),
    covering(
        ["iga", "fe"], ["mortar", "segments"], ["1e2", "1e6", "1e14", "1e20", "inf"], strength=1
    ),
)
def test_the_patch_test_passes_at_any_stiffness(backend, method, P):
    overrides = [f"contacts.interface.P={P}", "contacts.interface.form='saddle'"]
    overrides.append(f"contacts.interface.formulation={{method='{method}'}}")
    stresses = run_scene(load_scene(Path("patch_test"), overrides, backend)).stresses["interface"]
    worst = max(np.abs(side.sigma_n / -1000 - 1).max() for side in stresses.values())
    assert worst < 1e-8


@pytest.mark.parametrize("form", ["penalty", "saddle"])
def test_contact_between_held_sides_does_nothing(form):
    data = scene("fe", GPTS, mu=0.3, form=form)
    data["bodies"]["upper"]["supports"] = [{"surface": "z_min"}]
    data["bodies"]["lower"]["supports"] = [{"surface": "z_max"}]
    alone = modes_of(data | {"contacts": {}}).eigenvalues
    assert modes_of(data, together=False).eigenvalues == pytest.approx(alone, rel=1e-9)


def forms(system):
    return {contact.form for contact in system.contacts}


@pytest.mark.parametrize("fields", [{"formulation": LUMPED}, {"form": "penalty"}])
def test_a_penalty_that_stays_says_how_many_digits_it_costs(backend, fields):
    fields = {"formulation": GPTS} | fields
    system = assemble(scene(backend, P=1e9, **fields))
    assert forms(system) == {"penalty"}
    (warning,) = system.warnings_at({})
    assert (warning.kind, warning.data["contact"]) == ("penalty-rounding", "interface")
    stiffness = system.pencil().at().stiffness
    bodies = [body.stiffness().getDiagonal().array for body in system.bodies.values()]
    largest = stiffness.getDiagonal().array / np.concatenate(bodies)
    assert warning.data["digits"] == pytest.approx(np.log10(largest.max()), abs=1e-3)
    assert not assemble(scene(backend, P=1e5, **fields)).warnings_at({})


@pytest.mark.grid
@pytest.mark.parametrize("rule", [GPTS, MORTAR], ids=str)
def test_halves_of_unequal_area_keep_their_own_stiffness(backend, rule):
    """A full pass at a given p: the larger side has more area and more of P."""
    both = []
    for form in ("penalty", "saddle"):
        options = {"full_pass": True, "form": form, "P": None, "p": "10 + 30*x", "mu": 0.3}
        both.append(run_modes(read_scene(scene(backend, rule, **options))))
    assert both[1].eigenvalues == pytest.approx(both[0].eigenvalues, rel=1e-9, abs=1e-9)
    K_n = [result.matrices()["K_n"].toarray() for result in both]
    assert np.abs(K_n[1] - K_n[0]).max() <= 1e-12 * np.abs(K_n[0]).max()
