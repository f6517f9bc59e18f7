"""Which mesh comes next: the one expected to buy most accuracy per second.

Theory tells what a refinement takes off from errors, apart for the smooth part of the solution and
for its singular one:

- elements f times as many along every direction: f^(-2 p), and f^(-2 s) with the exponent s of the
  stresses at a clamped edge, about 0.7;
- the degree raised from p to p + 1: an error e becomes e^((p + 1) / p), since dispersion goes as
  (phase / 2 pi)^(2 p); of the singular part (p / (p + 1))^(4 s);
- a layer more towards singular edges: of the singular part the ratio of the layers to 2 s.

The order that is observed over that of theory multiplies the logarithm of what is expected, and the
time that the last mesh took over its estimate multiplies the time.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import exp, log

from scenes.refinement import MAX_DEGREE, RATIO, Resolution
from scenes.spec.body import Backend

_EXPONENT = 0.7
"""Of displacements at a clamped edge (Williams 1952), between 0.6 and 0.75 for usual nu."""
_DENSITIES = (1.0, 1.25, 1.5, 2.0, 2.8)
_DEGREES = (0, 1, 2)
_LAYERS = (0, 1, 2)
_ALL_ROUND = 1.25
"""Factor on the elements from which on a step refines everything, as a degree more does."""
_LEAST_GAIN = log(2.0)
"""A step takes off half of the error at least: what it changes then is seen."""
_RESERVE = log(1.5)
"""What a step must take off beyond the need."""
_LARGEST_ERROR = 0.3
"""Relative error that expectations start from at most."""


@dataclass(frozen=True)
class Position:
    """Logarithms of what theory took off from the error of the first mesh.

    Parameters
    ----------
    smooth, singular
        Of either part.
    mixed
        Whether there is a singular part: edges of the scene are singular.
    """

    smooth: float = 0.0
    singular: float = 0.0
    mixed: bool = False

    @property
    def total(self) -> float:
        """Of the whole error, of which both parts are half on the first mesh."""
        if not self.mixed:
            return self.smooth
        return -log(0.5 * exp(-self.smooth) + 0.5 * exp(-self.singular))

    def after(self, old: Resolution, new: Resolution, error: float) -> "Position":
        """Position after a step.

        Parameters
        ----------
        old, new
            The step.
        error
            Relative error of eigenvalues before it.
        """
        more = log(new.density / old.density)
        smooth, left = 0.0, -log(min(max(error, 1e-15), _LARGEST_ERROR))
        smooth += 2 * old.degree * more
        for degree in range(old.degree, new.degree):
            smooth += (left + smooth) / degree
        singular = 2 * _EXPONENT * (more - (new.layers - old.layers) * log(RATIO))
        singular += 4 * _EXPONENT * log(new.degree / old.degree)
        return Position(self.smooth + smooth, self.singular + singular, self.mixed)


@dataclass(frozen=True)
class Step:
    """A mesh that may come next.

    Parameters
    ----------
    resolution, position
        The mesh and its place in the sequence.
    gain
        Logarithm of what it is expected to take off from the error.
    seconds
        Expected time.
    """

    resolution: Resolution
    position: Position
    gain: float
    seconds: float


def steps(
    backend: Backend,
    resolution: Resolution,
    position: Position,
    error: float,
    rate: float,
    seconds: Callable[[Resolution], float],
) -> Iterator[Step]:
    """Meshes that may follow one.

    Parameters
    ----------
    backend
        The backend.
    resolution, position
        The mesh before.
    error
        Its relative error.
    rate
        Observed order over that of theory.
    seconds
        Time that a mesh is expected to take (s).
    """
    layers = _LAYERS if position.mixed else (0,)
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
                place = position.after(resolution, new, error)
                gain = rate * (place.total - position.total)
                if gain >= _LEAST_GAIN:
                    yield Step(new, place, gain, seconds(new))


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
    wanted = max(log(max(need, 1.0)) + _RESERVE, _LEAST_GAIN)
    possible = [step for step in candidates if step.seconds <= most_seconds]
    return max(
        possible, key=lambda step: min(step.gain, wanted) / max(step.seconds, 1e-3), default=None
    )


def cheapest(candidates: list[Step], need: float) -> Step | None:
    """The cheapest step that is expected to make errors fall by a factor; None where none does."""
    enough = [step for step in candidates if step.gain >= log(need)]
    return min(enough, key=lambda step: step.seconds, default=None)
