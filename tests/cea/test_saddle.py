"""Contact forces as unknowns: the same as the penalty form, and beyond where that loses digits."""

from pathlib import Path

import numpy as np
import pytest
from blocks import FORMULATIONS, assemble, coarse, two_blocks
from covering import covering
from motions import dense

from cea.eigen.driver import solve_modes
from scenes import run_scene
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

MAX_FREQUENCY = 1.0


def modes_of(data, **options):
    system = assemble(data, **options)
    return solve_modes(system.pencil(), MAX_FREQUENCY)


def with_form(data, form, **changes):
    data["contacts"]["interface"] |= {"form": form} | changes
    return data


@pytest.mark.parametrize(
    ("backend", "formulation", "mu"),
    covering(["iga", "fe"], FORMULATIONS, [0.0, 0.4], strength=1),
    indirect=["formulation"],
)
def test_the_eigenvalues_are_those_of_the_penalty_form(backend, formulation, mu):
    both = [
        modes_of(with_form(coarse(two_blocks(backend, formulation, mu=mu, held=True)), form))
        for form in ("penalty", "saddle")
    ]
    assert len(both[0].eigenvalues) > 3
    assert both[1].eigenvalues == pytest.approx(both[0].eigenvalues, rel=1e-9, abs=1e-9)
    assert both[1].residuals.max() < 1e-9


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_infinite_stiffness_is_the_limit_of_finite_ones(backend):
    mortar = {"method": "mortar"}
    kappa = {
        P: -(
            modes_of(
                with_form(coarse(two_blocks(backend, mortar, held=True)), "saddle", P=P)
            ).eigenvalues
            ** 2
        )
        for P in (1e5, 1e6, float("inf"))
    }
    near, nearer = (np.abs(kappa[P] - kappa[np.inf]).max() for P in (1e5, 1e6))
    assert nearer < 1e-4 * np.abs(kappa[np.inf]).max()
    assert near / nearer == pytest.approx(10, rel=0.05)  # first order in the compliance


@pytest.mark.parametrize(
    ("backend", "method", "P"),
    covering(["iga", "fe"], ["mortar", "segments"], ["1e2", "1e6", "1e14", "1e20", "inf"]),
)
def test_the_patch_test_passes_at_any_stiffness(backend, method, P):
    overrides = [f"contacts.interface.P={P}", "contacts.interface.form='saddle'"]
    overrides.append(f"contacts.interface.formulation={{method='{method}'}}")
    stresses = run_scene(load_scene(Path("patch_test"), overrides, backend)).stresses["interface"]
    worst = max(np.abs(side.sigma_n / -1000 - 1).max() for side in stresses.values())
    assert worst < 1e-8


@pytest.mark.parametrize(
    ("overrides", "field"),
    [
        (["contacts.interface.P=inf", "contacts.interface.form='penalty'"], "P"),
        (["contacts.interface.P=inf", "contacts.interface.formulation.lumped=true"], "P"),
        (
            [
                "contacts.interface.form='saddle'",
                "contacts.interface.formulation.lumped=true",
            ],
            "form",
        ),
    ],
)
def test_what_has_no_such_form_is_refused(overrides, field):
    with pytest.raises(SceneError, match=rf"contacts\.interface\.{field} = "):
        load_scene(Path("patch_test"), overrides)


@pytest.mark.parametrize("form", ["penalty", "saddle"])
def test_contact_between_held_sides_does_nothing(form):
    data = with_form(two_blocks("fe", {"method": "gpts", "points": 2}, mu=0.3), form)
    data["bodies"]["upper"]["supports"] = [{"surface": "z_min"}]
    data["bodies"]["lower"]["supports"] = [{"surface": "z_max"}]
    alone = modes_of(data | {"contacts": {}}).eigenvalues
    assert modes_of(data, together=False).eigenvalues == pytest.approx(alone, rel=1e-9)


@pytest.mark.parametrize(
    ("form", "leave_out", "changed"),
    covering(["penalty", "saddle"], [True, False], [0.5, 0.0, 1.0]),
)
def test_friction_that_varies_over_the_points_of_one_side_alone(form, leave_out, changed):
    """Constant, or zero, on the coarse points of the other: both halves keep their own."""
    matrices = []
    for mu in (f"0.4*where(x<0.683,1,{changed})", f"0.4*where(x<0.683,1,{changed})+1e-13*x"):
        data = two_blocks("fe", {"method": "grid", "points": 4}, mu=mu, held=True, P=30.0)
        data["contacts"]["interface"] |= {"full_pass": True, "form": form}
        pencil = assemble(data, leave_out=leave_out).pencil().at()
        if form == "penalty":
            matrices.append(dense(pencil.unsymmetric))
        else:
            m = pencil.multipliers
            matrices.append(dense(m.reaction).T @ dense(m.closure))
    assert np.abs(matrices[0] - matrices[1]).max() <= 1e-10 * np.abs(matrices[1]).max()
