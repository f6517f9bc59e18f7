"""The newest mesh's eigenvalues corrected in a richer space, as one more number of their sequences.

The hierarchical estimate (:mod:`scenes.nested`) takes a block of solves in a richer space and no
eigenproblem there. What it gives stands in a sequence as the richer mesh would, with the bound on
what the solves left beside its rounding; it has no vectors, so that no mesh can follow it.
"""

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError
from comparisons.converge.levels import Level, widened
from comparisons.kit.progress import Progress
from scenes.memory import estimated_memory
from scenes.nested import estimate_errors
from scenes.read import Scene
from scenes.refinement import MAX_DEGREE, Resolution, counted, refined
from scenes.richer import Enrichment, richer_scene
from scenes.run_time import estimated_seconds

SHARE = 0.5
"""Time of an estimate relative to that of a run in the richer space."""


def enrichment_of(level: Level) -> Enrichment:
    """How the space of a mesh is enriched: by a degree where there is one."""
    highest = level.resolution.degree >= MAX_DEGREE[level.backend]
    return "bisection" if highest else "degree"


@dataclass(frozen=True)
class Richer:
    """A richer space in which a mesh is corrected.

    Parameters
    ----------
    resolution
        The space, densities of all bodies given.
    scene
        The scene in it.
    """

    resolution: Resolution
    scene: Scene


def richer_of(level: Level, scene: Scene) -> Richer | None:
    """The space that is richer everywhere; None where there is none of such a mesh.

    Parameters
    ----------
    level
        The newest mesh.
    scene
        The scene as the user gives it.
    """
    if level.result is None:
        return None
    old, by = level.resolution, enrichment_of(level)
    same = replace(old, bodies=())
    new = (
        replace(same, degree=old.degree + 1)
        if by == "degree"
        else replace(same, density=2 * old.density)
    )
    try:
        richer = richer_scene(level.result.scene, by)
    except InputError:
        return None
    return Richer(counted(scene, level.backend, new), richer)


def finer_of(level: Level, scene: Scene, resolution: Resolution) -> Richer:
    """The space of a finer mesh, densities of all bodies given."""
    return Richer(resolution, widened(refined(scene, level.backend, resolution)))


def seconds_of(richer: Scene, slower: float) -> float:
    """Time that the estimate is expected to take (s), runs being slower than estimated."""
    return SHARE * slower * estimated_seconds(richer, estimated_memory(richer))


def estimated_level(level: Level, richer: Richer, allowed: Floats, progress: Progress) -> Level:
    """The mesh's modes corrected in a richer space; collective.

    Parameters
    ----------
    level
        The newest mesh, with its run.
    richer
        The richer space.
    allowed
        What solves may leave of errors of lambda (1/s), shape (n,).
    progress
        Told the stages.

    Raises
    ------
    InputError
        When the machine has not the memory it takes.
    """
    assert level.result is not None
    begun = perf_counter()
    found = estimate_errors(level.result, richer.scene, allowed=allowed, listener=progress.stage)
    uncertainties = found.uncertainties + found.remaining
    return replace(
        level,
        resolution=richer.resolution,
        dofs=found.dofs,
        seconds=float(level.result.comm.bcast(perf_counter() - begun)),
        estimated=seconds_of(richer.scene, 1.0),
        eigenvalues=found.corrected,
        uncertainties=uncertainties,
        rigid=level.rigid & (np.abs(found.corrected) <= uncertainties),
        result=None,
        corrected=True,
    )
