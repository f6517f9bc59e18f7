"""Static analysis of a scene: displacements and contact stresses."""

from typing import Unpack

from cea.eigen.static import solve_static
from cea.errors import InputError
from cea.system.contact_stresses import contact_stresses
from cea.system.support_forces import support_reactions
from scenes.checking.equilibrium import motion_warnings
from scenes.checking.memory import factors_of
from scenes.checking.skipped import skipped_by
from scenes.results.result import Result
from scenes.running.system import RunOptions, coupled, system_warnings
from scenes.spec.reading import Scene, StaticAnalysis


def run_static(scene: Scene, **options: Unpack[RunOptions]) -> Result:
    """Compute displacements and contact stresses of a scene; options are :class:`RunOptions`.

    Raises
    ------
    InputError
        If the scene has another kind of analysis.
    """
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
            warnings = (*warnings, *motion_warnings(scene, system, x))
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
