"""A block whose back slides obliquely to its contact: friction multiplies the force that holds it.

The back slides on a plane at 60 degrees to the contact. Balance gives N = F / (1 - mu tan 60),
and the tangent is singular where friction is cot 60.
"""

import numpy as np
import pytest

from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError
from cea.system.steady_equations import SteadyEquations, free_tangent
from cea.system.steady_state import uniqueness_at
from cea.timing import StageTimer
from comparisons.stability.scenes import sprag
from scenes import read_scene, run_scene
from scenes.building.build import build_bodies, build_interfaces, build_system

FORCE, LIMIT = 1e-3, 1 / np.tan(np.radians(60.0))


def pressed_sprag(backend, mu, m=2.0):
    data = sprag(mu=mu, c_n=1.0, m_n=m, formulation={"method": "gpts", "points": 3})
    del data["contacts"]["contact"]["p"]
    for body in data["bodies"].values():
        body["backend"] = backend
    loads = [{"surface": "block.y_max", "pressure": FORCE}]
    return read_scene(data | {"loads": loads, "analysis": {"kind": "cea", "max_frequency": 0.2}})


def tangent_parity(backend, mu):
    """Of the tangent where every point is closed, whether that is an equilibrium or not."""
    scene, timer = pressed_sprag(backend, mu), StageTimer()
    bodies = build_bodies(scene, timer)
    system = build_system(scene, bodies, build_interfaces(scene, bodies, timer), timer)
    problem = SteadyEquations(system)
    tangent = problem.tangent(
        problem.slopes([np.full_like(gap, 0.1) for gap in problem.gaps_at(1.0)])
    )
    found = uniqueness_at(tangent, Shifted(tangent), {1.0: None}, unstable=False)
    free_tangent(tangent)
    problem.free()
    return found


@pytest.mark.parametrize("mu", [0.1, 0.3, 0.55])
def test_friction_multiplies_the_force_until_the_tangent_is_singular(backend, mu):
    steady = run_scene(pressed_sprag(backend, mu)).steady
    left = 1 - mu / LIMIT
    assert steady.contacts["contact"].normal_force == pytest.approx(FORCE / left, rel=1e-9)
    assert steady.uniqueness.margin == pytest.approx(left, rel=0.05)
    assert not steady.uniqueness.lost


def test_beyond_the_limit_the_determinant_has_changed_its_sign(backend):
    below, above = (tangent_parity(backend, factor * LIMIT) for factor in (0.9, 1.1))
    assert (below.parity, above.parity) == (0, 1)
    assert above.lost
    assert [w.kind for w in above.warnings()] == ["not-unique"]
    assert below.warnings() == ()


def test_beyond_the_limit_there_is_no_equilibrium(backend):
    with pytest.raises(ConvergenceError, match="no state of steady sliding") as refused:
        run_scene(pressed_sprag(backend, 1.2 * LIMIT))
    assert refused.value.best.relative > 1e-3
