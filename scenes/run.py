"""One scene from geometry to numbers."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypedDict, Unpack

from cea.body import Body
from cea.contact.interface import Interface
from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.modes import Modes
from cea.eigen.run_window import run_window
from cea.eigen.static import solve_static
from cea.errors import InputError
from cea.system.contact_stresses import contact_stresses
from cea.system.coupled import CoupledSystem
from cea.system.held import support_reactions
from cea.system.steady_sliding import steady_sliding
from cea.timing import StageTimer
from cea.warned import ResultWarning
from scenes.body_meshes import changed_elements
from scenes.build import (
    build_bodies,
    build_interfaces,
    build_system,
    reusable_bodies,
    reusable_interfaces,
)
from scenes.doubts import doubtful_motions, doubtful_numbers, left_alone, overlapping_bodies
from scenes.factor_storage import factor_storage
from scenes.memory import check_memory
from scenes.motion_warnings import faster_than_waves
from scenes.read import Scene
from scenes.results import ModesResult, StaticResult
from scenes.spec.analysis import ComplexEigenvalueAnalysis, StaticAnalysis
from scenes.steady import kept_state_warnings, steady_warnings
from scenes.unused import unused_input
from scenes.warnings import scene_warnings, short_modes


class RunOptions(TypedDict, total=False):
    """Options of a run, by name.

    Parameters
    ----------
    bodies
        Bodies of an earlier run: those that the scene makes of the same mesh, material, supports,
        springs and loads are used again with their matrices, others are built.
    interfaces
        Contact points of an earlier run: those of the same sides of these bodies, formulation,
        reach and ``max_missed`` are used again, others are located.
    leave_out
        Whether friction is left out where mu = 0, as it is by default; False measures what that
        saves.
    listener
        Called with the name of each stage as it begins.
    """

    bodies: Mapping[str, Body] | None
    interfaces: Mapping[str, Interface] | None
    leave_out: bool
    listener: Callable[[str], None] | None


def run_scene(scene: Scene, **options: Unpack[RunOptions]) -> ModesResult | StaticResult:
    """Run a scene.

    Parameters
    ----------
    scene
        The scene.
    options
        See :class:`RunOptions`.

    Raises
    ------
    InputError
        When bodies or interfaces have other names than those of the scene, or the machine has not
        the memory it takes.
    """
    if isinstance(scene.analysis, ComplexEigenvalueAnalysis):
        return run_modes(scene, **options)
    return run_static(scene, **options)


def run_modes(scene: Scene, *, left: bool = False, **options: Unpack[RunOptions]) -> ModesResult:
    """Modes of a scene whose analysis asks for them.

    Parameters
    ----------
    scene
        The scene.
    left
        Whether left eigenvectors are wanted too, for sensitivities and true condition numbers.
    options
        See :class:`RunOptions`.

    Raises
    ------
    InputError
        When the analysis is another, or bodies or interfaces have other names than the scene's.
    """
    if not isinstance(scene.analysis, ComplexEigenvalueAnalysis):
        raise InputError("analysis.kind", scene.analysis.kind, "'cea', which gives modes")
    system, interfaces, timer = coupled(scene, **options)
    with timer("assembly"):
        pencil = system.pencil(leave_out=options.get("leave_out", True))
    with KrylovSchur(pencil) as driver:
        return solved(scene, system, interfaces, timer, driver, left=left)


def solved(
    scene: Scene,
    system: CoupledSystem,
    interfaces: Mapping[str, Interface],
    timer: StageTimer,
    driver: KrylovSchur,
    values: Mapping[str, float] | None = None,
    *,
    left: bool = False,
) -> ModesResult:
    """Modes of a scene whose system is assembled; collective.

    Parameters
    ----------
    scene
        The scene.
    system, interfaces
        Its system and its contact points, or those of a scene that has other parameters.
    timer
        What the stages are timed with.
    driver
        What solves the pencil of the system.
    values
        Parameters at which it is that of the scene.
    left
        Whether left eigenvectors are wanted too.
    """
    analysis, storage = scene.analysis, factor_storage(scene)
    assert isinstance(analysis, ComplexEigenvalueAnalysis)
    with storage.kept():
        try:
            modes = run_window(
                driver,
                analysis.max_frequency,
                values,
                min_growth=analysis.min_growth,
                left=left,
                timer=timer,
            )
        finally:
            if storage.place == "disk":
                driver.free()
    modes = replace(modes, warnings=(*modes.warnings, *storage.warnings))
    return result_of_modes(scene, system, interfaces, timer, modes)


def run_static(scene: Scene, **options: Unpack[RunOptions]) -> StaticResult:
    """Displacement of a scene whose analysis asks for it; options are :class:`RunOptions`.

    Raises
    ------
    InputError
        When the analysis is another, or bodies or interfaces have other names than the scene's.
    """
    if not isinstance(scene.analysis, StaticAnalysis):
        raise InputError("analysis.kind", scene.analysis.kind, "'static'")
    system, interfaces, timer = coupled(scene, **options)
    if system.steady is not None:
        x, reactions = system.steady.displacement, system.steady.reactions
    else:
        with timer("assembly"):
            pencil = system.pencil(leave_out=options.get("leave_out", True))
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
            warnings = (*warnings, *doubtful_motions(scene, system, x))
    return StaticResult(
        scene,
        system,
        interfaces,
        timer,
        skipped_by(scene),
        x,
        stresses,
        warnings=warnings,
        reactions=reactions,
    )


def result_of_modes(
    scene: Scene,
    system: CoupledSystem,
    interfaces: Mapping[str, Interface],
    timer: StageTimer,
    modes: Modes,
) -> ModesResult:
    """Modes of a scene as a result, with all that they must be read with; collective.

    The parameters are those of :func:`solved`; modes come with what the solver warns of.
    """
    result = ModesResult(scene, system, interfaces, timer, skipped_by(scene), modes)
    with timer("post-processing"):
        found = (
            *system_warnings(scene, system, modes.values),
            *kept_state_warnings(system.steady, modes),
            *short_modes(scene, result.bodies, result.mode_shapes, len(modes)),
        )
    modes = replace(modes, warnings=(*modes.warnings, *found))
    reactions = {} if system.steady is None else system.steady.reactions
    return replace(result, modes=modes, reactions=reactions)


def system_warnings(
    scene: Scene, system: CoupledSystem, values: Mapping[str, float] | None = None
) -> tuple[ResultWarning, ...]:
    """What bodies, contacts, their forms and steady sliding must be read with; collective.

    Parameters
    ----------
    scene
        The scene.
    system
        Its system, or that of a scene that has other parameters.
    values
        Parameters at which the pencil of the system is that of the scene.
    """
    steady = system.steady
    return (
        *doubtful_numbers(scene),
        *overlapping_bodies(scene, system.bodies),
        *faster_than_waves(scene, system.bodies),
        *scene_warnings(scene, system.contacts),
        *system.warnings_at(values or {}),
        *steady_warnings(scene, system),
        *(doubtful_motions(scene, system, steady.displacement) if steady is not None else ()),
    )


def coupled(
    scene: Scene,
    *,
    bodies: Mapping[str, Body] | None = None,
    interfaces: Mapping[str, Interface] | None = None,
    leave_out: bool = True,
    listener: Callable[[str], None] | None = None,
) -> tuple[CoupledSystem, Mapping[str, Interface], StageTimer]:
    """Coupled matrices of a scene, its contact points and the seconds they took.

    Parameters are those of :class:`RunOptions`.
    """
    timer = StageTimer(listener)
    reused = reusable_bodies(scene, bodies)
    if len(reused) < len(scene.bodies):
        check_memory(scene)
    bodies = build_bodies(scene, timer, reused)
    located = reusable_interfaces(scene, bodies, interfaces)
    interfaces = build_interfaces(scene, bodies, timer, located)
    system = build_system(scene, bodies, interfaces, timer, leave_out=leave_out)
    if scene.slides_steadily:
        steps = scene.analysis.load_steps
        steady = steady_sliding(system, timer, steps=steps or 1, history=steps is not None)
        with timer("assembly"):
            stiffens = scene.stiffened_by_stress
            system = system.linearised(steady, geometric_stiffness=stiffens)
        with timer("post-processing"):
            reactions = support_reactions(system, steady.displacement, steady.forces)
            system = replace(system, steady=replace(steady, reactions=reactions))
    return system, interfaces, timer


def skipped_by(scene: Scene) -> dict[str, str]:
    """What a scene does not need, or gives without use, with the reason; none is computed."""
    rotations = [body.rotation for body in scene.bodies.values() if body.rotation is not None]
    skipped = unused_input(scene)
    if reason := left_alone(scene):
        skipped["doubts of units"] = reason
    if not scene.slides_steadily:
        skipped["newton"] = "contact stiffness is known, no steady sliding state is sought"
    if not scene.damped:
        linear = "" if rotations else ": the problem is linear in lambda^2"
        skipped["damping"] = f"no damping{linear}"
    if not rotations:
        skipped["gyroscopic"] = "no body rotates"
    elif not any(rotation.convective_stiffness for rotation in rotations):
        skipped["convective stiffness"] = "not asked for: of the order of rho Omega^2"
    if not any(contact.mu for contact in scene.contacts.values()):
        skipped["friction"] = "mu = 0: no slip operator, symmetric solver"
    of_modes = scene.analysis.kind == "cea"
    if of_modes and scene.slides_steadily and not scene.stiffened_by_stress:
        skipped["geometric stiffness"] = "not asked for: of the order of sigma / E"
    if not scene.contacts:
        skipped["search"] = "no contacts"
    if scene.analysis.kind == "static":
        bodies = scene.bodies.values()
        used = {"damping": any(body.circulates for body in bodies), "gyroscopic": False}
        used["mass"] = any(body.rotates_in_equilibrium for body in bodies)
        skipped["eigenvalues"] = "static analysis"
        for name, acts in used.items():
            if skipped.pop(name, None) is None and not acts:
                skipped[name] = "static analysis"
    elif not scene.loads:
        skipped["loads"] = "no loads"
    if not scene.output.pictures:
        skipped["pictures"] = "none asked for"
    if not scene.output.paraview:
        skipped["paraview"] = "no files for ParaView asked for"
    meshes = [body.mesh.fe for body in scene.bodies.values() if body.backend == "fe"]
    if not any(mesh.size for mesh in meshes if mesh is not None):
        skipped["gmsh"] = "no body has an unstructured mesh"
    return skipped | changed_elements(scene)
