"""The meshes of one backend, one after the other until digits are held or the budget ends."""

from time import perf_counter

from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from comparisons.converge.bars import Estimated
from comparisons.converge.combine import Mode, word_of
from comparisons.converge.follow import Followed, estimated
from comparisons.converge.ladder import MESHES, Ladder, window_of
from comparisons.converge.request import Request
from comparisons.kit.progress import Progress
from scenes.spec.body import Backend
from scenes.spec.reading import Scene


class _OutOfTimeError(Exception):
    """A mesh that took longer than the budget was given up."""


class Clock:
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
        """Progress that gives a mesh up as a stage of it begins after the budget; collective."""

        def stage(name: str) -> None:
            if self.left < 0:
                raise _OutOfTimeError
            progress.stage(name)

        return Progress(progress.step, stage)


class Course:
    """The meshes of one backend so far, and what they hold.

    Parameters
    ----------
    scene, backend
        The scene as the user gives it, and the backend.
    request
        The digits.

    Attributes
    ----------
    followed
        Meshes so far.
    ended
        Why no more follow; empty while they do, and where the digits are held.
    done
        Whether no more follow.
    """

    def __init__(self, scene: Scene, backend: Backend, request: Request) -> None:
        self.scene, self.backend, self.request = scene, backend, request
        self.ladder, self.followed = Ladder(scene, backend), Followed()
        self.ended, self.done = "", False

    @property
    def spent(self) -> float:
        """Seconds of all meshes."""
        return sum(mesh.seconds for mesh in self.followed.meshes)

    @property
    def bars(self) -> list[Estimated]:
        """Modes of the finest mesh with their error bars."""
        damped = self.scene.damped or self.scene.rotates
        has_friction = any(contact.mu for contact in self.scene.contacts.values())
        ladder = self.ladder
        return estimated(
            self.followed,
            ladder.degree,
            damped=damped,
            grows=damped or has_friction,
            by_degree=ladder.by_degree,
        )

    @property
    def holds(self) -> bool:
        """Whether every mode of the window holds its digits."""
        window = window_of(self.scene)
        threshold, top = window.growth_threshold, window.max_frequency
        last = self.followed.meshes[-1]
        for own, rigid in zip(self.bars, last.rigid.tolist(), strict=True):
            word = word_of(own, threshold, rigid=rigid)
            mode = Mode(self.backend, own, None, rigid, word)
            if mode.frequency <= top and max(mode.shortfalls(self.request, threshold)) > 1:
                return False
        return True

    def advance(self, clock: Clock, progress: Progress) -> None:
        """One more mesh, the correction of the last one, or the end."""
        meshes = self.followed.meshes
        needed = 1 if self.ladder.by_degree else MESHES
        try:
            if len(meshes) >= needed and meshes[-1].corrected is None:
                if not self.holds and not self.ladder.by_degree and self._next_fits(clock):
                    self._run(clock, progress)
                else:
                    self._correct(clock, progress)
            elif len(meshes) >= needed and self.holds:
                self.done = True
            elif self._next_fits(clock):
                self._run(clock, progress)
            else:
                self._end(clock, progress)
        except (InputError, ConvergenceError) as error:
            self.ended = f"the next mesh failed: {error}"
        except _OutOfTimeError:
            self.ended = "the budget: a mesh that took longer than expected was given up"
        self.done = self.done or bool(self.ended)

    def _next_fits(self, clock: Clock) -> bool:
        seconds = self.ladder.seconds(len(self.followed.meshes))
        return seconds is not None and seconds <= clock.left

    def _run(self, clock: Clock, progress: Progress) -> None:
        number = len(self.followed.meshes)
        progress.step(f"{self.backend}, mesh {number + 1}, {max(clock.left, 0):.0f} s left")
        mesh = self.ladder.run(number, clock.guarded(progress))
        progress.stage("matching")
        self.followed.add(mesh)

    def _correct(self, clock: Clock, progress: Progress) -> None:
        mesh = self.followed.meshes[-1]
        progress.step(
            f"{self.backend}, correction in a richer space, {max(clock.left, 0):.0f} s left"
        )
        self.followed.meshes[-1] = self.ladder.correct(mesh, clock.guarded(progress))

    def _end(self, clock: Clock, progress: Progress) -> None:
        """The last mesh is corrected where there is the time."""
        meshes, more = self.followed.meshes, self.ladder.seconds(len(self.followed.meshes))
        left = meshes and meshes[-1].corrected is None
        if left and self.ladder.seconds_to_correct(meshes[-1].scene) <= clock.left:
            self._correct(clock, progress)
        self.ended = (
            "cells of mesh files have no elements of a higher degree"
            if more is None
            else f"one more mesh would take about {more:.2g} s"
        )
