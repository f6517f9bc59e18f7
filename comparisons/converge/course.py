"""The course of one backend: its sequence of meshes, what it holds, what comes next."""

from dataclasses import dataclass, field
from math import inf, isfinite, log
from time import perf_counter

from cea.errors import ConvergenceError, InputError
from cea.petsc import MPI
from comparisons.converge.aims import ENOUGH, is_asked, may_remain, need_of
from comparisons.converge.bars import SAFETY
from comparisons.converge.estimated import (
    SHARE,
    Richer,
    estimated_level,
    finer_of,
    richer_of,
    seconds_of,
)
from comparisons.converge.following import Sequence
from comparisons.converge.histories import Window
from comparisons.converge.judged import Judged, judge
from comparisons.converge.levels import Level, run_level
from comparisons.converge.plans import Plans, rate_of, slower_than_estimated
from comparisons.converge.probes import measured, seconds_of_probes
from comparisons.converge.request import Request
from comparisons.converge.steps import Step, cheapest, chosen, error_now
from comparisons.converge.theory import Fallen, fallen, reduction
from comparisons.kit.progress import Progress
from scenes.read import Scene
from scenes.refinement import counted, has_singular_edges
from scenes.spec.body import Backend
from scenes.variants import on_backend

_PROBES_PART = 0.3
"""Part of the time left that measuring what bodies and directions owe may take."""
_FAILED = 0.5
"""Observed order over that expected below which what bodies and directions owe is measured anew."""
_UNKNOWN_NEED = 10.0
"""Factor by which errors are supposed too large while no bar is known."""
_SURE = 1.6
"""Factor on expected times where they must not be exceeded."""
_AWAY = 5.0
"""Time of a step relative to that of the last mesh while no order is known."""
_SHORT = 2.0
"""Seconds up to which steps are short whatever the last mesh took."""
_AT_ONCE = log(300.0)
"""What one mesh is to take off at most, as a logarithm: what is expected far ahead may fail."""
_LEFT: dict[Backend, float] = {"iga": log(15.0), "fe": log(6.0)}
"""What the mesh before a correction leaves to it, as a logarithm: less where that raises the degree
of Lagrange elements, which is trusted with less."""
_ORDERLY = 2e-3
"""Largest relative error up to which orders are trusted: the mesh before a correction leaves no
more than that to it, however few digits are asked for."""


