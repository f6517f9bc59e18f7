"""Parameter boxes: an axis over more than two decades is cut, and each box has its own basis."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from cea.arrays import Floats, Ints
from comparisons.sweep.points import Points

_DECADES = 2.0
"""Decades of a field that a box spans at most, where values of it lie between."""
_TRAINING = 5
"""Values of an axis at which bounds are looked at while a basis is made."""
_SAMPLES = 48
"""Samples at which they are, beside those at the ends of fields."""
_TOGETHER = 64
"""Samples that are solved and stored together."""


@dataclass(frozen=True)
class Box:
    """Points that share a basis.

    Least and greatest value of each field, those of a neighbour included; numbers of the points
    that are solved and stored together, along the first axis, or some samples; numbers of those at
    which bounds are looked at first.
    """

    ends: tuple[tuple[float, float], ...]
    parts: tuple[Ints, ...]
    training: Ints


def boxes_of(points: Points) -> list[Box]:
    """Boxes that hold all points; those along the first axis share the values at their borders."""
    if not points.counts:
        return [_of_samples(points)]
    stretches = [_stretches(points.axis(i)) for i in range(len(points.counts))]
    numbers = np.arange(len(points.values)).reshape(points.counts)
    return [_of_grid(points, numbers, each) for each in product(*stretches)]


def _of_grid(points: Points, numbers: Ints, stretches: Sequence[Ints]) -> Box:
    whole = numbers[np.ix_(*stretches)]
    ends = points.values[whole.ravel()]
    # A value at the border of another axis than the first belongs to the box below.
    own = [each[1:] if each[0] else each for each in stretches[1:]]
    lines = numbers[np.ix_(stretches[0], *own)].reshape(len(stretches[0]), -1)
    chosen = [np.linspace(0, n - 1, min(_TRAINING, n)).round().astype(int) for n in whole.shape]
    return Box(
        tuple(zip(ends.min(axis=0).tolist(), ends.max(axis=0).tolist(), strict=True)),
        tuple(lines.T),
        whole[np.ix_(*chosen)].ravel(),
    )


def _of_samples(points: Points) -> Box:
    values, every = points.values, np.arange(len(points.values))
    at_ends = [*values.argmin(axis=0).tolist(), *values.argmax(axis=0).tolist()]
    parts = np.array_split(every, int(np.ceil(len(every) / _TOGETHER)))
    training = np.unique([*at_ends, *every[:_SAMPLES].tolist()])
    return Box(tuple(points.ends), tuple(parts), training)


def _stretches(values: Floats) -> list[Ints]:
    """Numbers of neighbouring values within two decades, a border in both of its stretches."""
    last, cuts = len(values) - 1, [0]
    if not (values > 0).all():
        return [np.arange(last + 1)]
    logarithms = np.log10(values)
    while cuts[-1] < last:
        away = np.abs(logarithms - logarithms[cuts[-1]])
        within = np.flatnonzero(away <= _DECADES * (1 + 1e-9))
        cuts.append(max(int(within.max()), cuts[-1] + 1))
    return [np.arange(low, high + 1) for low, high in pairwise(cuts)]
