"""Wide windows in slices: many eigenvalues along the real axis, found from several shifts.

What a Krylov space costs grows with the square of its columns, and its small eigenproblems with
their cube, while a further shift costs a factorisation. Slices are discs about shifts on the real
axis, each with as many eigenvalues as are cheapest (:func:`plan_of`), that overlap and
cover an interval. Where two overlap the axis is cut in the widest gap between eigenvalues, each
slice keeps what lies on its side, and the parts are joined to one invariant subspace. That is a
way to most eigenvalues and no evidence: what slices miss, far from the axis or near a cut, is found
by the searches beside them.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.blocks import image_of
from cea.eigen.dense_products import combined, inner, subtract
from cea.eigen.found import Disc
from cea.eigen.subspace import InvariantSubspace

_SOLVE, _IMAGE, _PROJECT, _SMALL = 4.5, 600.0, 5.0, 35.0
"""Operations of a column: for each entry of the factors, for each row, for each row and vector of
the space; and of the small eigenproblems, for the cube of their size. Each in numeric operations
of a factorisation, which are the fastest; measured."""
_IN_SLICES, _IN_ONE, _FIRST = 3.3, 1.7, 60
"""Columns of a space for each eigenvalue about a shift, where others are on both sides of them, and
where there are none on one; and those besides."""
_SIZES = np.arange(40, 1000, 10)
"""Eigenvalues of a slice that are thought of."""
_NUMBERS = np.geomspace(100, 1e6, 200)
"""Eigenvalues of a window that are thought of."""
_WORTH = 0.7
"""Cost of slices, relative to that of one search, from which on they are worth it."""
_SMALL_SYSTEM = 10_000
"""Unknowns below which nothing is worth it."""
_OVERLAP = 0.05
"""Part of the radius of a slice to which it reaches over its neighbour."""
_LEAST = 0.2
"""Least part of a slice that is expected to be found of it."""
_MOST = 64
"""Most slices."""
_PARALLEL = 1e-6
"""Square of the least part of vectors of a slice outside all before it."""


@dataclass(frozen=True)
class Slice:
    """What was found in a disc about a shift.

    Parameters
    ----------
    disc
        About the shift; every eigenvalue in it was found.
    found
        Their invariant subspace, with some around the disc.
    """

    disc: Disc
    found: InvariantSubspace

    @property
    def low(self) -> float:
        """Left end on the real axis (1/s^2)."""
        return self.disc.centre - self.disc.radius

    @property
    def high(self) -> float:
        """Right end on the real axis (1/s^2)."""
        return self.disc.centre + self.disc.radius


@dataclass(frozen=True)
class Plan:
    """When eigenvalues are sought in slices.

    Parameters
    ----------
    columns
        Of a Krylov space at which those of slices cost least each.
    many
        Eigenvalues of a window from which on slices cost less than one search.
    """

    columns: int
    many: float


NO_SLICES = Plan(sys.maxsize, np.inf)
"""One search, whatever it costs."""


def plan_of(rows: int, entries: float, operations: float) -> Plan:
    """What is cheapest.

    Parameters
    ----------
    rows
        Unknowns.
    entries, operations
        Entries of the factors, and operations of their factorisation.
    """
    if rows < _SMALL_SYSTEM:
        return NO_SLICES

    def cost(columns: NDArray[Any]) -> NDArray[Any]:
        solves = columns * (_SOLVE * entries + _IMAGE * rows)
        return operations + solves + 0.5 * _PROJECT * rows * columns**2 + _SMALL * columns**3

    columns = _IN_SLICES * _SIZES + _FIRST
    each = cost(columns) / (_SIZES * (1 - _OVERLAP))
    best = int(np.argmin(each))
    one = cost(_IN_ONE * _NUMBERS + _FIRST) / _NUMBERS
    worth = (each[best] < _WORTH * one) & (2 * _SIZES[best] < _NUMBERS)
    many = float(_NUMBERS[np.argmax(worth)]) if worth.any() else np.inf
    return Plan(int(columns[best]), many)


def covered(
    first: Slice, low: float, high: float, search: Callable[[float, float], Slice]
) -> list[Slice]:
    """Slices that cover an interval of the real axis, from left to right.

    Parameters
    ----------
    first
        One that was found.
    low, high
        Ends of the interval (1/s^2).
    search
        Searches a disc, of a shift and a radius: the slice that was found may be smaller.
    """
    slices, wanted, part = [first], _count(first, first.low, first.high), 1.0
    while len(slices) < _MOST and (gap := _gap(slices, low, high)):
        shift, radius = _next(slices, gap, wanted)
        slices.append(search(shift, radius / part))
        # Where less came of the last one as much less is expected of the next.
        part = min(1.0, max(slices[-1].disc.radius * part / radius, _LEAST))
        slices.sort(key=lambda each: each.disc.centre)
    return slices


def _gap(slices: list[Slice], low: float, high: float) -> tuple[float, float] | None:
    """What is covered last: the gap farthest to the right."""
    for each in reversed(slices):
        if each.high < high:
            return each.high, high
        high = min(high, each.low)
    return (low, high) if low < high else None


def _next(slices: list[Slice], gap: tuple[float, float], wanted: int) -> tuple[float, float]:
    """Shift and radius of the next slice, at the end of a gap that a slice touches."""
    left, right = gap
    neighbours = {each.high: each for each in slices} | {each.low: each for each in slices}
    at, to = (left, 1.0) if left in neighbours else (right, -1.0)
    there = neighbours[at]
    density = _count(there, *sorted((there.disc.centre, at))) / there.disc.radius
    width = right - left
    number = max(1, round(width * density / wanted))  # of equal slices that fill the gap
    radius = width / number / (2 - 2 * _OVERLAP)
    return at + to * (1 - _OVERLAP) * radius, radius


def _count(part: Slice, low: float, high: float) -> int:
    values = part.found.eigenvalues()
    return int(((values.real >= low) & (values.real <= high)).sum())


def joined(slices: list[Slice], mass: Any) -> InvariantSubspace:
    """The invariant subspace of all, each slice on its side of the cuts.

    Parameters
    ----------
    slices
        From left to right.
    mass
        M.
    """
    cuts = [-np.inf, *map(_cut, slices[:-1], slices[1:]), np.inf]
    parts = [
        each.found.between(low, high)
        for each, low, high in zip(slices, cuts[:-1], cuts[1:], strict=True)
    ]
    rows, total = len(parts[0].basis), sum(part.size for part in parts)
    basis, projected = np.empty((rows, total), order="F"), np.zeros((total, total))
    size = 0
    for part in parts:
        size = _beside(basis, projected, size, part, mass)
    return InvariantSubspace(basis[:, :size], projected[:size, :size], parts[0].symmetric)


def _cut(left: Slice, right: Slice) -> float:
    """Where two slices are parted: in the widest gap of eigenvalues where they overlap."""
    low, high = sorted((right.low, left.high))
    values = np.concatenate([left.found.eigenvalues().real, right.found.eigenvalues().real])
    ends = np.sort([low, high, *values[(values > low) & (values < high)]])
    widest = int(np.argmax(np.diff(ends)))
    return float(0.5 * (ends[widest] + ends[widest + 1]))


def _beside(basis: Floats, projected: Floats, size: int, part: InvariantSubspace, mass: Any) -> int:
    """Put a part behind Q = basis[:, :size], where M^-1 K Q = Q R; the size of both.

    With P = Q C + P' T it is M^-1 K [Q P'] = [Q P'] [R, (C R_P - R C) T^-1; 0, T R_P T^-1]. A part
    that lies in Q but for little, found twice, is left out.
    """
    comm = mass.comm.tompi4py()
    known, block = basis[:, :size], part.basis.copy(order="F")
    across, turn = np.zeros((size, part.size)), np.eye(part.size)
    for _ in range(2):
        image = image_of(mass, block)
        step = comm.allreduce(inner(known, image))
        across += step @ turn
        subtract(block, known, step)
        gram = comm.allreduce(inner(block, image_of(mass, block)))
        squares, axes = np.linalg.eigh(gram)
        if part.size and squares[0] < _PARALLEL:
            return size
        lengths = np.sqrt(squares)
        block = combined(block, axes / lengths)
        turn = (axes * lengths).T @ turn
    end = size + part.size
    basis[:, size:end] = block
    inverse = np.linalg.inv(turn)
    own = projected[:size, :size]
    projected[:size, size:end] = (across @ part.projected - own @ across) @ inverse
    projected[size:end, size:end] = turn @ part.projected @ inverse
    return end
