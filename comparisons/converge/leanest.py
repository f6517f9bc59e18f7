"""The cheapest mesh that is expected to hold all modes, each body and direction at its own density.

The errors of a mesh are known in their parts (:mod:`comparisons.converge.parts`). For every choice
of degree and layers of a body elements are added, along the direction of a body that brings the
modes nearest to what is wanted of them for the time that it adds, until all are there; the cheapest
of these meshes is taken. Bodies are chosen for one after the other, and once more.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import ceil

import numpy as np

from cea.arrays import Floats
from comparisons.converge.parts import Parts, taken_off
from comparisons.converge.steps import Step
from scenes.refinement import MAX_DEGREE, BodyResolution, Resolution, mixed
from scenes.spec.body import Backend

_MOVES = 60
"""Times that elements are added at most."""
_DEGREES, _LAYERS = 2, 4
"""Degrees, and layers, of a body that are tried: so many from those it has."""
_ROUNDS = 2
"""Times that degrees and layers of all bodies are chosen: edges of one may bar the way at first."""
_MORE = 1.2
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
    local
        The same over what the bodies take part in the modes, shape (modes, parts).
    gains
        Logarithm of what is to be taken off from the error of each, shape (modes,).
    reached
        The mesh whose errors those are, corrected where it was.
    rate
        Observed order over that of theory.
    """

    errors: Floats
    local: Floats
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
    before = parts.at(wanted.reached, wanted.errors, wanted.local)

    def shortages(resolution: Resolution) -> Floats:
        after = parts.at(resolution, wanted.errors, wanted.local)
        taken = taken_off(before, after, wanted.errors)
        return np.maximum(wanted.gains - wanted.rate * taken, 0.0)

    best = _Mesh(newest, seconds(newest), shortages(newest))
    first, base = float(best.short.max()), newest
    for name in _ROUNDS * _by_need(parts, wanted):
        for start in _starts(parts, backend, base, name, dict(newest.bodies)[name]):
            most = best.seconds if best.enough else most_seconds
            found = _refined(start, parts, given, shortages, seconds, most)
            if found is not None and found.better(best):
                best = found
        chosen = dict(best.resolution.bodies)[name]  # its degree and layers stay
        old = dict(base.bodies)
        kept = replace(old[name], degree=chosen.degree, layers=chosen.layers)
        base = mixed({**old, name: kept})
    if best.resolution is newest or (not best.enough and first - best.short.max() < _WORTH):
        return None
    gain = float((wanted.gains - best.short).min())
    return Step(best.resolution, gain, best.seconds, enough=best.enough)


@dataclass(frozen=True)
class _Mesh:
    """A mesh, its time (s), what modes are short of, shape (modes,)."""

    resolution: Resolution
    seconds: float
    short: Floats

    @property
    def enough(self) -> bool:
        return not self.short.any()

    def better(self, other: "_Mesh") -> bool:
        """Whether it is nearer to what is wanted, or cheaper where both are there."""
        if self.enough and other.enough:
            return self.seconds < other.seconds
        return self.enough or bool(not other.enough and self.short.sum() < other.short.sum())


def _by_need(parts: Parts, wanted: Wanted) -> list[str]:
    """Bodies by what the modes owe to them, most first."""
    names = dict.fromkeys(part.body for part in parts.parts)
    usual = np.median(wanted.errors, axis=0)
    owed = {
        name: sum(e for part, e in zip(parts.parts, usual, strict=True) if part.body == name)
        for name in names
    }
    return sorted(names, key=lambda name: -owed[name])


def _starts(
    parts: Parts, backend: Backend, base: Resolution, name: str, own: BodyResolution
) -> Iterator[Resolution]:
    """A mesh with degrees and layers added to those of a body, whose elements are then refined."""
    bodies = dict(base.bodies)
    edges = any(part.edges for part in parts.parts if part.body == name)
    for more, crowded in product(range(_DEGREES), range(_LAYERS if edges else 1)):
        if own.degree + more <= MAX_DEGREE[backend]:
            new = replace(own, degree=own.degree + more, layers=own.layers + crowded)
            yield mixed({**bodies, name: new})


def _refined(
    start: Resolution,
    parts: Parts,
    given: Mapping[str, tuple[int, ...] | None],
    shortages: Callable[[Resolution], Floats],
    seconds: Callable[[Resolution], float],
    most_seconds: float,
) -> _Mesh | None:
    """Elements added to a mesh where they bring most for their time; None where it takes more."""
    now = _Mesh(start, seconds(start), shortages(start))
    if now.seconds > most_seconds:
        return None
    for _ in range(_MOVES):
        if now.enough:
            break
        best, most = None, 0.0
        for move in _moves(parts, now.resolution, given):
            after = shortages(move)
            gained = float((now.short - after).sum())
            if gained <= 0:
                continue
            taken = seconds(move)
            worth = gained / max(taken - now.seconds, 1e-3 * now.seconds)
            if taken <= most_seconds and worth > most:
                best, most = _Mesh(move, taken, after), worth
        if best is None:
            break
        now = best
    return now


def _moves(
    parts: Parts, now: Resolution, given: Mapping[str, tuple[int, ...] | None]
) -> Iterator[Resolution]:
    """Meshes with some more elements along a direction of a body."""
    bodies = dict(now.bodies)
    for part in parts.parts:
        if not part.edges:
            finer = _denser(bodies[part.body], part.directions, given[part.body])
            yield mixed({**bodies, part.body: finer})


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
