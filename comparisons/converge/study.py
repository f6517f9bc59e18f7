"""Refinement of a scene on each backend until error bars have the requested digits."""

from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from comparisons.converge.combine import combine
from comparisons.converge.follow import Followed, estimated
from comparisons.converge.ladder import Ladder
from comparisons.converge.record import data_of
from comparisons.converge.request import Request
from comparisons.study.session import Progress
from scenes.results.record import record
from scenes.spec.body import Backend
from scenes.spec.reading import Scene, load_scene
from scenes.spec.refinement import from_file

COMMAND = "converge"
"""Name of the command in the record."""


class _OutOfTimeError(Exception):
    """Raised when a mesh takes longer than the budget."""


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
        """Seconds of the budget that are left."""
        return self._budget - self.gone

    def guarded(self, progress: Progress) -> Progress:
        """Return progress that raises if a stage begins after the budget is spent; collective."""

        def stage(name: str) -> None:
            if self.left < 0:
                raise _OutOfTimeError
            progress.stage(name)

        return Progress(progress.step, stage)


class Course:
    """The refinement sequence of one backend, and the reason why it ended."""

    def __init__(self, scene: Scene, backend: Backend, request: Request) -> None:
        self.scene, self.backend, self.request = scene, backend, request
        self.ladder, self.followed = Ladder(scene, backend), Followed()
        self.ended, self.done = "", False

    @property
    def spent(self) -> float:
        """Time of all meshes (s)."""
        return sum(mesh.seconds for mesh in self.followed.meshes)

    @property
    def holds(self) -> bool:
        """Whether every mode of the window has the requested digits."""
        window = self.scene.window
        threshold, top = window.growth_threshold, window.max_frequency
        bars = {self.backend: estimated(self.followed, self.ladder)}
        modes = combine({self.backend: self.followed}, bars, threshold)
        asked = [
            mode.shortfalls(self.request, threshold) for mode in modes if mode.frequency <= top
        ]
        return all(max(both) <= 1 for both in asked)

    def advance(self, clock: _Clock, progress: Progress) -> None:
        """Solve one more mesh, or end the sequence."""
        number = len(self.followed.meshes)
        try:
            if number >= self.ladder.least and self.holds:
                self.done = True
                return
            seconds = self.ladder.seconds(number)
            if seconds is None:
                self.ended = "elements on the cells of mesh files have degree 4 at most"
            elif seconds > clock.left:
                self.ended = f"one more mesh would take about {seconds:.2g} s"
            else:
                left = f"{max(clock.left, 0):.0f} s left"
                progress.step(f"{self.backend}, mesh {number + 1}, {left}")
                guarded = clock.guarded(progress)
                mesh = self.ladder.run(number, guarded)
                if number + 1 >= self.ladder.least:
                    mesh = self.ladder.correct(mesh, guarded)
                progress.stage("matching")
                self.followed.add(mesh)
        except (InputError, ConvergenceError) as error:
            self.ended = f"no further mesh: {error}"
        except _OutOfTimeError:
            self.ended = "budget spent: a mesh took longer than expected and was stopped"
        self.done = bool(self.ended)

    def finish(self, progress: Progress) -> None:
        """Correct the last mesh if that is still to be done; if this fails, drop all meshes."""
        meshes = self.followed.meshes
        if meshes and meshes[-1].corrected is None:
            try:
                meshes[-1] = self.ladder.correct(meshes[-1], progress)
            except (InputError, ConvergenceError) as error:
                meshes.clear()
                self.ended = f"no correction of the only meshes: {error}"


def backends_of(scene: Scene, request: Request) -> tuple[Backend, ...]:
    """Return the requested backends, or those for which every shape has a mesh."""
    if request.backends is not None:
        return request.backends
    shapes = [body for body in scene.bodies.values() if not from_file(body)]
    every: tuple[Backend, ...] = ("iga", "fe") if shapes else ("fe",)
    meshes = {b: [getattr(body.mesh, b) for body in shapes] for b in every}
    return tuple(b for b in every if None not in meshes[b]) or every


def run_converge(
    request: Request, progress: Progress, begun: float | None = None
) -> dict[str, Any]:
    """Refine a scene on each backend until bars have the requested digits; collective.

    The budget counts from ``begun``, a value of :func:`time.perf_counter`, by default from now. The
    record has ``first``: the digits reached and the cost of more; ``held``: whether all were
    reached; ``words``: how many modes are unstable, stable and so on; ``modes``, each with value,
    bars and verdict; ``levels``: every mesh; ``ended``: why each backend stopped; ``scenes``: text
    of scene files with these meshes. A scene that cannot be refined is refused.
    """
    clock = _Clock(request.budget, begun)
    scene = load_scene(Path(request.scene), list(request.overrides))
    courses = {b: Course(scene, b, request) for b in backends_of(scene, request)}
    while active := [course for course in courses.values() if not course.done]:
        min(active, key=lambda course: course.spent).advance(clock, progress)
    for course in courses.values():
        course.finish(progress)
    progress.stage("report")
    followed = {b: course.followed for b, course in courses.items() if course.followed.meshes}
    bars = {b: estimated(each, courses[b].ladder) for b, each in followed.items()}
    modes = combine(followed, bars, scene.window.growth_threshold)
    ended = {backend: course.ended for backend, course in courses.items()}
    data = data_of(followed, ended, modes, request, scene)
    return record(
        COMMAND,
        data,
        inputs=asdict(request),
        seconds=clock.gone,
        warnings=data.pop("warnings"),
    )
