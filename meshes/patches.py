"""Geometry given as NURBS patches: knots, control points and weights, checked before use."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cea.arrays import finite_numbers
from cea.errors import require

Floats = NDArray[np.float64]
Face = tuple[int, int, int]

_SAME = 1e-10
"""Length of a step between control points in one place, relative to the longest."""


@dataclass(frozen=True)
class GivenPatch:
    """One NURBS patch as plain numbers.

    Parameters
    ----------
    degrees
        Degree along each of its two (plane strain) or three parameters.
    knots
        Open knot vector along each parameter, over any range; inner knots may repeat up to the
        degree, and stay as often in the refined patch.
    control_points
        Control points (m) in nested lists of shape (n1, ..., dim), not multiplied by the weights.
    weights
        Weights in nested lists of shape (n1, ...); all 1 by default.

    Raises
    ------
    InputError
        When numbers do not fit together, knots do not rise, or weights are not positive.
    """

    degrees: tuple[int, ...]
    knots: tuple[tuple[float, ...], ...]
    control_points: tuple[Any, ...]
    weights: tuple[Any, ...] | None = None

    def __post_init__(self) -> None:
        dim = len(self.degrees)
        degrees_fit = dim in (2, 3) and all(p >= 1 for p in self.degrees)
        require(degrees_fit, "degrees", self.degrees, "two or three whole numbers from 1")
        require(len(self.knots) == dim, "knots", self.knots, f"{dim} knot vectors, one a degree")
        for axis, (knots, p) in enumerate(zip(self.knots, self.degrees, strict=True)):
            _check_knots(np.asarray(knots, dtype=float), p, f"knots[{axis}]", knots)
        counts = tuple(len(k) - p - 1 for k, p in zip(self.knots, self.degrees, strict=True))
        points = _array(self.control_points, "control_points")
        allowed = f"shape {(*counts, dim)}: knots less degree less 1 along each parameter"
        require(points.shape == (*counts, dim), "control_points", points.shape, allowed)
        if self.weights is not None:
            weights = _array(self.weights, "weights")
            require(weights.shape == counts, "weights", weights.shape, f"shape {counts}")
            require(bool(np.all(weights > 0)), "weights", float(weights.min()), "positive numbers")

    @property
    def points(self) -> Floats:
        """Control points (m), shape (n1, ..., dim)."""
        return np.asarray(self.control_points, dtype=float)

    @property
    def shortest(self) -> float:
        """Shortest step from a control point to the next that is not in the same place (m)."""
        dim = len(self.degrees)
        steps = [np.linalg.norm(np.diff(self.points, axis=k), axis=-1).ravel() for k in range(dim)]
        every = np.concatenate(steps)
        return float(every[every > _SAME * every.max()].min(initial=np.inf))

    @property
    def point_weights(self) -> Floats:
        """Weights, shape (n1, ...)."""
        if self.weights is None:
            return np.ones(self.points.shape[:-1])
        return np.asarray(self.weights, dtype=float)


@dataclass(frozen=True)
class Patches:
    """Any conforming NURBS patches, joined with continuity 0 where their faces coincide.

    The directions u, v (and w) of the shape are the parameters of each patch in their own order,
    each scaled to the range 0 to 1: elements divide this range of every patch evenly, beside the
    knots it has. Where patches meet with their parameters in another order, degree and elements
    must be the same along those that meet.

    Parameters
    ----------
    patches
        The patches, in any relative orientation.
    faces
        Faces [patch, axis, side] of each named surface; side 0 is where the parameter is least.
    merge_nodes
        Distance (m) within which control points are made one; by default none are.

    Raises
    ------
    InputError
        When patches differ in dimension, faces do not exist, or merge_nodes is not small beside the
        distances of control points.
    """

    patches: tuple[GivenPatch, ...]
    faces: dict[str, tuple[Face, ...]]
    merge_nodes: float | None = None
    shape: Literal["patches"] = "patches"

    left_out: ClassVar[tuple[str, ...]] = ("merge_nodes",)
    """Fields left out of plain data where they say nothing (:mod:`scenes.plain`)."""
    names: ClassVar[tuple[str, ...]] = ("u", "v", "w")

    def __post_init__(self) -> None:
        dims = sorted({len(patch.degrees) for patch in self.patches})
        require(len(dims) == 1, "patches", dims, "at least one patch, all of one dimension")
        count, dim = len(self.patches), dims[0]
        for name, ends in self.faces.items():
            real = [0 <= p < count and 0 <= a < dim and s in (0, 1) for p, a, s in ends]
            fits = bool(real) and all(real) and len(set(map(tuple, ends))) == len(ends)
            allowed = f"different [patch below {count}, axis below {dim}, side 0 or 1]"
            require(fits, f"faces[{name}]", ends, allowed)
        if self.merge_nodes is not None:
            shortest = min(patch.shortest for patch in self.patches)
            fits = 0 < self.merge_nodes < shortest / 2
            allowed = f"above 0, less than half the shortest step of a net, {shortest:.3g} m"
            require(fits, "merge_nodes", self.merge_nodes, allowed)

    @cached_property
    def nets(self) -> tuple[Floats, ...]:
        """Control points of each patch (m), shape (n1, ..., dim), those made one that are near."""
        nets = [patch.points for patch in self.patches]
        if self.merge_nodes is None:
            return tuple(nets)
        every = np.concatenate([net.reshape(-1, net.shape[-1]) for net in nets])
        pairs = cKDTree(every).query_pairs(self.merge_nodes, output_type="ndarray")
        links = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(every),) * 2)
        _, group = connected_components(links, directed=False)
        every = every[np.unique(group, return_index=True)[1]][group]
        ends = np.cumsum([net.size // net.shape[-1] for net in nets])[:-1]
        parts = zip(np.split(every, ends), nets, strict=True)
        return tuple(part.reshape(net.shape) for part, net in parts)

    @cached_property
    def directions(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return self.names[: len(self.patches[0].degrees)]

    @cached_property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the surfaces."""
        return tuple(self.faces)

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the scaled parameters."""
        return ((0.0, 1.0),) * len(self.directions)


def _array(nested: tuple[Any, ...], field: str) -> Floats:
    """Nested lists as an array of finite numbers."""
    return finite_numbers(
        nested, field, "nested lists of finite numbers, equally long at each depth"
    )


def _check_knots(knots: Floats, p: int, field: str, given: tuple[float, ...]) -> None:
    """Refuse knot vectors that are not open, do not rise, or tear the patch."""
    rise = len(knots) >= 2 * p + 2 and bool(
        np.isfinite(knots).all() and np.all(np.diff(knots) >= 0)
    )
    require(rise, field, given, f"at least {2 * p + 2} finite numbers that do not fall")
    open_ends = knots[0] == knots[p] < knots[p + 1] and knots[-p - 2] < knots[-p - 1] == knots[-1]
    require(bool(open_ends), field, given, f"first and last knot exactly {p + 1} times")
    often = int(np.unique(knots[p + 1 : -p - 1], return_counts=True)[1].max(initial=0))
    require(often <= p, field, given, f"inner knots at most {p} times: continuity 0 at least")
