"""Scenes whose contacts obey normal compliance: equilibrium first, then modes about it."""

import numpy as np
import pytest
from blocks import FORMULATIONS
from covering import covering
from mpi import on_ranks
from pressed import AREA, PRESSURE, SOFT, pressed_blocks
from same_numbers import assert_same

from scenes import assemble, open_result, read_scene, run_modes, run_scene, save_result
from scenes.checking.steps import skipped_by
from scenes.spec.files import scene_names
from scenes.spec.plain import as_data
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

GPTS = {"method": "gpts", "points": 3}


def run(*arguments, **options):
    return run_scene(read_scene(pressed_blocks(*arguments, **options)))


@pytest.mark.parametrize(
    ("changes", "backend", "formulation"),
    covering(({}, {"full_pass": True}), ("fe", "iga"), FORMULATIONS, strength=1),
    indirect=["formulation"],
)
def test_uniform_closed_contact_has_the_modes_of_uniform_stiffness(backend, formulation, changes):
    """The closed points of a law of m = 1 have p = c_n, to the last bit where nothing projects."""
    found = run(backend, formulation, c_n=SOFT, **changes)
    assert all(state.closed_fraction == 1.0 for state in found.steady.contacts.values())
    known = run(backend, formulation, p=SOFT, **changes)
    scale = np.abs(known.eigenvalues).max()
    assert np.abs(found.eigenvalues - known.eigenvalues).max() <= 1e-10 * scale


def test_contact_forces_may_be_unknowns(backend):
    """Open points have no force; the form changes no mode."""
    forms = {
        form: run(backend, GPTS, c_n=1e3, m_n=2.0, mu=0.4, form=form)
        for form in ("penalty", "saddle")
    }
    state = forms["saddle"].steady.contacts["interface"]
    assert (state.stiffness == 0).any() or state.closed_fraction == 1.0
    penalty, saddle = (result.eigenvalues for result in forms.values())
    assert np.abs(saddle - penalty).max() <= 1e-8 * np.abs(penalty).max()


def test_a_law_that_stiffens_raises_frequencies_with_the_load(backend):
    rigid = [
        run(backend, GPTS, c_n=1e3, m_n=2.0, mu=0.0, pressure=p).frequencies[0]
        for p in (1e-4, 1e-2)
    ]
    assert rigid[1] > 1.5 * rigid[0]


def test_open_points_stay_points(backend):
    result = run(backend, GPTS, c_n=100.0, m_n=2.0, mu=0.0, added_gap="0.2*(x-0.45)**2")
    (contact,) = result.system.contacts
    state = result.steady.contacts["interface"]
    assert 0 < state.closed_fraction < 1
    assert len(contact.slope) == len(contact.interface.points)
    assert contact.slope == pytest.approx(state.stiffness)
    assert (contact.slope[state.closure <= 0] == 0).all()
    assert contact.law.pressure(contact.closure) == pytest.approx(state.pressure)


def test_friction_is_a_parameter_and_stiffness_is_none(backend):
    scene = read_scene(pressed_blocks(backend, GPTS, c_n=SOFT, m_n=2.0))
    parameters = run_scene(scene).modes.pencil.parameters
    assert "contacts.interface.mu" in parameters
    assert "contacts.interface.P" not in parameters


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_a_sweep_seeks_each_state_anew(backend):
    """Friction moves the equilibrium too; density does not."""
    scene = read_scene(pressed_blocks(backend, GPTS, c_n=1e2, m_n=2.0))
    assembled = assemble(scene)
    for field, value in (("contacts.interface.mu", 0.3), ("bodies.upper.material.E", 3.0)):
        swept, fresh = assembled.modes({field: value}), run_modes(scene.change(field, value))
        assert swept.eigenvalues == pytest.approx(fresh.eigenvalues, rel=1e-8, abs=1e-8)
    heavier = {"bodies.upper.material.rho": 2.0}
    swept, fresh = assembled.modes(heavier), run_modes(scene.change(heavier))
    assert swept.steady is assembled.modes().steady
    assert swept.eigenvalues == pytest.approx(fresh.eigenvalues, rel=1e-8, abs=1e-8)


@pytest.mark.grid(quick=1)
def test_an_assembled_scene_bears_the_load_that_it_is_given(backend):
    """The normal force is in equilibrium with it; density moves nothing."""
    assembled = assemble(read_scene(pressed_blocks(backend, GPTS, c_n=1e2, m_n=2.0)))
    for pressure in (2e-4, 5e-3):
        for changes in ({}, {"bodies.upper.material.rho": 2.0}):
            result = assembled.modes({"loads.0.pressure": pressure} | changes)
            assert result.scene.loads[0].pressure == pressure
            force = result.steady.contacts["interface"].normal_force
            assert force == pytest.approx(pressure * AREA, rel=1e-10)


