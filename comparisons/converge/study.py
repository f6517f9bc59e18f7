"""A scene refined on both backends until its modes hold the digits asked for."""

from collections.abc import Mapping
from math import isfinite, tau
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cea.eigen.eigenvalue_matching import assign
from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from comparisons.converge.combined import Mode, combine
from comparisons.converge.course import Course
from comparisons.converge.following import lost
from comparisons.converge.judged import Judged
from comparisons.converge.levels import Level
from comparisons.converge.request import Request, half_unit
from comparisons.kit.progress import Progress
from scenes.read import Scene, load_scene
from scenes.refinement import check_refinable, moved_to_mortar
from scenes.scene_toml import scene_text
from scenes.spec.body import Backend
from scenes.stored import record

COMMAND = "converge"
"""Command that a result is marked with."""

HELD = "the digits asked for are held"
"""Why a backend ended that reached them."""

_FINISH = 1.5
"""Seconds kept back for tables and the page."""
_REACH = 0.1
"""Relative distance at which an eigenvalue of a mesh no longer stands for a final one."""
_MORE = 10.0
"""Factor between errors of one digit and of the next."""
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
        _data(courses, modes, request, scene),
        inputs=request.plain(),
        seconds=clock.gone,
        warnings=_warnings(courses, modes, scene),
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
        progress.step(f"{course.backend}, what each body and direction owes")
        try:
            course.measure(clock.guarded(progress))
        except _OutOfTimeError:
            course.ended = "the budget: measuring errors took longer than expected"
        return
    if _corrected(course, clock, progress, last=False):
        return
    step = course.next(left)
    if step is None or (not first and step.seconds > left):
        course.ended = _why_not(course)
        if _corrected(course, clock, progress, last=True) and course.holds:
            course.ended = HELD
        return
    _step(course, step.resolution.plain(), clock, progress, step.seconds)
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


def _step(
    course: Course, mesh: Mapping[str, Any], clock: _Clock, progress: Progress, seconds: float
) -> None:
    need = course.need
    seen = len(course.sequence.levels) > 1 and isfinite(need) and need > 1
    wanted = f", bars {need:.2g} times too large" if seen else ""
    progress.step(
        f"{course.backend}, degree {mesh['degree']}, density {mesh['density']:.2g}, "
        f"{mesh['layers']} layers: about {seconds:.2g} s of {max(clock.left, 0):.0f} s{wanted}"
    )


def _why_not(course: Course) -> str:
    """Why no mesh follows: none is left that refines, or all take too long."""
    possible = course.cost_of(2.0)
    if possible is None:
        return "no finer mesh is expected to halve the errors"
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
        _step(course, step.resolution.plain(), clock, progress, step.seconds)
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


def _data(
    courses: Mapping[Backend, Course], modes: list[Mode], request: Request, scene: Scene
) -> dict[str, Any]:
    moving = [mode.member for mode in modes if not mode.member.rigid]
    final = np.array([member.value for member in moving], complex)
    bars = np.array([np.hypot(member.frequency_bar, member.growth_bar) for member in moving])
    levels = []
    for course in courses.values():
        levels += [(level, _errors(level, final, bars)) for level in course.levels]
    for_sweeps = _cheapest(levels, half_unit(request.sweep_digits))
    scenes = {f"finest_{b}": c.sequence.last for b, c in courses.items() if c.sequence.levels}
    if for_sweeps is not None:
        scenes["for_sweeps"] = for_sweeps
    return {
        "modes": [mode.plain() for mode in modes],
        "levels": [level.plain() | errors for level, errors in levels],
        "backends": {backend: _told(course) for backend, course in courses.items()},
        "lost": [
            {"backend": course.backend, "frequency": value.imag / tau, "growth": value.real}
            for course in courses.values()
            for value in lost(course.sequence, _highest(scene) * tau)
        ],
        "mortar": moved_to_mortar(scene),
        "scenes": {name: scene_text(level.scene) for name, level in scenes.items()},
        "max_frequency": _highest(scene),
    }


