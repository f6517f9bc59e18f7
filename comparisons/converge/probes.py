"""What each body and direction owes to the errors of a mesh, measured one after the other.

The modes of a mesh are corrected (:func:`scenes.nested.eigenvalues_in`) in a space richer along
one direction of one body alone, which has twice the elements there, or richer in one layer towards
its singular edges. What that changes is the part of the error that comes from there, but for what
theory says that the richer space leaves of it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from comparisons.converge.estimated import seconds_of
from comparisons.converge.levels import Level, widened
from comparisons.converge.parts import EDGES, Part, Parts
from comparisons.kit.progress import Progress
from scenes.nested import eigenvalues_in
from scenes.read import Scene
from scenes.refinement import (
    MAX_DEGREE,
    RATIO,
    BodyResolution,
    Resolution,
    counted,
    refined,
    structured,
)
from scenes.refinement_edges import crowding
from scenes.spec.body import Backend
from scenes.variants import on_backend


@dataclass(frozen=True)
class Probe:
    """A space that is richer in one part.

    Parameters
    ----------
    part
        The part.
    resolution
        The space.
    takes
        Part of the error that it is expected to take off.
    """

    part: Part
    resolution: Resolution
    takes: float


def probes(scene: Scene, backend: Backend, resolution: Resolution) -> list[Probe]:
    """A probe of every part that the errors of a mesh are made of.

    Parameters
    ----------
    scene
        The scene as the user gives it.
    backend, resolution
        The mesh, densities of all bodies given.
    """
    on = on_backend(scene, backend)
    found = []
    for name, own in resolution.bodies:
        for part, richer, takes in _of_body(on, backend, name, own):
            bodies = {**dict(resolution.bodies), name: richer}
            space = replace(resolution, bodies=tuple(bodies.items()))
            found.append(Probe(part, space, takes))
    return found


def _of_body(
    scene: Scene, backend: Backend, name: str, own: BodyResolution
) -> Iterator[tuple[Part, BodyResolution, float]]:
    body, along = scene.bodies[name], range(len(own.densities))
    halved = 1 - 2.0 ** (-2 * own.degree)
    if backend == "fe" and not structured(body):
        if own.degree < MAX_DEGREE[backend]:
            yield Part(name, tuple(along)), replace(own, degree=own.degree + 1), 1.0
        else:
            yield Part(name, tuple(along)), replace(own, densities=_doubled(own, along)), halved
        return
    for d in along:
        yield Part(name, (d,)), replace(own, densities=_doubled(own, (d,))), halved
    towards = crowding(scene, name).towards
    if towards and structured(body):
        across = tuple(d for d in along if body.geometry.directions[d] in towards)
        layered = replace(own, layers=own.layers + 1)
        yield Part(name, across, edges=True), layered, 1 - RATIO ** (2 * EDGES)


def _doubled(own: BodyResolution, along: range | tuple[int, ...]) -> tuple[float, ...]:
    return tuple(2 * x if d in along else x for d, x in enumerate(own.densities))


def seconds_of_probes(scene: Scene, backend: Backend, resolution: Resolution) -> float:
    """Time (s) that measuring is estimated to take, not calibrated."""
    total = 0.0
    for probe in probes(scene, backend, counted(scene, backend, resolution)):
        richer = widened(refined(scene, backend, probe.resolution))
        total += seconds_of(richer, 1.0)
    return total


def measured(level: Level, number: int, scene: Scene, progress: Progress) -> Parts:
    """Errors of the modes of a mesh in their parts; collective.

    Parameters
    ----------
    level
        The mesh, with its run.
    number
        Its number in the sequence.
    scene
        The scene as the user gives it.
    progress
        Told what is probed, and the stages.

    Raises
    ------
    InputError
        When the machine has not the memory it takes.
    ConvergenceError
        When a richer pencil is singular amid the modes.
    """
    assert level.result is not None
    resolution = counted(scene, level.backend, level.resolution)
    found = probes(scene, level.backend, resolution)
    corrected = []
    for probe in found:
        richer = widened(refined(scene, level.backend, probe.resolution))
        corrected.append(eigenvalues_in(level.result, richer, listener=progress.stage))
    return Parts(
        tuple(probe.part for probe in found),
        np.array([probe.takes for probe in found]),
        level.eigenvalues,
        np.array(corrected),
        ~level.rigid,
        scene.damped or scene.rotates,
        resolution,
        number,
    )
