"""Every scene of the catalogue that is under load: what is outside holds the bodies as a whole."""

from copy import deepcopy

import numpy as np
import pytest

from cea.errors import ConvergenceError
from cea.matrices import destroy, gather
from comparisons.stability.catalogue import catalogue, numbers_of, runs_of
from comparisons.stability.parts.problems import OfScene
from scenes import read_scene
from scenes.running.static import run_static
from scenes.running.system import coupled
from scenes.spec.problems import SceneError

EPS = np.finfo(float).eps


def loaded(name, *, quick):
    """Scenes of a case that have an equilibrium under loads, or are to be refused for it."""
    for number in numbers_of(name, quick=quick):
        problem = runs_of(name)[number].problem
        if not isinstance(problem, OfScene):
            continue
        data = deepcopy(dict(problem.data))
        if data["analysis"]["kind"] == "cea":
            data["analysis"].setdefault("max_frequency", 1.0)
        try:
            scene = read_scene(data)
        except SceneError:
            continue
        if scene.slides_steadily or scene.analysis.kind == "static":
            yield runs_of(name)[number].row, scene


UNDER_LOAD = (
    "load_steps",
    "patch_test",
    "prescribed",
    "prestress",
    "steady_sliding",
    "unsupported",
)
"""Cases of which scenes are under load."""


def outside(scene):
    """Forces on all bodies from outside (N), and what rounding makes of their sum; none refused.

    Loads, springs and supports; contacts are between bodies, and in no sum.
    """
    if scene.analysis.kind == "static":
        result = run_static(scene)
        system, x, reactions = result.system, result.displacement, result.reactions
    else:
        system = coupled(scene)[0]
        x, reactions = system.steady.displacement, system.steady.reactions
    forces, rounding = [], 0.0
    for name, body in system.bodies.items():
        load, stiffness = body.full_load(), body.full_stiffness()
        u = system.displacement(x, name)
        forces.append(gather(load).reshape(-1, body.dim).sum(axis=0))
        if (springs := body.full_spring_stiffness()) is not None:
            moved, pulled = springs.createVecs()
            moved.array[:] = u
            springs.mult(moved, pulled)
            forces.append(-gather(pulled).reshape(-1, body.dim).sum(axis=0))
            destroy(springs, moved, pulled)
        forces += list(reactions.get(name, ()))
        rounding += EPS * stiffness.norm() * np.linalg.norm(u) * np.sqrt(len(u))
        destroy(load, stiffness)
    for contact in system.contacts:
        if contact.lumped is None and np.isfinite(contact.P) and not contact.has_multipliers:
            u = max(np.abs(system.displacement(x, name)).max() for name in system.bodies)
            rounding += EPS * contact.P * u
    return np.array(forces), rounding


def check(name, *, quick):
    answered = 0
    for row, scene in loaded(name, quick=quick):
        refusal = ""
        try:
            forces, rounding = outside(scene)
        except ConvergenceError as error:
            refusal = str(error)
        assert "add up to zero" not in refusal, row
        if refusal:
            continue
        largest = np.linalg.norm(forces, axis=1).max()
        assert np.linalg.norm(forces.sum(axis=0)) <= 1e-11 * largest + rounding, row
        answered += 1
    assert answered or name == "unsupported"


@pytest.mark.slow
def test_every_case_under_load_is_listed():
    found = {name for name in catalogue() if any(loaded(name, quick=True))}
    assert found == set(UNDER_LOAD)


@pytest.mark.parametrize("name", UNDER_LOAD)
def test_what_is_outside_holds_the_bodies(name):
    check(name, quick=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", UNDER_LOAD)
def test_what_is_outside_holds_the_bodies_of_every_run(name):
    check(name, quick=False)