def _highest(scene: Scene) -> float:
    assert scene.analysis.kind == "cea"
    return scene.analysis.max_frequency


def _errors(level: Level, final: np.ndarray, bars: np.ndarray) -> dict[str, Any]:
    """Distance of a mesh's eigenvalues from the final ones but zeros, relative to abs(lambda).

    ``bound`` is the worst of them with the bars of the final ones; None where one has no bar.
    """
    values = level.eigenvalues
    if not len(final) or not len(values):
        return {"worst": None, "bound": None, "median": None, "missing": len(final)}
    distance = np.abs(values[None, :] - final[:, None]) / np.abs(final)[:, None]
    rows, columns = assign(distance, _REACH)
    errors = distance[rows, columns]
    missing = len(final) - len(rows)
    worst, bound = float(errors.max(initial=0.0)), np.inf
    if not missing:
        bound = float((errors + bars[rows] / np.abs(final[rows])).max(initial=0.0))
    return {
        "worst": worst if not missing else None,
        "bound": bound if isfinite(bound) else None,
        "median": float(np.median(errors)) if len(errors) else None,
        "missing": missing,
    }


def _cheapest(levels: list[tuple[Level, dict[str, Any]]], tolerance: float) -> Level | None:
    """The mesh tried that takes least time of those that are within a tolerance, bars included."""
    enough = [
        level
        for level, e in levels
        if e["bound"] is not None and e["bound"] <= tolerance and not level.corrected
    ]
    return min(enough, key=lambda level: level.seconds, default=None)


def _told(course: Course) -> dict[str, Any]:
    """Why a backend ended, what its bars need, what a digit more would cost."""
    if not course.sequence.levels:
        return {"ended": course.ended, "held": False, "need": None, "more": None, "rate": None}
    need = course.need
    more = course.cost_of(max(need, 1.0) * _MORE) if isfinite(need) else None
    return {
        "ended": course.ended,
        "held": course.holds,
        "need": need if isfinite(need) else None,
        "rate": course.judged.window.rate,
        "more": None if more is None else {"seconds": more.seconds, **more.resolution.plain()},
    }


def _warnings(
    courses: Mapping[Backend, Course], modes: list[Mode], scene: Scene
) -> list[dict[str, Any]]:
    """What the result must be read with."""
    found = []
    apart = [mode for mode in modes if mode.agree is False]
    if apart:
        found.append(
            {
                "kind": "backends-disagree",
                "message": f"the backends differ by more than their bars in {len(apart)} modes",
                "data": {"frequencies": [m.member.value.imag / tau for m in apart]},
            }
        )
    both = sum(1 for course in courses.values() if course.sequence.levels) > 1
    alone = [mode for mode in modes if both and len(mode.members) == 1]
    if alone:
        found.append(
            {
                "kind": "modes-alone",
                "message": f"{len(alone)} modes were found by one backend only",
                "data": {"frequencies": [m.member.value.imag / tau for m in alone]},
            }
        )
    for course in courses.values():
        if not course.holds:
            found.append(
                {
                    "kind": "digits-not-held",
                    "message": f"{course.backend}: {course.ended}",
                    "data": {"backend": course.backend},
                }
            )
        if course.sequence.levels and not course.sequence.last.complete:
            found.append(
                {
                    "kind": "window-not-complete",
                    "message": f"{course.backend}: modes that grow fast are not excluded",
                    "data": {"backend": course.backend},
                }
            )
    if missing := lost_of(courses, scene):
        found.append(
            {
                "kind": "modes-lost",
                "message": f"{missing} modes of a mesh are not among those of the next",
                "data": {"count": missing},
            }
        )
    return found


def lost_of(courses: Mapping[Backend, Course], scene: Scene) -> int:
    """Number of modes that the newest meshes do not have and those before had."""
    return sum(len(lost(course.sequence, _highest(scene) * tau)) for course in courses.values())
