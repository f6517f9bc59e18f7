"""A scene solved on finer and finer meshes of each backend until bars hold the digits asked for."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from comparisons.converge.combine import combine
from comparisons.converge.course import Clock, Course
from comparisons.converge.ladder import window_of
from comparisons.converge.request import Request
from comparisons.converge.told import data_of
from comparisons.kit.progress import Progress
from scenes.refinement.meshes import from_file
from scenes.results.record import record
from scenes.spec.body import Backend
from scenes.spec.reading import Scene, load_scene

COMMAND = "converge"
"""Command that a result is marked with."""


def backends_of(scene: Scene, request: Request) -> tuple[Backend, ...]:
    """Backends that are refined: those asked for, or those that every shape has a mesh of."""
    if request.backends is not None:
        return request.backends
    shapes = [body for body in scene.bodies.values() if not from_file(body)]
    every: tuple[Backend, ...] = ("iga", "fe") if shapes else ("fe",)
    meshes = {b: [getattr(body.mesh, b) for body in shapes] for b in every}
    return tuple(b for b in every if None not in meshes[b]) or every


def run_converge(
    request: Request, progress: Progress, begun: float | None = None
) -> dict[str, Any]:
    """Refine a scene on each backend by turns until bars hold the digits asked for; collective.

    Parameters
    ----------
    request
        What is asked for.
    progress
        Told what is being run and the time left.
    begun
        When the command began, by :func:`time.perf_counter`; None takes now.

    Returns
    -------
    dict
        Record with ``first``: the digits held and what more would cost; ``held``; ``words``: how
        many modes have which word; ``modes``, each with value, bars and verdict; ``levels``, every
        mesh; ``backends``: why each ended; ``scenes``: meshes as text of scene files.

    Raises
    ------
    InputError
        When the scene cannot be refined.
    """
    clock = Clock(request.budget, begun)
    scene = load_scene(Path(request.scene), list(request.overrides))
    courses = {b: Course(scene, b, request) for b in backends_of(scene, request)}
    while active := [course for course in courses.values() if not course.done]:
        min(active, key=lambda course: course.spent).advance(clock, progress)
    progress.stage("report")
    ran: Mapping[Backend, Course] = {b: c for b, c in courses.items() if c.followed.meshes}
    modes = combine(
        {backend: course.followed for backend, course in ran.items()},
        {backend: course.bars for backend, course in ran.items()},
        window_of(scene).growth_threshold,
    )
    data = data_of(courses, modes, request, scene)
    return record(
        COMMAND,
        data,
        inputs=request.plain(),
        seconds=clock.gone,
        warnings=data.pop("warnings"),
    )
