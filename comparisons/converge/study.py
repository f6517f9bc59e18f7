"""A scene refined on both backends until its modes hold the digits asked for."""

from collections.abc import Mapping
from math import isfinite, tau
from pathlib import Path
from time import perf_counter
from typing import Any

from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from comparisons.converge.combined import Mode, combine
from comparisons.converge.course import Course
from comparisons.converge.judged import Judged
from comparisons.converge.levels import elements_of
from comparisons.converge.request import Request
from comparisons.converge.steps import Step
from comparisons.converge.tables import degree_text, elements_text
from comparisons.converge.told import data_of, warnings_of
from comparisons.kit.progress import Progress
from scenes.read import Scene, load_scene
from scenes.refinement import check_refinable, refined
from scenes.spec.body import Backend
from scenes.stored import record

COMMAND = "converge"
"""Command that a result is marked with."""

HELD = "the digits asked for are held"
"""Why a backend ended that reached them."""

_FINISH = 1.5
"""Seconds kept back for tables and the page."""
_AGAIN = 3.0
"""Factor by which bars are to fall where backends disagree."""
_ROUNDS_OF_DISAGREEMENT = 2


class _OutOfTimeError(Exception):
    """A mesh that took longer than expected was given up."""


class _Clock:
    """Time since the start of the command, the same on all ranks."""

    def __init__(self, budget: float, begun: float | None) -> None:
        self._begun = perf_counter() if begun is None else begun
        self._budget = budget

    @property
    def gone(self) -> float:
        """Seconds since the start."""
        return float(MPI.COMM_WORLD.bcast(perf_counter() - self._begun))

    @property
    def left(self) -> float:
        """Seconds of the budget that meshes may take."""
        return self._budget - self.gone - _FINISH

    def guarded(self, progress: Progress) -> Progress:
        """Progress that gives a mesh up as a stage of it begins after the budget; collective."""

        def stage(name: str) -> None:
            if self.left < 0:
                raise _OutOfTimeError
            progress.stage(name)

        return Progress(progress.step, stage)


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
        Record with ``modes``, each with value, bars and verdict, and what each backend says of it;
        ``levels``, every mesh with its errors and time; ``backends``: why each ended and what a
        digit more would cost; ``lost`` modes; ``scenes``: meshes as text of scene files;
        ``mortar``: contacts whose formulation was changed.

    Raises
    ------
    InputError
        When the scene cannot be refined.
    """
    clock = _Clock(request.budget, begun)
    scene = load_scene(Path(request.scene), list(request.overrides))
    for backend in request.backends:
        check_refinable(scene, backend)
    courses = {backend: Course(backend, scene, request) for backend in request.backends}
    _refine(courses, clock, progress)
    modes, judged = _compared(courses, scene)
    for _ in range(_ROUNDS_OF_DISAGREEMENT):
        if not any(mode.agree is False for mode in modes):
            break
        if not _refine_once_more(courses, judged, clock, progress):
            break
        modes, judged = _compared(courses, scene)
    progress.stage("report")
    return record(
        COMMAND,
        data_of(courses, modes, request, scene),
        inputs=request.plain(),
        seconds=clock.gone,
        warnings=warnings_of(courses, modes, scene),
    )


def _refine(courses: Mapping[Backend, Course], clock: _Clock, progress: Progress) -> None:
    """Meshes by turns, those of the backend that has spent less first, until all have ended."""
    while active := [course for course in courses.values() if not course.ended]:
        course = min(active, key=lambda each: (len(each.sequence.levels) > 0, each.spent))
        _turn(course, len(active), clock, progress)


def _turn(course: Course, active: int, clock: _Clock, progress: Progress) -> None:
    """One more mesh of a backend, or the reason why there is none."""
    if course.holds:
        course.ended = HELD
        return
    first = not course.sequence.levels
    left = clock.left / active if first else clock.left
    if not first and course.can_measure(left / active):
        progress.step(
            f"{course.backend}, what each body and direction owes, {max(clock.left, 0):.0f} s left"
        )
        try:
            course.measure(clock.guarded(progress))
        except _OutOfTimeError:
            course.ended = "the budget: measuring errors took longer than expected"
        return
    if _corrected(course, clock, progress, last=False):
        return
    step = course.next(left)
    if step is None or (not first and step.seconds > left):
        course.ended = _why_not(course, left)
        if _corrected(course, clock, progress, last=True) and course.holds:
            course.ended = HELD
        return
    _step(course, step, clock, progress)
    try:
        level = course.run(step, clock.guarded(progress))
    except (InputError, ConvergenceError) as error:
        course.ended = f"the next mesh failed: {error}"
    except _OutOfTimeError:
        course.ended = "the budget: a mesh that took longer than expected was given up"
    else:
        progress.stage("matching")
        course.follow(level)


def _corrected(course: Course, clock: _Clock, progress: Progress, *, last: bool) -> bool:
    """Correct a backend's newest mesh in a richer space where that is worth it; whether it was."""
    richer = course.correction(clock.left, last=last)
    if richer is None:
        return False
    progress.step(f"{course.backend}, corrected in a richer space, {max(clock.left, 0):.0f} s left")
    try:
        course.correct(richer, clock.guarded(progress))
    except (InputError, ConvergenceError, _OutOfTimeError):
        return False  # the bars of the meshes stay
    return True


def _step(course: Course, step: Step, clock: _Clock, progress: Progress) -> None:
    mesh, seconds = step.resolution.plain(), step.seconds
    elements = elements_of(refined(course.scene, course.backend, step.resolution))
    need = course.need
    seen = len(course.sequence.levels) > 1 and isfinite(need) and need > 1
    wanted = f", bars {need:.2g} times too large" if seen else ""
    progress.step(
        f"{course.backend}, degree {degree_text(mesh)}, {elements_text(elements)}: "
        f"about {seconds:.2g} s of {max(clock.left, 0):.0f} s{wanted}"
    )


def _why_not(course: Course, left: float) -> str:
    """Why no mesh follows: none is left that refines, or all take too much time or memory."""
    possible = course.cost_of(2.0)
    if possible is None:
        return "no finer mesh is expected to halve the errors"
    if possible.seconds <= left and not course.plans.fits(possible.resolution):
        return "memory: the next mesh would take more than the machine has free"
    return f"the budget: the next mesh would take about {possible.seconds:.2g} s"


def _refine_once_more(
    courses: Mapping[Backend, Course],
    judged: Mapping[Backend, Judged],
    clock: _Clock,
    progress: Progress,
) -> bool:
    """A finer mesh of every backend that has the time for one; whether there was one."""
    done = False
    for course in courses.values():
        step = course.next(clock.left, _AGAIN) if course.backend in judged else None
        if step is None:
            continue
        _step(course, step, clock, progress)
        try:
            course.follow(course.run(step, clock.guarded(progress)))
        except (InputError, ConvergenceError, _OutOfTimeError):
            continue  # what there is stays, and the disagreement is told
        done = True
    return done


def _compared(
    courses: Mapping[Backend, Course], scene: Scene
) -> tuple[list[Mode], dict[Backend, Judged]]:
    """Modes of the newest meshes of all backends that have one."""
    ran = {b: course for b, course in courses.items() if course.sequence.levels}
    judged = {backend: course.judged for backend, course in ran.items()}
    sequences = {backend: course.sequence for backend, course in ran.items()}
    assert scene.analysis.kind == "cea"
    if not ran:
        return [], judged
    return combine(sequences, judged, tau * scene.analysis.max_frequency), judged
