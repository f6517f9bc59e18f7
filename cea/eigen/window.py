"""Search of a window: discs about real shifts, and the evidence that no mode is missing.

Without damping the first disc lies about the middle of the window, in kappa = -lambda^2. It covers
the window where friction confines eigenvalues to a cone about the real axis; otherwise further
discs to the left cover all places to which friction may move eigenvalues
(:mod:`cea.eigen.regions`). With damping or rotation the window holds the lambda with
0 <= Im lambda <= omega and Re lambda >= -d, and a disc about a real shift c > 0,

    abs(lambda - c)^2 <= (c + d)^2 + omega^2,

contains the part of it with growth rates up to 2 c + d, and the conjugates; further discs follow to
the right. For small systems all eigenvalues are computed at the first shift
(:mod:`cea.eigen.subspace`).
"""

import sys
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from cea.arrays import Complexes
from cea.eigen.field_of_values import bounded_growth, field_of_values, largest_growth
from cea.eigen.pencil import Matrices, release
from cea.eigen.regions import TIP, Disc, covering_disc, distance_of_cone, upper_end
from cea.eigen.search import ATTEMPTS, SHIFT, Search
from cea.eigen.shift_invert import MARGIN
from cea.eigen.shifted import count_below
from cea.eigen.spectrum import Window
from cea.errors import ConvergenceError

_DEPTH, _DEEP = 0.15, 2.4
"""Depth X of the first covering disc relative to omega^2: where the field of values shows that no
eigenvalue lies beyond, and where it does not, for growth rates up to 1.5 omega."""
_FARTHER = 8.0
"""Factor on the depth, or on a real shift, from one disc to the next."""
_AROUND = 1.5
"""Largest radius of a disc about the middle that covers the cone, relative to that of the window
alone."""
_DECAY = 0.1
"""Default decay rate d of a damped window relative to omega, and least first shift, which keeps it
as far from eigenvalues of small growth rate."""
_FAR = 1e-3
"""Size of the largest eigenvalue relative to the shift below which eigenvalues lose digits."""
_NEARER = 2
"""Number of nearer shifts tried then; the first result is exact to rounding about the shift."""
_CROWDED, _FEW = 4, 100
"""Largest number of eigenvalues in a disc: a multiple of the number of undamped modes in the
window, and a constant added to it."""


type Plan = Iterator[tuple[float, float]]
"""Centre and radius of each disc, computed after the previous disc was searched."""


def window_plan(search: Search, decay: float | None) -> Plan:
    """Yield discs that cover a window up to the largest possible growth rate or max_discs.

    Without a given ``decay`` (1/s) that of a damped window may be reduced where modes cluster.
    """
    search.reach = search.end
    yield from _damped(search, decay) if search.matrices.quadratic else _undamped(search)
    for low, high in pairwise(sorted(search.parities)):  # a real one between two shifts
        if search.odd(low) != search.odd(high):
            yield 0.5 * (low + high), 0.5 * (high - low)


def _is_done(search: Search, *, bounded: bool) -> bool:
    """Whether no further disc is needed, or allowed; ``bounded``: no mode grows faster."""
    search.bounded = bounded
    seen = bounded and not search.odd(search.discs[-1].centre)
    return seen or len(search.discs) > search.options.max_discs


def _undamped(search: Search) -> Plan:
    """Yield discs of kappa from the middle of the window to the left.

    Without friction eigenvalues are counted by inertia. With it the bound by the field of values,
    which costs a factorisation, is computed for large systems.
    """
    matrices, top = search.matrices, search.end**2
    upper, middle, depth = upper_end(top), 0.5 * top, _DEEP * top
    radius, reached, bound = upper - middle, -TIP * top, np.inf
    if matrices.symmetric:
        with search.factorising():
            search.counted = count_below(matrices, upper)
        depth = _FARTHER * top
    elif matrices.size > search.options.dense_limit:
        for part in _bounds(search):
            try:
                with search.factorising():
                    slope = field_of_values(part, _DEPTH * top, cone=True)
            except ConvergenceError:
                if part is matrices:
                    raise
                continue
            if slope is None:
                continue
            depth = bound = _DEPTH * top
            around = distance_of_cone(top, middle, depth, slope)
            if around <= _AROUND * radius:
                radius, reached = max(radius, around), depth
                break
    yield from _first(search, middle, radius)
    while True:
        assert search.found is not None
        search.growth = float(np.sqrt(max(reached, 0.0)))
        bounded = search.found.whole or reached >= bound
        if not bounded and search.counted is not None:
            bounded = int(np.sum(search.found.eigenvalues.real < upper)) >= search.counted
        elif not bounded and reached > 0:
            with search.factorising():
                bounded = field_of_values(matrices, reached) is not None
        if _is_done(search, bounded=bounded):
            return
        disc = covering_disc(top, -depth, -reached)
        yield disc.centre, disc.radius
        reached, depth = depth, _FARTHER * depth


