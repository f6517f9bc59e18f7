"""Complex eigenvalue analysis of a scene."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Unpack

from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.errors import ResultWarning
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from scenes.checking.memory import in_memory_or_on_disk
from scenes.checking.resolution import short_modes
from scenes.checking.skipped import skipped_by
from scenes.results.result import Result
from scenes.running.system import RunOptions, coupled, system_warnings
from scenes.spec.reading import Scene

STATE_KEPT = "steady-state-kept"
"""Kind of the warning that derivatives ignore the dependence of steady sliding on parameters."""


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
