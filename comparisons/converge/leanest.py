"""The cheapest mesh that is expected to hold all modes, each body and direction at its own density.

From a mesh whose errors are known in their parts (:mod:`comparisons.converge.parts`) the move is
made, again and again, that brings the modes nearest to what is wanted of them for the time that it
adds: more elements along a direction of a body, a degree of a body, a layer towards its edges.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from cea.arrays import Floats
from comparisons.converge.parts import Parts
from comparisons.converge.steps import Step
from scenes.refinement import MAX_DEGREE, BodyResolution, Resolution, mixed
from scenes.spec.body import Backend

_MOVES = 80
"""Moves at most."""
_MORE = 1.15
"""Factor on the elements along a direction, in a move."""
_WORTH = np.log(1.5)
"""What a mesh that does not reach all must take off at least from the largest shortage."""


@dataclass(frozen=True)
class Wanted:
    """What the next mesh is to reach.

    Parameters
    ----------
    errors
        Relative errors of the modes asked for in their parts, where parts were measured, shape
        (modes, parts).
    gains
        Logarithm of what is to be taken off from the error of each, shape (modes,).
    reached
        The mesh whose errors those are, corrected where it was.
    rate
        Observed order over that of theory.
    """

    errors: Floats
    gains: Floats
    reached: Resolution
    rate: float


def leanest(
    parts: Parts,
    backend: Backend,
    newest: Resolution,
    given: Mapping[str, tuple[int, ...] | None],
    wanted: Wanted,
    seconds: Callable[[Resolution], float],
    most_seconds: float,
) -> Step | None:
    """The cheapest mesh that is expected to take off what is wanted.

    Parameters
    ----------
    parts
        What errors are made of.
    backend
        The backend.
    newest
        The mesh that is refined, densities of all bodies given.
    given
        Elements of the scene's meshes along each direction; None of unstructured ones.
    wanted
        What is to be reached.
    seconds
        Time that a mesh is expected to take (s).
    most_seconds
        Time that it may take.

    Returns
    -------
    Step or None
        A mesh that comes as near as the time allows, ``enough`` where it takes off all that is
        wanted; None where none is worth its time.
    """
    before = _logarithms(parts, wanted.reached, wanted)

    def shortages(resolution: Resolution) -> Floats:
        gained = wanted.rate * (before - _logarithms(parts, resolution, wanted))
        return np.maximum(wanted.gains - gained, 0.0)

    now, cost = newest, seconds(newest)
    short = first = shortages(now)
    for _ in range(_MOVES):
        if not short.any():
            break
        best, most = None, 0.0
        for move in _moves(parts, backend, now, given):
            after = shortages(move)
            gained = float((short - after).sum())
            if gained <= 0:
                continue
            taken = seconds(move)
            worth = gained / max(taken - cost, 1e-3 * cost)
            if taken <= most_seconds and worth > most:
                best, most = (move, taken, after), worth
        if best is None:
            break
        now, cost, short = best
    gain = float((wanted.gains - short).min())
    if now is newest or (short.any() and first.max() - short.max() < _WORTH):
        return None
    return Step(now, gain, cost, enough=not short.any())


def _logarithms(parts: Parts, resolution: Resolution, wanted: Wanted) -> Floats:
    """Logarithms of the errors of the modes on a mesh."""
    sums = parts.at(resolution, wanted.errors).sum(axis=1)
    return np.asarray(np.log(np.maximum(sums, np.finfo(float).tiny)))


def _moves(
    parts: Parts,
    backend: Backend,
    now: Resolution,
    given: Mapping[str, tuple[int, ...] | None],
) -> Iterator[Resolution]:
    """Meshes a little finer than one."""
    bodies = dict(now.bodies)
    for part in parts.parts:
        own = bodies[part.body]
        if part.edges:
            finer = replace(own, layers=own.layers + 1)
        else:
            finer = _denser(own, part.directions, given[part.body])
        yield mixed({**bodies, part.body: finer})
    for name, own in bodies.items():
        if own.degree < MAX_DEGREE[backend]:
            yield mixed({**bodies, name: replace(own, degree=own.degree + 1)})


def _denser(
    own: BodyResolution, directions: tuple[int, ...], given: tuple[int, ...] | None
) -> BodyResolution:
    """More elements along some directions, one more at least."""
    densities = list(own.densities)
    for d in directions:
        if given is None:
            densities[d] *= _MORE
        else:
            densities[d] = ceil(_MORE * densities[d] * given[d] - 1e-9) / given[d]
    return replace(own, densities=tuple(densities))