@pytest.mark.parametrize(
    ("backend", "rule"), covering(("iga", "fe"), ({"method": "mortar"}, GPTS), strength=1)
)
def test_matrices_are_those_of_the_state(backend, rule):
    result = run(backend, rule, c_n=1e2, m_n=2.0)
    matrices = result.matrices()
    (contact,) = result.system.contacts
    assert abs(matrices["K_n"]).max() == pytest.approx(
        max(abs(contact.K_n.getValuesCSR()[2])), rel=1e-14
    )
    assert abs(matrices["K_f"]).max() > 0


def test_a_static_scene_reports_the_state(backend, tmp_path):
    result = run(backend, GPTS, kind="static", c_n=1e2, m_n=2.0)
    state = result.steady.contacts["interface"]
    assert state.normal_force == pytest.approx(PRESSURE * AREA, rel=1e-10)
    assert "normal force 0.0003 N" in repr(result)
    data = open_result(save_result(result, tmp_path / "result.json")).data["steady_sliding"]
    told = data["contacts"]["interface"]
    assert told["normal_force"] == state.normal_force
    assert told["closed_area"] == state.closed_area
    assert data["path"][-1]["load"] == 1.0


def test_what_is_sought_is_not_among_what_was_skipped(backend):
    given, sought = (
        read_scene(pressed_blocks(backend, GPTS, **law)) for law in ({"p": SOFT}, {"c_n": SOFT})
    )
    assert "newton" in skipped_by(given)
    assert "newton" not in skipped_by(sought)


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_damping_moves_no_equilibrium(backend):
    data = pressed_blocks(backend, GPTS, c_n=SOFT, m_n=2.0)
    data["bodies"]["upper"]["damping"] = {"alpha": 0.01, "beta": 0.002}
    damped, free = run_scene(read_scene(data)), run(backend, GPTS, c_n=SOFT, m_n=2.0)
    pressures = [result.steady.contacts["interface"].pressure for result in (damped, free)]
    assert pressures[0] == pytest.approx(pressures[1], rel=1e-12)
    assert damped.growth_rates.max() < 0


def kinds(result):
    return {warning.kind for warning in result.warnings}


def test_loads_that_change_nothing_are_told(backend):
    assert "loads-without-effect" in kinds(run(backend, GPTS, p=SOFT))
    assert "loads-without-effect" not in kinds(run(backend, GPTS, c_n=SOFT))


def test_gaps_of_a_law_are_not_taken_as_closed(backend):
    data = pressed_blocks(backend, GPTS, c_n=SOFT, m_n=2.0, reach=0.2)
    data["bodies"]["upper"]["geometry"]["origin"][2] += 0.05
    result = run_scene(read_scene(data))
    assert "gap-closed" not in kinds(result)
    assert result.steady.contacts["interface"].normal_force == pytest.approx(PRESSURE * AREA)


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"c_n": 0.0}, "c_n"),
        ({"c_n": -1.0}, "c_n"),
        ({"c_n": float("inf")}, "c_n"),
        ({"m_n": 0.9}, "m_n"),
        ({"m_n": 25.0}, "m_n"),
        ({"p": 1.0}, "P"),
        ({"P": 1.0}, "P"),
        ({"added_gap": "no such"}, "added_gap"),
        ({"formulation": {"method": "gpts", "points": 3, "lumped": True}}, "method"),
        ({"formulation": {"method": "mortar"}, "form": "saddle"}, "form"),
        ({"c_n": None, "p": 1.0, "m_n": 2.0}, "m_n"),
        ({"c_n": None, "p": 1.0, "added_gap": 0.1}, "added_gap"),
    ],
)
def test_what_makes_no_law_is_refused(backend, changes, field):
    options = {"c_n": SOFT} | changes
    formulation = options.pop("formulation", GPTS)
    with pytest.raises(SceneError) as refused:
        read_scene(pressed_blocks(backend, formulation, **options))
    assert any(fault.field.endswith(f".{field}") for fault in refused.value.faults)


@pytest.mark.parametrize("name", scene_names())
def test_fields_that_say_nothing_stand_in_no_fingerprint(name):
    described = as_data(load_scene(name))
    for contact in described["contacts"].values():
        assert ("c_n" in contact) == (contact.get("c_n") is not None)


CASES = ("fe gpts", "iga mortar", "fe full pass", "fe mortar", "iga saddle")


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("ranks", "cases"),
    [
        (2, ("iga mortar",)),
        pytest.param(2, CASES, marks=pytest.mark.slow),
        pytest.param(3, CASES, marks=pytest.mark.slow),
    ],
)
def test_ranks_find_the_same_state(ranks, cases):
    found, expected = (on_ranks(n, "steady_numbers.states", *cases) for n in (ranks, 1))
    assert_same(found, expected, rel=1e-8)