@dataclass
class Course:
    """Meshes of one backend.

    Parameters
    ----------
    backend
        The backend.
    scene
        The scene as the user gives it.
    request
        The digits.
    plans
        Meshes that may follow.
    sequence
        Meshes so far.
    so_far
        What theory took off from the error of the first mesh.
    probing
        Seconds that measuring took what bodies and directions owe.
    tried
        Number of meshes when that was last begun.
    ended
        Why no more follow: the digits are held, or what stands against it; empty while they do.
    """

    backend: Backend
    scene: Scene
    request: Request
    plans: Plans = field(init=False)
    sequence: Sequence = field(init=False)
    so_far: Fallen = field(default_factory=Fallen)
    probing: float = 0.0
    tried: int = 0
    ended: str = ""

    def __post_init__(self) -> None:
        self.plans = Plans(self.backend, self.scene, self.request)
        singular = has_singular_edges(on_backend(self.scene, self.backend))
        self.sequence = Sequence(self.backend, singular)

    @property
    def spent(self) -> float:
        """Seconds of all meshes and of what was measured on them."""
        return self.probing + sum(level.seconds for level in self.levels)

    @property
    def levels(self) -> list[Level]:
        """Meshes, and the newest corrected in a richer space where it was."""
        return self.sequence.with_correction.levels

    @property
    def judged(self) -> Judged:
        """Bars and verdicts on the newest mesh."""
        return judge(self.sequence.with_correction, self.scene)

    @property
    def need(self) -> float:
        """Factor by which the largest bar is too large; 1 or less where the digits are held."""
        if len(self.levels) < 2:
            return _UNKNOWN_NEED
        members = self.judged.members
        asked = [m for m in members if is_asked(m, self.request, self.scene)]
        return max((need_of(m, self.request, self.scene) for m in asked), default=0.0)

    @property
    def holds(self) -> bool:
        """Whether the digits are held, by bars that rest on an observed order."""
        return bool(len(self.levels) >= ENOUGH and self.need <= 1)

    def next(self, most_seconds: float, need: float | None = None) -> Step | None:
        """The mesh that is expected to buy most; None where none can be made in the time left.

        Parameters
        ----------
        most_seconds
            Time left.
        need
            Factor by which errors are to fall; None takes what the digits need.
        """
        if not self.sequence.levels:
            return self.plans.first(most_seconds)
        most = most_seconds / _SURE
        if self.sequence.parts is not None:
            few = len(self.sequence.levels) < ENOUGH - 1
            spare = left_to_correction(self.backend, self.request.tolerance)
            spare = spare if few and need is None else -log(need or 1.0)
            return self._leanest(most, spare=spare, at_once=_AT_ONCE)
        if len(self.sequence.levels) < ENOUGH:
            short = min(most, max(_AWAY * self.sequence.last.seconds, _SHORT))
            found = chosen(self._alike(), need or self.need, short)
            if found is not None:
                return found
        return chosen(self._alike(), need or self.need, most)

    def cost_of(self, factor: float) -> Step | None:
        """The cheapest mesh expected to make the newest's errors fall by a factor.

        Whether the machine has the memory for it is not asked.
        """
        if self.sequence.parts is None:
            return cheapest(self._alike(fitting=False), factor)
        need = max(self.need, 1.0)
        need = need if isfinite(need) else _UNKNOWN_NEED
        step = self._leanest(inf, spare=-log(factor / need))
        return step if step is not None and step.enough else None

    def run(self, step: Step, progress: Progress) -> Level:
        """Run a mesh; collective."""
        resolution = counted(self.scene, self.backend, step.resolution)
        return run_level(self.scene, self.backend, resolution, progress)

    def follow(self, level: Level) -> None:
        """Follow the modes to a mesh that was run; collective."""
        if self.sequence.levels and self.sequence.parts is None:
            old, window = self.sequence.last.resolution, self.judged.window
            error = error_now(self.sequence, window, self._rate(window))
            self.so_far += fallen(old, level.resolution, error)
        self.sequence.add(level)

    def can_measure(self, most_seconds: float) -> bool:
        """Whether there is the time to measure what bodies and directions owe, and cause to.

        It is unknown on the first mesh, and what was expected of it may fail on later ones.

        Parameters
        ----------
        most_seconds
            Time left.
        """
        parts, levels = self.sequence.parts, self.sequence.levels
        rate = None if parts is None else self.judged.window.rate
        cause = len(levels) == 1 if parts is None else rate is not None and rate < _FAILED
        if self.tried == len(levels) or not cause:
            return False
        seconds = seconds_of_probes(self.scene, self.backend, self.sequence.last.resolution)
        return slower_than_estimated(self.sequence) * seconds <= _PROBES_PART * most_seconds

    def measure(self, progress: Progress) -> None:
        """Measure what bodies and directions owe to the errors of the newest mesh; collective."""
        begun, levels = perf_counter(), self.sequence.levels
        self.tried = len(levels)
        try:
            self.sequence.parts = measured(levels[-1], len(levels) - 1, self.scene, progress)
        except (InputError, ConvergenceError):
            return  # all are refined alike then
        finally:
            # Decisions hang on times, which differ from rank to rank.
            self.probing += MPI.COMM_WORLD.bcast(perf_counter() - begun)

    def correction(self, most_seconds: float, *, last: bool) -> Richer | None:
        """A richer space in which the newest mesh is worth correcting.

        Parameters
        ----------
        most_seconds
            Time left.
        last
            Whether no mesh follows, so that any correction is worth its time.

        Returns
        -------
        Richer or None
            None where it would take too long, or is not expected to make the digits hold.
        """
        sequence = self.sequence
        if sequence.correction is not None or len(sequence.levels) < (1 if last else 2):
            return None
        if sequence.parts is not None:
            most = most_seconds / _SURE
            step = self._leanest(most, spare=0.0, share=SHARE)
            if last and (step is None or not step.enough):
                # What is owed little may wait: what is asked for comes first in the time left.
                step = self._leanest(most, spare=0.0, share=SHARE, everywhere=False)
            if step is None or not (last or step.enough):
                return None
            return finer_of(sequence.last, self.scene, step.resolution)
        newest = sequence.last
        richer = richer_of(newest, self.scene)
        if (
            richer is None
            or _SURE * seconds_of(richer.scene, slower_than_estimated(self.sequence)) > most_seconds
        ):
            return None
        if last:
            return richer
        window = self.judged.window
        gain = self._rate(window) * reduction(
            newest.resolution,
            richer.resolution,
            error_now(self.sequence, window, self._rate(window)),
            singular=sequence.singular,
        )
        return richer if log(max(self.need, 1.0)) <= gain - log(SAFETY) else None

    def correct(self, richer: Richer, progress: Progress) -> None:
        """Correct the newest mesh in a richer space; collective."""
        newest = self.sequence.last
        allowed = may_remain(newest.eigenvalues, self.request, self.scene)
        self.sequence.correction = estimated_level(newest, richer, allowed, progress)

    def _leanest(
        self,
        most_seconds: float,
        *,
        spare: float,
        at_once: float = inf,
        share: float = 1.0,
        everywhere: bool = True,
    ) -> Step | None:
        options = {"spare": spare, "at_once": at_once, "share": share}
        judged = self.judged
        return self.plans.leanest(
            self.sequence, judged, most_seconds, everywhere=everywhere, **options
        )

    def _alike(self, *, fitting: bool = True) -> list[Step]:
        return self.plans.alike(self.sequence, self.judged, self.so_far, fitting=fitting)

    def _rate(self, window: Window) -> float:
        return rate_of(self.sequence, window)


def left_to_correction(backend: Backend, tolerance: float) -> float:
    """What the mesh before a correction leaves to it, as a logarithm.

    Parameters
    ----------
    backend
        The backend.
    tolerance
        Relative error of frequencies that is allowed.
    """
    orderly = log(SAFETY * _ORDERLY / tolerance)
    return min(_LEFT[backend], max(orderly, 0.0))
