"""Meshes of a backend that may be run, with what they take: the first, the leanest, those alike."""

from math import inf

from comparisons.converge.aims import wanted
from comparisons.converge.bars import LEAST, MOST
from comparisons.converge.following import Sequence
from comparisons.converge.histories import Window
from comparisons.converge.judged import Judged
from comparisons.converge.leanest import leanest
from comparisons.converge.levels import Estimates, given_elements
from comparisons.converge.request import Request
from comparisons.converge.steps import Step, error_now, steps
from comparisons.converge.theory import Fallen
from scenes.read import Scene
from scenes.refinement import Resolution
from scenes.spec.body import Backend

FIRST_DEGREE = 3
"""Degree of the first mesh."""
_FIRST_DENSITY = 0.5
_COARSER = 0.7
_COARSEST = 0.1
_FIRST_PART = 0.05
"""Part of the budget that a first mesh may take."""
_EXPECTED_RATE = 0.8
"""Observed order over that of theory before any was observed."""
_MEASURED_RATE = 0.9
"""The same where errors were measured in their parts."""
_FIRST_SLOWER = 4.0
"""Time of a first mesh over its estimate that others are expected to share at most."""


class Plans:
    """Meshes of one backend that may be run.

    Parameters
    ----------
    backend
        The backend.
    scene
        The scene as the user gives it.
    request
        The digits.
    """

    def __init__(self, backend: Backend, scene: Scene, request: Request) -> None:
        self._backend, self._scene, self._request = backend, scene, request
        self._estimates = Estimates(scene, backend)
        self._given = given_elements(scene, backend)

    def first(self, most_seconds: float) -> Step:
        """The first mesh: half as dense as the scene, or coarser where that takes too long."""
        degree, density = FIRST_DEGREE, _FIRST_DENSITY
        resolution, taken = Resolution(degree, density), self._estimates.fitting()
        while taken(resolution) > _FIRST_PART * most_seconds and density > _COARSEST:
            density *= _COARSER
            resolution = Resolution(degree, density)
        return Step(resolution, 0.0, self._estimates.seconds(resolution))

    def fits(self, resolution: Resolution) -> bool:
        """Whether the memory that is free now does for a mesh; collective."""
        return self._estimates.fitting()(resolution) < inf

    def leanest(
        self,
        sequence: Sequence,
        judged: Judged,
        most_seconds: float,
        *,
        spare: float,
        at_once: float = inf,
        share: float = 1.0,
        everywhere: bool = True,
    ) -> Step | None:
        """The cheapest mesh for what is wanted, or richer space that takes a share of a run.

        Parameters
        ----------
        sequence
            The meshes, with the parts of their errors.
        judged
            Bars on the newest.
        most_seconds
            Time that it may take; where it is endless, memory counts no more.
        spare, at_once
            Logarithms of what is left to a correction, and of what one mesh takes off at most.
        share
            Part of the time of a run that it takes.
        everywhere
            Whether every part is to fall by half, from the second mesh on.
        """
        assert sequence.parts is not None
        slower = slower_than_estimated(sequence) * share
        rate = rate_of(sequence, judged.window)
        aim = wanted(
            judged,
            sequence,
            self._request,
            self._scene,
            rate,
            spare=spare,
            most=at_once,
            everywhere=everywhere and len(sequence.levels) > 1,
        )
        if aim is None:
            return None
        taken = self._estimates.seconds if most_seconds == inf else self._estimates.fitting()
        return leanest(
            sequence.parts,
            self._backend,
            sequence.last.resolution,
            self._given,
            aim,
            lambda resolution: slower * taken(resolution),
            most_seconds,
        )

    def alike(
        self, sequence: Sequence, judged: Judged, so_far: Fallen, *, fitting: bool
    ) -> list[Step]:
        """Meshes refined in all bodies alike.

        Parameters
        ----------
        sequence
            The meshes.
        judged
            Bars on the newest.
        so_far
            What theory took off from the error of the first mesh.
        fitting
            Whether those that the memory does not hold are to take for ever.
        """
        taken = self._estimates.fitting() if fitting else self._estimates.seconds
        slower, rate = slower_than_estimated(sequence), rate_of(sequence, judged.window)
        found = steps(
            self._backend,
            sequence.last.resolution,
            so_far,
            error_now(sequence, judged.window, rate),
            rate,
            lambda resolution: slower * taken(resolution),
            singular=sequence.singular,
        )
        return list(found)


def slower_than_estimated(sequence: Sequence) -> float:
    """Time of the newest mesh over its estimate; a first one takes what all runs share."""
    ratio = sequence.last.seconds / sequence.last.estimated
    return ratio if len(sequence.levels) > 1 else min(ratio, _FIRST_SLOWER)


def rate_of(sequence: Sequence, window: Window) -> float:
    """Observed order over that of theory, or what it usually is."""
    if window.rate is not None:
        return min(max(window.rate, LEAST), MOST)
    return _EXPECTED_RATE if sequence.parts is None else _MEASURED_RATE
