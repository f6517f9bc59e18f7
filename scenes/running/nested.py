"""Error estimates of eigenvalues in a richer space: a higher degree or bisected elements."""

from collections.abc import Callable

from cea.eigen.pencil import release
from cea.errors import require
from cea.matrices import destroy
from cea.nested.estimate import ErrorEstimate, error_estimate
from cea.nested.prolongation import of_body, of_system
from scenes.building.build import made_of
from scenes.checking.memory import factors_of
from scenes.results.result import Result
from scenes.running.run import coupled, run_modes
from scenes.spec.reading import Scene
from scenes.spec.refinement import richer_scene


def estimate_errors(
    result: Result,
    richer: Scene | None = None,
    *,
    steps: int = 2,
    listener: Callable[[str], None] | None = None,
) -> ErrorEstimate:
    """Estimate the errors of the eigenvalues of a scene in a richer space; collective.

    If left eigenvectors are needed and missing, the scene is solved again with them; compute them
    with ``run_modes(scene, left=True)`` to avoid this. The estimate needs one factorisation of the
    richer scene, and in each step a block of solves for the right and one for the left vectors, but
    no eigensolution (:mod:`cea.nested.estimate`). A better contact rule in the richer scene counts.

    Parameters
    ----------
    result
        Modes of the scene.
    richer
        A richer scene; by default that with a degree more (:func:`richer_scene`).
    steps
        Number of block inverse iterations; one does not give an estimate of the remaining error.
    listener
        Called with the name of each stage as it begins.

    Raises
    ------
    InputError
        If there are no modes, or the scenes have different bodies.
    """
    scene = richer if richer is not None else richer_scene(result.scene)
    own, names = result.scene, list(scene.bodies)
    allowed = f"those of the coarse scene: {', '.join(own.bodies)}"
    require(names == list(own.bodies), "bodies", names, allowed)
    one_sided = own.damped or own.rotates or own.has_friction
    if one_sided and result.modes.left is None and len(result.modes):
        result = run_modes(own, left=True, bodies=result.bodies, listener=listener)
    same = {n: b for n, b in result.bodies.items() if made_of(own, n) == made_of(scene, n)}
    system, timer = coupled(scene, bodies=same, listener=listener)
    with timer("assembly"):
        matrices = system.pencil().at()
        bodies = system.bodies.items()
        step = of_system([of_body(result.bodies[name], body) for name, body in bodies])
    try:
        with timer("krylov"), factors_of(scene):
            return error_estimate(result.modes, matrices, step, steps=steps)
    finally:
        destroy(step)
        release(matrices)
