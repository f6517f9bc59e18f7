"""Breaks: rising coordinates of the element boundaries along each direction of a shape."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from cea.arrays import Floats
from cea.errors import require
from meshes.shapes import Annulus, Disc, Hub, Ring, Shape

Breaks = tuple[Floats, ...]

CLOSED = (Annulus, Hub, Disc, Ring)
"""Shapes all the way round, in four quarters."""


def spread(low: float, high: float, count: int, through: Sequence[float] = ()) -> Floats:
    """``count + 1`` element boundaries as even as possible that pass through given coordinates."""
    stops = np.unique(np.concatenate([[low, high], np.asarray(through, dtype=float)]))
    inside = bool(stops[0] == low and stops[-1] == high)
    require(inside, "through", list(through), f"{low} to {high}")
    require(count >= len(stops) - 1, "elements", count, f"at least {len(stops) - 1}")
    lengths = np.diff(stops)
    even = np.floor(count * lengths / (high - low)).astype(int)
    shares = np.maximum(1, even - len(lengths))  # fewer than each gets
    for _ in range(count - shares.sum()):
        shares[np.argmax(lengths / shares)] += 1
    pieces = [
        np.linspace(a, b, n + 1)[:-1] for (a, b), n in zip(pairwise(stops), shares, strict=True)
    ]
    return np.concatenate([*pieces, [high]])


def breaks_of(
    shape: Shape,
    elements: Sequence[int],
    through: Mapping[str, Sequence[float]] | None = None,
) -> Breaks:
    """Breaks of a shape along its directions."""
    asked = _asked(shape, elements, through or {})
    return tuple(
        spread(low, high, count, asked.get(name, ()))
        for name, (low, high), count in zip(shape.directions, shape.extent, elements, strict=True)
    )


def check_ends(shape: Shape, breaks: Breaks) -> None:
    """Refuse breaks that do not rise from one end of a shape to the other."""
    along = f"one array along each of {', '.join(shape.directions)}"
    require(len(breaks) == len(shape.directions), "breaks", breaks, along)
    for name, values, (low, high) in zip(shape.directions, breaks, shape.extent, strict=True):
        rising = len(values) > 1 and bool((np.diff(values) > 0).all())
        fits = rising and np.allclose([values[0], values[-1]], [low, high], rtol=1e-12)
        require(bool(fits), f"breaks of {name}", values, f"rising, from {low} to {high}")


def _asked(
    shape: Shape, elements: Sequence[int], through: Mapping[str, Sequence[float]]
) -> dict[str, list[float]]:
    """Coordinates through which breaks must go, by direction."""
    asked = {name: list(values) for name, values in through.items()}
    unknown = set(asked) - set(shape.directions)
    require(not unknown, "through", sorted(unknown), f"directions {', '.join(shape.directions)}")
    allowed = f"one number for each of {', '.join(shape.directions)}"
    require(len(elements) == len(shape.directions), "elements", tuple(elements), allowed)
    if isinstance(shape, CLOSED):
        asked["theta"] = [*asked.get("theta", []), 90.0, 180.0, 270.0]
    if isinstance(shape, Hub):
        asked["r"] = [*asked.get("r", []), shape.hub_radius]
        asked["z"] = [*asked.get("z", []), shape.bottom, shape.top]
    return asked


def fewest(shape: Shape, through: Mapping[str, Sequence[float]]) -> tuple[int, ...]:
    """Fewest elements along each direction: one between neighbours that must be boundaries."""
    asked = _asked(shape, (1,) * len(shape.directions), through)
    return tuple(
        len({*ends, *asked.get(name, ())}) - 1
        for name, ends in zip(shape.directions, shape.extent, strict=True)
    )


def layered(breaks: Floats, towards: Sequence[float], layers: int, ratio: float) -> Floats:
    """Breaks with geometric layers towards some of them, as corners of stress ask for."""
    require(0 < ratio < 0.5 and layers >= 0, "ratio", ratio, "below 1/2: layers may meet")
    shares = ratio ** np.arange(1, layers + 1)
    new = [breaks]
    for centre in towards:
        at = int(np.abs(breaks - centre).argmin())
        for other in (at - 1, at + 1):
            if 0 <= other < len(breaks):
                new.append(breaks[at] + shares * (breaks[other] - breaks[at]))
    return np.unique(np.concatenate(new))
