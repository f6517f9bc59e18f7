"""Which mesh comes next: the one expected to buy most accuracy per second.

What theory says a refinement takes off (:mod:`comparisons.converge.theory`) is multiplied, as a
logarithm, by the observed order over that of theory; the time that is estimated, by the time that
the last mesh took over its estimate.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import exp, inf, log

from comparisons.converge.following import Sequence
from comparisons.converge.histories import Window
from comparisons.converge.theory import Fallen, fallen, reduction
from scenes.refinement import MAX_DEGREE, Resolution
from scenes.spec.body import Backend

_DENSITIES = (1.0, 1.25, 1.5, 2.0, 2.8)
_DEGREES = (0, 1)
_LAYERS = (0, 1, 2)
_ALL_ROUND = 1.25
"""Factor on the elements from which on a step refines everything, as a degree more does."""
LEAST_GAIN = log(2.0)
"""A step takes off half of the error at least: what it changes then is seen."""
RESERVE = log(1.5)
"""What a step must take off beyond the need."""


@dataclass(frozen=True)
class Step:
    """A mesh that may come next.

    Parameters
    ----------
    resolution
        The mesh.
    gain
        Logarithm of what it is expected to take off from the error.
    seconds
        Expected time.
    enough
        Whether that is all that is wanted of it.
    """

    resolution: Resolution
    gain: float
    seconds: float
    enough: bool = False


def steps(
    backend: Backend,
    resolution: Resolution,
    so_far: Fallen,
    error: float,
    rate: float,
    seconds: Callable[[Resolution], float],
    *,
    singular: bool,
) -> Iterator[Step]:
    """Meshes that may follow one.

    Parameters
    ----------
    backend
        The backend.
    resolution
        The mesh before.
    so_far
        What was taken off from the error of the first mesh.
    error
        Its relative error.
    rate
        Observed order over that of theory.
    seconds
        Time that a mesh is expected to take (s).
    singular
        Whether edges of the scene are singular.
    """
    layers = _LAYERS if singular else (0,)
    for degree in _DEGREES:
        for density in _DENSITIES:
            for more in layers:
                if degree == 0 and density < _ALL_ROUND:
                    continue
                if resolution.degree + degree > MAX_DEGREE[backend]:
                    continue
                new = Resolution(
                    resolution.degree + degree,
                    resolution.density * density,
                    resolution.layers + more,
                )
                after = so_far + fallen(resolution, new, error)
                gain = after.whole(singular=singular) - so_far.whole(singular=singular)
                gain *= rate
                if gain >= LEAST_GAIN:
                    yield Step(new, gain, seconds(new))


def chosen(candidates: list[Step], need: float, most_seconds: float) -> Step | None:
    """The step that buys most accuracy per second.

    Parameters
    ----------
    candidates
        Steps that may be made.
    need
        Factor by which errors are to fall; what a step takes off beyond it counts for nothing.
    most_seconds
        Time that it may take.

    Returns
    -------
    Step or None
        None where none is possible in that time.
    """
    wanted = max(log(max(need, 1.0)) + RESERVE, LEAST_GAIN)
    possible = [step for step in candidates if step.seconds <= most_seconds]
    return max(
        possible, key=lambda step: min(step.gain, wanted) / max(step.seconds, 1e-3), default=None
    )


def cheapest(candidates: list[Step], need: float) -> Step | None:
    """The cheapest step that is expected to make errors fall by a factor; None where none does."""
    enough = [step for step in candidates if step.gain >= log(need)]
    return min(enough, key=lambda step: step.seconds, default=None)


def error_now(sequence: Sequence, window: Window, rate: float) -> float:
    """Relative error of the newest mesh, from the last change of the window.

    Parameters
    ----------
    sequence
        The meshes.
    window
        What their modes show together.
    rate
        Observed order over that of theory.
    """
    levels = sequence.levels
    if len(levels) < 2:
        return inf
    old, new = levels[-2].resolution, levels[-1].resolution
    taken = reduction(old, new, window.change, singular=sequence.singular)
    return window.change * exp(-rate * taken)
