"""Penalty and saddle form of a contact: the same eigenvalues, and which form is chosen."""

from pathlib import Path

import numpy as np
import pytest
from blocks import GPTS, assemble, coarse, two_blocks
from covering import covering

from cea.eigen.driver import solve_modes
from scenes import run_scene
from scenes.spec.reading import load_scene


def scene(backend, formulation, **fields):
    """Two coarse blocks, held, whose contact has other fields."""
    return coarse(two_blocks(backend, formulation, held=True, **fields))


def modes_of(data):
    return solve_modes(assemble(data).pencil(), 1.0)


OF_UNEQUAL_AREA = {"mu": 0.3, "full_pass": True, "P": None, "p": "10 + 30*x"}
"""A full pass at a given p: the larger side has more area and more of P."""


@pytest.mark.grid
@pytest.mark.parametrize("fields", [{"mu": 0.0}, {"mu": 0.4}, OF_UNEQUAL_AREA], ids=str)
def test_the_eigenvalues_are_those_of_the_penalty_form(backend, formulation, fields):
    penalty, saddle = (
        modes_of(scene(backend, formulation, form=form, **fields)) for form in ("penalty", "saddle")
    )
    assert len(penalty.eigenvalues) > 3
    assert saddle.eigenvalues == pytest.approx(penalty.eigenvalues, rel=1e-9, abs=1e-9)
    assert saddle.residuals.max() < 1e-9


@pytest.mark.parametrize(
    ("backend", "method", "P"),
    covering(["iga", "fe"], ["mortar", "segments"], ["1e2", "1e20", "inf"], strength=1),
)
def test_the_patch_test_passes_at_any_stiffness(backend, method, P):
    overrides = [f"contacts.interface.P={P}", "contacts.interface.form='saddle'"]
    overrides.append(f"contacts.interface.formulation={{method='{method}'}}")
    stresses = run_scene(load_scene(Path("patch_test"), overrides, backend)).stresses["interface"]
    worst = max(np.abs(side.sigma_n / -1000 - 1).max() for side in stresses.values())
    assert worst < 1e-8


@pytest.mark.parametrize("fields", [{"formulation": GPTS | {"lumped": True}}, {"form": "penalty"}])
def test_a_penalty_that_stays_says_how_many_digits_it_costs(backend, fields):
    fields = {"formulation": GPTS} | fields
    system = assemble(scene(backend, P=1e9, **fields))
    assert {contact.form for contact in system.contacts} == {"penalty"}
    (warning,) = system.warnings_at({})
    assert (warning.kind, warning.data["contact"]) == ("penalty-rounding", "interface")
    stiffness = system.pencil().at().stiffness
    bodies = [body.stiffness().getDiagonal().array for body in system.bodies.values()]
    largest = stiffness.getDiagonal().array / np.concatenate(bodies)
    assert warning.data["digits"] == pytest.approx(np.log10(largest.max()), abs=1e-3)
    assert not assemble(scene(backend, P=1e5, **fields)).warnings_at({})
