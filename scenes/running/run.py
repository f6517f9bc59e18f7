"""Runs of scenes: complex eigenvalue analyses with error estimates, and static analyses.

The coupled system is linearised about steady sliding if a contact has a law.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

from cea.body import Body
from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import release
from cea.errors import InputError, ResultWarning, require
from cea.matrices import destroy
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_contacts, build_system, made_of
from scenes.checking.memory import check_memory, factors_of, in_memory_or_on_disk
from scenes.checking.resolution import short_modes
from scenes.checking.skipped import skipped_by
from scenes.checking.warnings import warnings_of
from scenes.results.result import Result
from scenes.spec.reading import Scene, StaticAnalysis

if TYPE_CHECKING:
    from cea.nested.estimate import ErrorEstimate
    from scenes.spec.matrices import MatrixScene

STATE_KEPT = "steady-state-kept"
"""Kind of the warning that derivatives ignore the dependence of steady sliding on parameters."""


class RunOptions(TypedDict, total=False):
    """Options of a run, by name.

    Parameters
    ----------
    bodies
        Bodies of an earlier run. Those with the same mesh, material, supports, springs and loads
        are reused with their matrices; others are built.
    leave_out
        Whether to omit the friction terms of contacts with mu = 0 (default); set False to change
        mu later.
    listener
        Called with the name of each stage as it begins.
    """

    bodies: Mapping[str, Body] | None
    leave_out: bool
    listener: Callable[[str], None] | None


def run_scene(scene: "Scene | MatrixScene", **options: Any) -> Result:
    """Run a scene by its kind of analysis.

    Parameters
    ----------
    scene
        Scene of bodies or of matrices.
    options
        See :class:`RunOptions`.

    Raises
    ------
    InputError
        If the memory of the machine does not suffice.
    """
    if not isinstance(scene, Scene):
        from scenes.running.matrices import run_matrices

        return run_matrices(scene, **options)
    if isinstance(scene.analysis, StaticAnalysis):
        return run_static(scene, **options)
    return run_modes(scene, **options)


def run_modes(scene: Scene, *, left: bool = False, **options: Unpack[RunOptions]) -> Result:
    """Compute the modes of a scene.

    Parameters
    ----------
    scene
        Scene with a complex eigenvalue analysis.
    left
        Whether to compute left eigenvectors too, for sensitivities and true condition numbers.
    options
        See :class:`RunOptions`.

    Raises
    ------
    InputError
        If the scene has another kind of analysis.
    """
    _ = scene.window  # raises for a static analysis
    system, timer = coupled(scene, **options)
    with timer("assembly"):
        pencil = system.pencil()
    with EigenSolver(pencil) as driver:
        return solved(scene, system, timer, driver, left=left)


def solved(
    scene: Scene,
    system: CoupledSystem,
    timer: StageTimer,
    driver: EigenSolver,
    values: Mapping[str, float] | None = None,
    *,
    left: bool = False,
) -> Result:
    """Compute the modes of an assembled scene; collective."""
    top, low = scene.window.max_frequency, scene.window.min_growth
    options: Any = {"min_growth": low, "left": left, "hints": True, "timer": timer}
    solve = partial(driver.solve, top, values, **options)
    return result_of_modes(scene, system, timer, in_memory_or_on_disk(scene, driver, solve))


def result_of_modes(scene: Scene, system: CoupledSystem, timer: StageTimer, modes: Modes) -> Result:
    """Return the result of modes, with all warnings added; collective.

    Parameters are those of :func:`solved`; ``modes`` have the warnings of the solver.
    """
    result = Result(
        scene,
        timer,
        skipped_by(scene),
        spectrum=modes,
        reactions={} if system.steady is None else system.steady.reactions,
        coupled=system,
    )
    warnings = list(modes.warnings)
    with timer("post-processing"):
        warnings += system_warnings(scene, system, modes.values)
        moving = ", ".join(sorted(modes.pencil.at_rest().names))
        if system.steady is not None and modes.left is not None and moving:
            told = f"derivatives ignore that the state of steady sliding depends on {moving}"
            warnings.append(ResultWarning(STATE_KEPT, told, {"parameters": moving}))
        warnings += short_modes(scene, system.bodies, result.mode_shapes, len(modes))
    return replace(result, warnings=tuple(warnings))


def run_static(scene: Scene, **options: Unpack[RunOptions]) -> Result:
    """Compute displacements and contact stresses of a scene; options are :class:`RunOptions`.

    Raises
    ------
    InputError
        If the scene has another kind of analysis.
    """
    from cea.eigen.static import solve_static
    from cea.system.contact_stresses import contact_stresses
    from cea.system.support_forces import support_reactions
    from scenes.checking.equilibrium import motion_warnings, tension_warnings

    if not isinstance(scene.analysis, StaticAnalysis):
        raise InputError("analysis.kind", scene.analysis.kind, "'static'")
    system, timer = coupled(scene, **options)
    if system.steady is not None:
        x, reactions = system.steady.displacement, system.steady.reactions
    else:
        with timer("assembly"):
            pencil = system.pencil()
        with factors_of(scene):
            equilibrium = solve_static(pencil, system.load, timer)
        x = equilibrium.displacement
        with timer("post-processing"):
            reactions = support_reactions(system, x, equilibrium.forces)
    with timer("post-processing"):
        stresses = {
            name: contact_stresses(system, name, x, scene.analysis.samples)
            for name in scene.contacts
        }
        warnings = system_warnings(scene, system)
        if system.steady is None:
            warnings += (*tension_warnings(system, x), *motion_warnings(scene, system, x))
    return Result(
        scene,
        timer,
        skipped_by(scene),
        warnings,
        stresses=stresses,
        reactions=reactions,
        coupled=system,
        solution=x,
    )


def estimate_errors(
    result: Result,
    richer: Scene | None = None,
    *,
    steps: int = 2,
    listener: Callable[[str], None] | None = None,
) -> "ErrorEstimate":
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
        A richer scene; by default that with a degree more (:func:`scenes.richer_scene`).
    steps
        Number of block inverse iterations; one does not give an estimate of the remaining error.
    listener
        Called with the name of each stage as it begins.

    Raises
    ------
    InputError
        If there are no modes, or the scenes have different bodies.
    """
    from cea.nested.estimate import error_estimate
    from cea.nested.prolongation import of_body, of_system
    from scenes.spec.refinement import richer_scene

    scene = richer if richer is not None else richer_scene(result.scene)
    own, names = result.scene, list(scene.bodies)
    allowed = f"those of the coarse scene: {', '.join(own.bodies)}"
    require(names == list(own.bodies), "bodies", names, allowed)
    one_sided = own.damped or own.rotates or own.has_friction or own.has_turning_pressure
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


