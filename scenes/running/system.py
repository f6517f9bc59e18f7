"""The coupled system of a scene, linearised about steady sliding if a contact has a law."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypedDict, Unpack

from cea.body import Body
from cea.errors import ResultWarning
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_contacts, build_system
from scenes.checking.memory import check_memory, factors_of
from scenes.checking.warnings import warnings_of
from scenes.spec.reading import Scene


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
