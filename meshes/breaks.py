"""Breaks: rising coordinates of the element boundaries along each direction of a shape.

A shape is made of blocks, boxes in its coordinates, which both builders map to space.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from cea.arrays import Floats
from cea.errors import require
from meshes.patches import Face, Faces
from meshes.shapes import Annulus, Disc, Hub, Ring, Shape

Breaks = tuple[Floats, ...]

CLOSED = (Annulus, Hub, Disc, Ring)
"""Shapes all the way round, made of four quarters."""
_JOINTS = (90.0, 180.0, 270.0)
_SNAP = 1e-9
"""Distance (degrees, m) from a joint of blocks below which a break lies on it."""


def spread(low: float, high: float, count: int, through: Sequence[float] = ()) -> Floats:
    """Return ``count + 1`` element boundaries, as even as possible, through given coordinates."""
    stops = np.unique(np.concatenate([[low, high], np.asarray(through, dtype=float)]))
    inside = bool(stops[0] == low and stops[-1] == high)
    require(inside, "through", list(through), f"{low} to {high}")
    require(count >= len(stops) - 1, "elements", count, f"at least {len(stops) - 1}")
    lengths = np.diff(stops)
    even = np.floor(count * lengths / (high - low)).astype(int)
    shares = np.maximum(1, even - len(lengths))  # lower bounds of the numbers of elements
    for _ in range(count - shares.sum()):
        shares[np.argmax(lengths / shares)] += 1
    counted = zip(pairwise(stops), shares, strict=True)
    pieces = [np.linspace(a, b, n + 1)[:-1] for (a, b), n in counted]
    return np.concatenate([*pieces, [high]])


def breaks_of(
    shape: Shape, elements: Sequence[int], through: Mapping[str, Sequence[float]] | None = None
) -> Breaks:
    """Breaks of a shape along its directions."""
    asked = _asked(shape, elements, through or {})
    return tuple(
        spread(low, high, count, asked.get(name, ()))
        for name, (low, high), count in zip(shape.directions, shape.extent, elements, strict=True)
    )


def check_breaks(shape: Shape, breaks: Breaks) -> None:
    """Refuse breaks that do not rise from end to end of a shape, through joints of its blocks."""
    along = f"one array along each of {', '.join(shape.directions)}"
    require(len(breaks) == len(shape.directions), "breaks", breaks, along)
    for name, values, (low, high) in zip(shape.directions, breaks, shape.extent, strict=True):
        rising = len(values) > 1 and bool((np.diff(values) > 0).all())
        fits = rising and np.allclose([values[0], values[-1]], [low, high], rtol=1e-12)
        require(bool(fits), f"breaks of {name}", values, f"rising, from {low} to {high}")
        joints = _joints(shape).get(name, ())
        there = all(np.abs(values - joint).min() <= _SNAP for joint in joints)
        require(there, f"breaks of {name}", values, f"{joints} among them")


def _joints(shape: Shape) -> dict[str, tuple[float, ...]]:
    """Coordinates at which blocks of a shape meet, by direction."""
    if isinstance(shape, Hub):
        return {"r": (shape.hub_radius,), "theta": _JOINTS, "z": (shape.bottom, shape.top)}
    return {"theta": _JOINTS} if isinstance(shape, CLOSED) else {}


def _asked(
    shape: Shape, elements: Sequence[int], through: Mapping[str, Sequence[float]]
) -> dict[str, list[float]]:
    """Coordinates through which breaks must go, by direction."""
    asked = {name: list(values) for name, values in through.items()}
    unknown = set(asked) - set(shape.directions)
    require(not unknown, "through", sorted(unknown), f"directions {', '.join(shape.directions)}")
    allowed = f"one number for each of {', '.join(shape.directions)}"
    require(len(elements) == len(shape.directions), "elements", tuple(elements), allowed)
    for name, joints in _joints(shape).items():
        asked[name] = [*asked.get(name, []), *joints]
    return asked


def fewest(shape: Shape, through: Mapping[str, Sequence[float]]) -> tuple[int, ...]:
    """Least number of elements along each direction: one between required boundaries."""
    asked = _asked(shape, (1,) * len(shape.directions), through)
    return tuple(
        len({*ends, *asked.get(name, ())}) - 1
        for name, ends in zip(shape.directions, shape.extent, strict=True)
    )


def layered(breaks: Floats, towards: Sequence[float], layers: int, ratio: float) -> Floats:
    """Breaks with geometric layers towards some of them, as for singular stresses at corners."""
    require(0 < ratio < 0.5 and layers >= 0, "ratio", ratio, "0 to 1/2: layers must not overlap")
    shares = ratio ** np.arange(1, layers + 1)
    new = [breaks]
    for centre in towards:
        at = int(np.abs(breaks - centre).argmin())
        for other in (at - 1, at + 1):
            if 0 <= other < len(breaks):
                new.append(breaks[at] + shares * (breaks[other] - breaks[at]))
    return np.unique(np.concatenate(new))


def blocks_of(shape: Shape, breaks: Breaks) -> tuple[list[Breaks], Faces]:
    """Breaks of each block of a shape, and its named faces.

    Straight shapes and sectors are one block, closed ones four quarters; a hub has those of its
    ring, then four of each layer of the hub from below.
    """
    if isinstance(shape, Hub):
        return _blocks_of_hub(shape, breaks)
    axes = [axis for axis in range(len(breaks)) if not (isinstance(shape, CLOSED) and axis == 1)]
    ends = [(axis, side) for axis in axes for side in (0, 1)]
    if isinstance(shape, Disc):
        ends.remove((0, 0))  # the axis is no face
    blocks = _quarters(*breaks) if isinstance(shape, CLOSED) else [breaks]
    named = dict(zip(shape.surfaces, ends, strict=True))
    return blocks, {name: _on_all(range(len(blocks)), *end) for name, end in named.items()}


def _blocks_of_hub(shape: Hub, breaks: Breaks) -> tuple[list[Breaks], Faces]:
    r, theta, z = breaks
    inside, outside = _between(r, 0.0, shape.hub_radius), _between(r, shape.hub_radius, np.inf)
    levels = np.unique([shape.hub_bottom, shape.bottom, shape.top, shape.hub_top])
    blocks = _quarters(outside, theta, _between(z, shape.bottom, shape.top))
    standing_out: list[int] = []
    for low, high in pairwise(levels):
        if low != shape.bottom:
            standing_out += range(len(blocks), len(blocks) + 4)
        blocks += _quarters(inside, theta, _between(z, low, high))
    ring, hub = range(4), range(4, len(blocks))
    return blocks, {
        "bore": _on_all(hub, 0, 0),
        "outer": _on_all(ring, 0, 1),
        "bottom": _on_all(ring, 2, 0),
        "top": _on_all(ring, 2, 1),
        "hub_bottom": _on_all(hub[:4], 2, 0),
        "hub_top": _on_all(hub[-4:], 2, 1),
        "hub_side": _on_all(standing_out, 0, 1),
    }


def _quarters(radii: Floats, angles: Floats, *heights: Floats) -> list[Breaks]:
    """Breaks of four blocks all the way round."""
    blocks: list[Breaks] = []
    for low, high in pairwise((0.0, *_JOINTS, 360.0)):
        within = _between(angles, low, high)
        within[[0, -1]] = low, high
        blocks.append((radii, within, *heights))
    return blocks


def _between(values: Floats, low: float, high: float) -> Floats:
    return values[(values > low - _SNAP) & (values < high + _SNAP)]


def _on_all(blocks: Iterable[int], axis: int, side: int) -> tuple[Face, ...]:
    """The same face of several blocks."""
    return tuple((block, axis, side) for block in blocks)
