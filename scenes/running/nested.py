"""Two discretisations of one scene: prolongation, errors of eigenvalues."""

from collections.abc import Callable, Mapping
from typing import Any

from cea.body import Body
from cea.eigen.pencil import release
from cea.errors import InputError
from cea.matrices import destroy
from cea.nested.estimate import ErrorEstimate, error_estimate
from cea.nested.prolongation import of_body, of_system
from scenes.building.build import Built, made_of
from scenes.checking.memory import factors_of
from scenes.results.result import Result
from scenes.running.enrich import richer_scene
from scenes.running.modes import run_modes
from scenes.running.system import RunOptions, coupled
from scenes.spec.reading import Scene


def prolongation(coarse: Mapping[str, Body], fine: Mapping[str, Body]) -> Any:
    """Prolongation from the free displacements of a scene to those of a finer one; collective."""
    if list(coarse) != list(fine):
        raise InputError("bodies", list(fine), f"those of the coarse scene: {', '.join(coarse)}")
    return of_system([of_body(coarse[name], fine[name]) for name in fine])


def estimate_errors(
    result: Result,
    richer: Scene | None = None,
    *,
    steps: int = 2,
    listener: Callable[[str], None] | None = None,
) -> ErrorEstimate:
    """Errors of the eigenvalues of a scene, estimated in a richer space; collective.

    Where the left vectors that this takes are missing, the scene is solved once more with them:
    ``run_modes(scene, left=True)`` saves that. It takes one factorisation of the richer scene, and
    in every step a block of solves for the right vectors and one for the left ones; no eigenproblem
    (:mod:`cea.nested.estimate`). What the contact rule of the richer scene does better is part of
    the error.

    Parameters
    ----------
    result
        Modes of the scene.
    richer
        A richer scene; by default the same with a degree more (:mod:`scenes.running.enrich`).
    steps
        Block inverse steps; after one nothing is known of what remains.
    listener
        Called with the name of each stage as it begins.

    Raises
    ------
    InputError
        When there are no modes, or the scenes are not of the same bodies.
    """
    scene = richer if richer is not None else richer_scene(result.scene)
    own = result.scene
    one_sided = own.damped or own.rotates or own.has_friction
    if one_sided and result.modes.left is None and len(result.modes):
        known: RunOptions = {"bodies": result.bodies, "interfaces": result.interfaces}
        known["listener"] = listener
        result = run_modes(own, left=True, **known)
    same = Built(result.bodies, {name: made_of(own, name) for name in own.bodies})
    system, _, timer = coupled(scene, bodies=same, listener=listener)
    with timer("assembly"):
        matrices = system.pencil().at()
        step = prolongation(result.bodies, system.bodies)
    try:
        with timer("krylov"), factors_of(scene):
            return error_estimate(result.modes, matrices, step, steps=steps)
    finally:
        destroy(step)
        release(matrices)