def _first(search: Search, centre: float, radius: float) -> Plan:
    """Yield the first disc; again about a nearer shift if all eigenvalues are far smaller."""
    yield centre, radius
    before = search.found, search.discs, search.scale
    for _ in range(_NEARER):
        largest = _largest(search)
        if not 0 < largest < _FAR * centre:
            return
        centre = SHIFT * largest
        search.scale = largest if search.matrices.quadratic else float(np.sqrt(largest))
        search.found, search.discs = None, []
        yield centre, radius
    if _largest(search) < _FAR * centre:  # all are zero apart from rounding
        search.found, search.discs, search.scale = before


def _largest(search: Search) -> float:
    """Return the largest modulus of all eigenvalues; infinite where some lie beyond the window."""
    matrices, found = search.matrices, search.found
    every = (matrices.size - matrices.tied) * (2 if matrices.quadratic else 1)
    if found is None or found.size < every:
        return np.inf
    return float(np.abs(found.eigenvalues).max(initial=0.0))


def _bounds(search: Search) -> Iterator[Matrices]:
    """Yield matrices whose field of values bounds the eigenvalues, the cheapest first."""
    matrices = search.matrices
    with search.timer("assembly"):
        near = matrices.near and matrices.near(matrices)
    if near:
        try:
            yield near
        finally:
            release(near)
    yield matrices


def _damped(search: Search, asked: float | None) -> Plan:
    """Yield discs of lambda from the decay to the right, up to the largest growth rate."""
    matrices, end = search.matrices, search.end
    with search.factorising(2):
        largest = largest_growth(matrices, end)
    yield from _not_crowded(search, largest, asked)
    centre = search.discs[0].centre
    search.growth = 2 * centre + search.decay
    while True:
        assert search.found is not None
        bounded = search.found.whole or search.growth >= largest
        if not bounded:
            with search.factorising():
                bounded = bounded_growth(matrices, search.growth, end)
        if _is_done(search, bounded=bounded):
            return
        left, centre = search.growth, _FARTHER * centre
        yield centre, _radius(end, centre, left)
        search.growth = 2 * centre - left


def _radius(end: float, centre: float, left: float) -> float:
    """Return the radius of the disc through the corners of the damped window at Re = ``left``."""
    return float(np.hypot(centre - left, (1 + MARGIN) * end))


def _not_crowded(search: Search, largest: float, asked: float | None) -> Plan:
    """Yield the first disc, about shifts farther to the right until it holds few enough modes.

    Overdamped modes may cluster at one decay rate. A disc about a shift 1 / SHIFT times farther to
    the right extends less beyond the decay requested. Where such a shift, beyond the first ones for
    which a single disc is to hold every growing mode, does not suffice, a default decay is reduced.
    """
    end = search.end
    search.decay = _DECAY * end if asked is None else asked
    centre, farthest = max(_DECAY * end, 0.5 * (largest - search.decay)), 2 * SHIFT * end
    centre = centre if centre <= farthest else SHIFT * end
    if search.matrices.size > search.options.dense_limit:  # else any number is affordable
        with search.factorising():
            search.most = _CROWDED * count_below(search.matrices, end**2) + _FEW
    for _ in range(ATTEMPTS):
        yield from _first(search, centre, _radius(end, centre, -search.decay))
        if not search.crowded:
            search.most = sys.maxsize
            return
        search.free()  # operators depend on the decay
        if SHIFT * centre >= farthest and asked is None:
            search.decay *= SHIFT
        centre /= SHIFT
    raise ConvergenceError(
        f"{search.crowded}: modes cluster near or above the growth rate {-search.decay:.4g} 1/s; "
        "raise min_growth to exclude them"
    )


def window_of(search: Search, values: Complexes) -> Window:
    """Return the window of a finished search with the evidence that it is complete."""
    assert search.found is not None
    matrices, found, whole = search.matrices, len(values), search.found.whole
    first = search.discs[0] if search.discs else Disc(search.near.shift, 0.0)
    if np.isinf(search.reach):  # eigenvalues nearest to a target
        largest = float(np.abs(values).max(initial=abs(first.centre)))
        end = largest / (2 * np.pi) if matrices.quadratic else np.inf
        return Window(end, first.centre, 0.0, found, neighbours=True)
    upper = search.end if matrices.quadratic else upper_end(search.end**2)
    below = values.real < upper
    if matrices.quadratic:
        below = (values.imag >= 0) & (values.imag <= upper)
    bounded = whole or search.bounded
    return Window(
        max_frequency=search.end / (2 * np.pi),
        shift=first.centre,
        radius=first.radius,
        found=found,
        discs=len(search.discs),
        max_growth=np.inf if bounded else search.growth,
        bounded=bounded,
        odd=search.counted is None and search.odd(),
        upper=upper,
        found_below=int(below.sum()),
        symmetric_count=search.counted,
        whole=whole,
        min_growth=-search.decay if matrices.quadratic else None,
    )
