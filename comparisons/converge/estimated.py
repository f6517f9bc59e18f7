"""The newest mesh's eigenvalues corrected in a richer space, as one more number of their sequences.

The hierarchical estimate (:mod:`scenes.nested`) takes a block of solves in a richer space and no
eigenproblem there. What it gives stands in a sequence as the richer mesh would, with what the last
solve changed beside its rounding; it has no vectors, so that no mesh can follow it.
"""

from dataclasses import replace
from time import perf_counter

import numpy as np

from cea.errors import InputError
from comparisons.converge.levels import Level
from comparisons.kit.progress import Progress
from scenes.memory import estimated_memory
from scenes.nested import estimate_errors
from scenes.read import Scene
from scenes.refinement import MAX_DEGREE, Resolution
from scenes.richer import Enrichment, richer_scene
from scenes.run_time import estimated_seconds

_SHARE = 0.5
"""Time of an estimate relative to that of a run in the richer space."""


def enrichment_of(level: Level) -> Enrichment:
    """How the space of a mesh is enriched: by a degree where there is one."""
    highest = level.resolution.degree >= MAX_DEGREE[level.backend]
    return "bisection" if highest else "degree"


def richer_resolution(level: Level) -> Resolution:
    """Resolution of the richer space."""
    old = level.resolution
    if enrichment_of(level) == "degree":
        return replace(old, degree=old.degree + 1)
    return replace(old, density=2 * old.density)


def richer_of(level: Level) -> Scene | None:
    """The scene in the richer space; None where there is none of such a mesh."""
    if level.result is None:
        return None
    try:
        return richer_scene(level.result.scene, enrichment_of(level))
    except InputError:
        return None


def seconds_of(richer: Scene, slower: float) -> float:
    """Time that the estimate is expected to take (s), runs being slower than estimated."""
    return _SHARE * slower * estimated_seconds(richer, estimated_memory(richer))


def estimated_level(level: Level, richer: Scene, progress: Progress) -> Level:
    """The mesh's modes corrected in a richer space; collective.

    Parameters
    ----------
    level
        The newest mesh, with its run.
    richer
        The scene in the richer space.
    progress
        Told the stages.

    Raises
    ------
    InputError
        When the machine has not the memory it takes.
    """
    assert level.result is not None
    begun = perf_counter()
    found = estimate_errors(level.result, richer, listener=progress.stage)
    uncertainties = found.uncertainties + found.remaining
    return replace(
        level,
        resolution=richer_resolution(level),
        dofs=found.dofs,
        seconds=float(level.result.comm.bcast(perf_counter() - begun)),
        estimated=seconds_of(richer, 1.0),
        eigenvalues=found.corrected,
        uncertainties=uncertainties,
        rigid=level.rigid & (np.abs(found.corrected) <= uncertainties),
        result=None,
        corrected=True,
    )