def coupled(scene: Scene, **options: Unpack[RunOptions]) -> tuple[CoupledSystem, StageTimer]:
    """Return the coupled system of a scene and the timer of its assembly; collective.

    If a contact has a law, the system is linearised about steady sliding and stores that state.
    """
    timer = StageTimer(options.get("listener"))
    check_memory(scene)
    bodies = build_bodies(scene, timer, options.get("bodies"))
    contacts = build_contacts(scene, bodies, timer)
    leave_out = options.get("leave_out", True)
    system = build_system(scene, bodies, contacts, timer, leave_out=leave_out)
    if scene.slides_steadily:
        from cea.system.steady_path import steady_sliding
        from cea.system.support_forces import support_reactions

        steps = scene.analysis.load_steps
        with factors_of(scene):
            steady = steady_sliding(system, timer, steps=steps or 1, history=steps is not None)
        with timer("assembly"):
            system = system.linearised(steady, geometric_stiffness=scene.stiffened_by_stress)
        with timer("post-processing"):
            reactions = support_reactions(system, steady.displacement, steady.forces)
        system = replace(system, steady=replace(steady, reactions=reactions))
    return system, timer


def system_warnings(
    scene: Scene, system: CoupledSystem, values: Mapping[str, float] | None = None
) -> tuple[ResultWarning, ...]:
    """Return the warnings about bodies, contacts, their forms and steady sliding; collective."""
    found = [*warnings_of(scene, system.bodies, system.contacts), *system.warnings_at(values or {})]
    if system.steady is not None:
        from scenes.checking.equilibrium import steady_warnings

        found += steady_warnings(scene, system, system.steady)
    return tuple(found)
