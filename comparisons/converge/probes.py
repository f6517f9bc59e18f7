"""What each body and direction owes to the errors of a mesh, measured one after the other.

The modes of a mesh are corrected (:func:`scenes.nested.eigenvalues_in`) in a space richer along
one direction of one body alone, which has twice the elements there, or richer in one layer towards
its singular edges. What that changes is the part of the error that comes from there, but for what
theory says that the richer space leaves of it.

Where every element along a direction lies at singular edges, as the one across a thin disc does, a
layer that runs through the whole body takes off of what is smooth there too: it is laid beside
twice the elements, and what these alone change is left out.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from cea.arrays import Complexes, Floats
from cea.system.strain_energies import strain_energies
from comparisons.converge.estimated import seconds_of
from comparisons.converge.levels import Level, widened
from comparisons.converge.parts import EDGES, RE_ENTRANT, Part, Parts
from comparisons.kit.progress import Progress
from meshes.edge_layers import RATIO
from scenes.nested import eigenvalues_in
from scenes.read import Scene
from scenes.refinement import (
    MAX_DEGREE,
    BodyResolution,
    Resolution,
    counted,
    layers_at_edges,
    refined,
    structured,
)
from scenes.refinement_edges import crowding
from scenes.spec.body import Backend, BodySpec
from scenes.variants import on_backend

_OF_DEGREE: dict[Backend, float] = {"iga": 1.0, "fe": 2.0}
"""What a degree more does at singular edges over what as many more elements do: the p-version
converges twice as fast there (Babuska and Suri, SIAM J. Numer. Anal. 24 (1987) 750)."""


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
    beside
        A space in which all is richer but the part; None is that of the mesh itself.
    """

    part: Part
    resolution: Resolution
    takes: float
    beside: Resolution | None = None


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
        for part, richer, takes, beside in _of_body(on, backend, name, own):
            plain = None if beside == own else _with(resolution, name, beside)
            found.append(Probe(part, _with(resolution, name, richer), takes, plain))
    return found


def _with(resolution: Resolution, name: str, own: BodyResolution) -> Resolution:
    """A mesh with another resolution of one body."""
    return replace(resolution, bodies=tuple({**dict(resolution.bodies), name: own}.items()))


def _of_body(
    scene: Scene, backend: Backend, name: str, own: BodyResolution
) -> Iterator[tuple[Part, BodyResolution, float, BodyResolution]]:
    body, along = scene.bodies[name], range(len(own.densities))
    halved = 1 - 2.0 ** (-2 * own.degree)
    if backend == "fe" and not structured(body):
        if own.degree < MAX_DEGREE[backend]:
            yield Part(name, tuple(along)), replace(own, degree=own.degree + 1), 1.0, own
        else:
            finer = replace(own, densities=_doubled(own, along))
            yield Part(name, tuple(along)), finer, halved, own
        return
    for d in along:
        yield Part(name, (d,)), replace(own, densities=_doubled(own, (d,))), halved, own
    edges = crowding(scene, name)
    if edges and structured(body):
        towards = edges.towards
        across = tuple(d for d in along if body.geometry.directions[d] in towards)
        alone = layers_at_edges(body, edges)  # layers divide no other elements
        thin = tuple(d for d in across if not alone and _all_at_edges(body, towards, d, own))
        beside = replace(own, densities=_doubled(own, thin))
        layered = replace(beside, layers=own.layers + 1)
        exponent = RE_ENTRANT if edges.re_entrant else EDGES
        part = Part(name, across, True, _OF_DEGREE[backend], exponent)
        yield part, layered, 1 - RATIO ** (2 * exponent), beside


def _all_at_edges(
    body: BodySpec, towards: Mapping[str, tuple[float, ...]], d: int, own: BodyResolution
) -> bool:
    """Whether each element along a direction lies at a coordinate that elements crowd towards."""
    mesh = body.mesh.fe if body.backend == "fe" else body.mesh.iga
    if mesh is None or not mesh.elements:
        return False
    count = round(own.densities[d] * mesh.elements[d])
    return count <= len(towards[body.geometry.directions[d]])


def _doubled(own: BodyResolution, along: range | tuple[int, ...]) -> tuple[float, ...]:
    return tuple(2 * x if d in along else x for d, x in enumerate(own.densities))


def seconds_of_probes(scene: Scene, backend: Backend, resolution: Resolution) -> float:
    """Time (s) that measuring is estimated to take, not calibrated."""
    total = 0.0
    found = probes(scene, backend, counted(scene, backend, resolution))
    spaces = dict.fromkeys(space for each in found for space in (each.beside, each.resolution))
    for space in spaces:
        if space is not None:
            total += seconds_of(widened(refined(scene, backend, space)), 1.0)
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
    known: dict[Resolution | None, Complexes] = {None: level.eigenvalues}
    for probe in found:
        for space in (probe.beside, probe.resolution):
            if space is not None and space not in known:
                richer = widened(refined(scene, level.backend, space))
                known[space] = eigenvalues_in(level.result, richer, listener=progress.stage)
        change = known[probe.resolution] - known[probe.beside]
        corrected.append(level.eigenvalues + change)
    return Parts(
        tuple(probe.part for probe in found),
        np.array([probe.takes for probe in found]),
        level.eigenvalues,
        np.array(corrected),
        _strained(level, [probe.part.body for probe in found]),
        ~level.rigid,
        scene.damped or scene.rotates,
        resolution,
        number,
    )


def _strained(level: Level, bodies: list[str]) -> Floats:
    """Strain energies of bodies over abs(lambda)^2 of each mode; 1 of rigid motions."""
    assert level.result is not None
    energies = strain_energies(level.result.system, level.result.modes.vectors)
    squares = np.where(level.rigid, 1.0, np.abs(level.eigenvalues) ** 2)
    return np.array([np.where(level.rigid, 1.0, energies[name] / squares) for name in bodies])
