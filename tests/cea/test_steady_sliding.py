"""Steady sliding with normal compliance: equations, tangent, convergence, balance, refusals."""

import numpy as np
import pytest
from blocks import FORMULATIONS, GPTS, assemble, coarse
from covering import covering
from petsc_matrices import to_numpy
from pressed import AREA, PRESSURE, SOFT, pressed_blocks

from cea.contact.pressure_and_friction import NormalCompliance
from cea.errors import ConvergenceError, InputError
from cea.system.steady_equations import SteadyEquations
from cea.system.steady_path import steady_sliding

RNG = np.random.default_rng(5)


def coupled_blocks(*arguments, held=True, **options):
    """The system of coarse blocks that are pressed, before steady sliding is sought."""
    data = coarse(pressed_blocks(*arguments, **options), degree=2)
    if not held:
        data["bodies"]["upper"]["supports"] = []
    return assemble(data)


@pytest.mark.grid
@pytest.mark.parametrize("m", [2.0, 2.5, 3.3])
def test_newton_converges_quadratically(backend, m):
    steady = steady_sliding(coupled_blocks(backend, GPTS, c_n=SOFT, m_n=m))
    (step,) = steady.path
    assert step.residuals[-1] < 1e-11
    logs = np.diff(np.log([r for r in step.residuals if r > 1e-11]))  # what rounding lets be seen
    assert logs[-1] / logs[-2] > 1.85


@pytest.mark.parametrize(
    ("backend", "formulation", "m"),
    covering(["fe", "iga"], FORMULATIONS, [1.0, 2.5]),
    indirect=["formulation"],
)
def test_the_tangent_is_the_derivative_of_the_forces(backend, formulation, m):
    """Where some points are open and others closed; a law of m = 1 has a kink that is kept off."""
    problem = SteadyEquations(coupled_blocks(backend, formulation, c_n=1e3, m_n=m, mu=0.4))
    x, f = 1e-3 * RNG.standard_normal(problem.system.size), np.zeros(0)
    direction = RNG.standard_normal(x.shape)
    state = problem.state(x, f, 1.0)
    assert 0 < np.mean(state.closures[0] > 0) < 1
    step = 1e-3 * np.abs(state.closures[0]).min() if m == 1 else 1e-7
    ends = [problem.state(x + sign * step * direction, f, 1.0).residual for sign in (1, -1)]
    difference = (ends[0] - ends[1]) / (2 * step)
    tangent = problem.tangent(problem.slopes(state.closures))
    exact = (to_numpy(tangent.stiffness) + to_numpy(tangent.unsymmetric)) @ direction
    without = to_numpy(problem.matrices.stiffness) @ direction
    assert np.abs(difference - exact).max() <= 1e-6 * np.abs(exact - without).max()


@pytest.mark.grid
@pytest.mark.parametrize("full_pass", [False, True])
def test_the_contact_bears_the_load(backend, formulation, full_pass):
    options = {"c_n": 1e4, "m_n": 2.5, "mu": 0.3, "full_pass": full_pass}
    states = steady_sliding(coupled_blocks(backend, formulation, **options)).contacts.values()
    assert len(states) == 1 + full_pass
    force = sum(state.force_on_a[2] * sign for state, sign in zip(states, (1, -1), strict=False))
    assert force == pytest.approx(PRESSURE * AREA, rel=1e-10)
    assert sum(s.friction_force for s in states) == pytest.approx(0.3 * force, rel=1e-10)
    for state in states:
        law = NormalCompliance(1e4 / len(states), 2.5)
        assert (state.stiffness[state.closure <= 0] == 0).all()
        assert state.stiffness == pytest.approx(law.slope(state.closure), rel=1e-12)
        assert state.pressure == pytest.approx(law.pressure(state.closure), rel=1e-12)


CROWNED = {"c_n": 1e4, "m_n": 2.0, "mu": 0.0, "added_gap": "5*(x-0.45)**2"}


@pytest.mark.grid
@pytest.mark.parametrize(
    ("formulation", "fields", "told"),
    [
        (GPTS, {"c_n": SOFT, "m_n": 2.5, "pressure": -PRESSURE}, "the load opens the contact"),
        (GPTS, {"c_n": SOFT, "pressure": 0.0}, "nothing presses the sides together"),
        (GPTS, {"c_n": 1e13, "mu": 0.0}, "stiffness may be too large"),
        ({"method": "grid", "points": 5}, CROWNED, "closed points leave a rigid body mode free"),
        (GPTS, {"c_n": SOFT, "mu": 0.3, "held": False}, "a rigid body mode is free"),
    ],
    ids=str,
)
def test_loads_and_laws_without_an_equilibrium_are_refused(backend, formulation, fields, told):
    """The crowned contact is closed on a line, about which the block may turn."""
    with pytest.raises(ConvergenceError, match=told):
        steady_sliding(coupled_blocks(backend, formulation, **fields))


def test_what_has_no_law_or_no_load_is_refused(backend):
    for kind, field in (("static", "contacts"), ("cea", "load")):
        with pytest.raises(InputError, match=field):
            steady_sliding(coupled_blocks(backend, GPTS, p=1.0, kind=kind))
