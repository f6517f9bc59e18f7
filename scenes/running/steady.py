"""Steady sliding: where a contact has a law, its loads come before modes."""

from dataclasses import replace

from cea.system.coupled import CoupledSystem
from cea.system.steady_path import steady_sliding
from cea.system.support_forces import support_reactions
from cea.timing import StageTimer
from scenes.spec.reading import Scene


def linearised(scene: Scene, system: CoupledSystem, timer: StageTimer) -> CoupledSystem:
    """A system linearised about its state of steady sliding, which it keeps; collective.

    Parameters
    ----------
    scene
        A scene of which a contact has a law of its closure.
    system
        Its system.
    timer
        What the stages are timed with.

    Raises
    ------
    ConvergenceError
        When there is no state of steady sliding.
    """
    steps = scene.analysis.load_steps
    steady = steady_sliding(system, timer, steps=steps or 1, history=steps is not None)
    with timer("assembly"):
        system = system.linearised(steady, geometric_stiffness=scene.stiffened_by_stress)
    with timer("post-processing"):
        reactions = support_reactions(system, steady.displacement, steady.forces)
    return replace(system, steady=replace(steady, reactions=reactions))
