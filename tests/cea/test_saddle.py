"""Contact forces as unknowns: the same as the penalty form, and beyond where that loses digits."""

from pathlib import Path

import numpy as np
import pytest
from blocks import FORMULATIONS, assemble, coarse, two_blocks
from covering import covering
from motions import dense
from scipy.linalg import eigvals, null_space

from cea.eigen.driver import solve_modes
from cea.eigen.shifted import count_below
from cea.errors import InputError
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


@pytest.mark.grid(quick=6)
def test_multipliers_eliminated_give_the_penalty_matrices(backend, formulation):
    penalty = assemble(with_form(two_blocks(backend, formulation), "penalty"))
    saddle = assemble(with_form(two_blocks(backend, formulation), "saddle"))
    multipliers = saddle.pencil().at().multipliers
    closure, reaction = (dense(m) for m in (multipliers.closure, multipliers.reaction))
    stiffness = reaction.T @ np.linalg.solve(dense(multipliers.compliance), closure)
    matrices = penalty.pencil(eliminate=True).at()
    expected = dense(matrices.operator()) - dense(penalty.stiffness)
    np.testing.assert_allclose(stiffness, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


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


def test_inertia_counts_modes_beside_multipliers(backend):
    data = with_form(two_blocks(backend, {"method": "mortar"}, mu=0.0, held=True), "saddle")
    matrices = assemble(data).pencil().at()
    found = modes_of(data).eigenvalues.imag ** 2
    middle = 0.5 * (found[3] + found[4])
    assert count_below(matrices, middle) == 4


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


def test_a_full_pass_in_both_forms_is_the_same(backend):
    both = [
        modes_of(
            with_form(
                coarse(two_blocks(backend, {"method": "gpts", "points": 4}, held=True)),
                form,
                full_pass=True,
            )
        )
        for form in ("penalty", "saddle")
    ]
    assert both[1].eigenvalues == pytest.approx(both[0].eigenvalues, rel=1e-9, abs=1e-9)


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


def test_pressure_of_gaps_is_refused_where_none_opens(backend):
    system = assemble(two_blocks(backend, {"method": "mortar"}, P=np.inf))
    with pytest.raises(InputError, match="finite"):
        system.contacts[0].pressure(system.vector())


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_ties_are_no_modes_where_the_whole_spectrum_is_asked_for(mu):
    """At P = infinity each tie takes one eigenvalue away; the others are those of null spaces."""
    data = with_form(two_blocks("iga", {"method": "mortar"}, mu=mu, held=True, P=np.inf), "saddle")
    for body in data["bodies"].values():
        body["mesh"]["iga"] |= {"elements": [2, 2, 2], "degree": [1, 1, 1]}
    pencil = assemble(data).pencil()
    matrices = pencil.at()
    closure, reaction = dense(matrices.multipliers.closure), dense(matrices.multipliers.reaction)
    Z, Y = null_space(closure), null_space(reaction)
    K, M = dense(matrices.operator()), dense(matrices.mass)
    exact = eigvals(Y.T @ K @ Z, Y.T @ M @ Z)
    modes = solve_modes(pencil, 20.0, left=True)
    found = -(modes.eigenvalues**2)
    assert len(found) == len(exact) == matrices.size - matrices.tied
    distance = np.abs(found[:, None] - exact) / np.abs(exact)
    assert distance.min(axis=0).max() < 1e-6
    assert distance.min(axis=1).max() < 1e-6
    assert not [w for w in modes.warnings if w.kind == "residual"]


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


@pytest.mark.parametrize("form", ["penalty", "saddle"])
def test_a_bonded_joint_may_be_assembled_for_sweeps(form):
    data = with_form(two_blocks("iga", {"method": "bonded"}, mu=0.0, held=True), form)
    both = [
        solve_modes(assemble(data, leave_out=leave_out).pencil(), 0.6).eigenvalues
        for leave_out in (True, False)
    ]
    assert both[1] == pytest.approx(both[0], rel=1e-9)
