"""NURBS patch: geometry, refinement into the trial space, basis on tensor grids."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError
from iga_cea.collapse import COLLAPSED, Lines, collapsed_lines
from iga_cea.splines import basis_matrix, elevation_matrix, insertion_matrix, knots_with_breaks

_MAP_SAMPLES = 4
"""Intervals between samples of the Jacobian in each span of the geometry."""

_FLAT = 1e-12
"""Jacobian, relative to the product of the longest tangents, below which it is zero."""


class PatchGeometry(Protocol):
    """Plain NURBS data of a patch."""

    @property
    def degrees(self) -> tuple[int, ...]:
        """Degree along each parameter."""

    @property
    def knots(self) -> tuple[Floats, ...]:
        """Open knot vector along each parameter."""

    @property
    def control_points(self) -> Floats:
        """Control points (m), shape (n1, ..., dim), not multiplied by the weights."""

    @property
    def weights(self) -> Floats:
        """Weights, shape (n1, ...)."""

    @property
    def breaks(self) -> tuple[Floats, ...]:
        """Element boundaries along each parameter."""


@dataclass(frozen=True)
class Patch:
    """Patch refined to the trial space, rational with the weights of the geometry."""

    degrees: tuple[int, ...]  # degree along each parameter
    knots: tuple[Floats, ...]  # open knot vector along each parameter
    control_points: Floats  # control points (m), shape (n1, ..., dim)
    weights: Floats  # weights, shape (n1, ...)
    # the unrefined patch: the same map on fewer and larger knot spans
    geometry: PatchGeometry

    @property
    def dim(self) -> int:
        """Dimension of space and of the parameters."""
        return len(self.degrees)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of functions along each parameter."""
        return self.weights.shape

    @cached_property
    def breaks(self) -> tuple[Floats, ...]:
        """Ends of the nonempty knot spans along each parameter."""
        return tuple(np.unique(knots) for knots in self.knots)

    @property
    def spans(self) -> tuple[int, ...]:
        """Number of elements along each parameter."""
        return tuple(len(breaks) - 1 for breaks in self.breaks)

    @cached_property
    def collapsed(self) -> Lines:
        """True for the collapsed rows of control points along each axis."""
        return collapsed_lines(self.control_points)

    @cached_property
    def first_functions(self) -> tuple[Ints, ...]:
        """Number of the first function on each span, along each parameter."""
        return tuple(
            np.searchsorted(knots, breaks[:-1], side="right") - 1 - degree
            for knots, breaks, degree in zip(self.knots, self.breaks, self.degrees, strict=True)
        )


def check_map(geometry: PatchGeometry, field: str) -> None:
    """Raise InputError if a patch is folded or collapsed, except along whole edges."""
    grid = [subdivided(np.unique(knots), _MAP_SAMPLES) for knots in geometry.knots]
    net = homogeneous(geometry)

    def sampled(differentiated: int | None) -> Floats:
        """Return homogeneous coordinates on the grid, or their derivative in a parameter."""
        return _contracted(
            net,
            [
                basis_matrix(knots, p, x, slopes=axis == differentiated).toarray()
                for axis, (knots, p, x) in enumerate(
                    zip(geometry.knots, geometry.degrees, grid, strict=True)
                )
            ],
        )

    point = sampled(None)
    position = point[..., :-1] / point[..., -1:]
    slopes = [sampled(axis) for axis in range(len(grid))]
    jacobian = [(s[..., :-1] - position * s[..., -1:]) / point[..., -1:] for s in slopes]
    tangents = np.stack(jacobian, axis=-1)
    speed = np.linalg.norm(tangents, axis=-2)
    lengths = speed.max(axis=tuple(range(len(grid))))
    determinant = np.linalg.det(tangents) / np.prod(np.where(lengths > 0, lengths, 1.0))
    for axis in range(len(grid)):
        line = speed[..., axis].max(axis=axis, keepdims=True) <= COLLAPSED * lengths[axis]
        line[tuple(slice(None) if k == axis else slice(1, -1) for k in range(len(grid)))] = False
        determinant = np.where(line, np.nan, determinant)
    low, high = np.nanmin(determinant), np.nanmax(determinant)
    if low <= _FLAT and high >= -_FLAT:
        value = f"Jacobian from {low:.3g} to {high:.3g} (relative)"
        allowed = (
            "a map neither folded nor collapsed: a Jacobian of one sign, zero at most on edges "
            "whose control points coincide"
        )
        raise InputError(f"{field}.control_points", value, allowed)


def homogeneous(geometry: PatchGeometry) -> Floats:
    """Return homogeneous control points, weights last, shape (n1, ..., dim + 1)."""
    weights = geometry.weights[..., None]
    return np.concatenate([geometry.control_points * weights, weights], axis=-1)


def _contracted(net: Floats, matrices: Sequence[Floats]) -> Floats:
    """Apply a matrix along each axis of a net."""
    for axis, matrix in enumerate(matrices):
        net = np.moveaxis(np.tensordot(matrix, net, axes=(1, axis)), 0, axis)
    return net


def refine(geometry: PatchGeometry, degree: Sequence[int], continuity: Sequence[int]) -> Patch:
    """Elevate the degree of a patch and insert its breaks, without changing the geometry."""
    refined_knots, operators = [], []
    for axis, (p, q, c) in enumerate(zip(geometry.degrees, degree, continuity, strict=True)):
        knots, elevation = elevation_matrix(np.asarray(geometry.knots[axis], dtype=float), p, q)
        refined = knots_with_breaks(knots, q, geometry.breaks[axis], c)
        operators.append(insertion_matrix(knots, q, refined) @ elevation)
        refined_knots.append(refined)
    net = _contracted(homogeneous(geometry), operators)
    weights = np.ascontiguousarray(net[..., -1])
    return Patch(
        degrees=tuple(degree),
        knots=tuple(refined_knots),
        control_points=net[..., :-1] / weights[..., None],
        weights=weights,
        geometry=geometry,
    )


def subdivided(breaks: Floats, parts: int) -> Floats:
    """Divide each span evenly; return the breaks, shape (spans * parts + 1,)."""
    pieces = [np.linspace(a, b, parts, endpoint=False) for a, b in pairwise(breaks)]
    return np.concatenate([*pieces, breaks[-1:]])
