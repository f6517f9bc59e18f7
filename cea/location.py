"""Location of points on a curved surface along given directions, by clamped Newton iterations.

For a point x with direction d and a surface element with position F(xi), solve
F(xi) - s d = x for xi and the signed distance s, with xi clamped to the element. The residual that
remains is the distance by which the line misses the element.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints, chunks
from cea.mesh import lattice
from cea.surface_points import Location, Status, SurfaceCells, SurfaceCoordinates

TOLERANCE = 1e-8
"""Default tolerance for the distance by which a line misses a surface, in local mesh sizes."""

_MAX_ITERATIONS = 40
_GRAZING = 1e-10  # sine between line and surface below which the step is a least-squares step
_PER_POINT = 1280  # bytes of temporaries per point
_SIDE = 4  # intervals between samples along a side of a cell
_SAFETY = 1.5  # safety factor on the sampled distance of curved cells from flat ones
_NEAR = 1.05
"""Multiple of a cell's bounding radius within which a line passes to be a candidate."""


def cross(tangents: Floats) -> Floats:
    """Return t1 x t2 in 3D, (t_y, -t_x) in 2D, (n, dim): normals as long as the area element."""
    if tangents.shape[1] == 2:
        t = tangents[:, :, 0]
        return np.column_stack([t[:, 1], -t[:, 0]])
    return np.cross(tangents[:, :, 0], tangents[:, :, 1])


def _newton(
    chart: "Chart",
    element: Ints,
    xi: Floats,
    x: Floats,
    direction: Floats,
    tolerance: float,
) -> tuple[Floats, Floats, Floats]:
    """Iterate all pairs at once; pairs whose xi no longer changes leave the iteration."""
    xi = chart.clamp(element, xi)
    offset = np.empty(x.shape)
    active = np.arange(len(element))
    for _ in range(_MAX_ITERATIONS):
        if not active.size:
            break
        e, before = element[active], xi[active]
        position, tangents = chart.tangents(e, before)
        rest = x[active] - position
        xi[active] = chart.clamp(e, before + newton_step(tangents, direction[active], rest))
        way = xi[active] - before
        # The last steps are so short that a linear update of the position is accurate.
        offset[active] = np.einsum("nij,nj->ni", tangents, way) - rest
        active = active[np.abs(way).max(axis=1) > 1e-3 * tolerance]
    if active.size:
        offset[active] = chart.tangents(element[active], xi[active])[0] - x[active]
    distance, miss = _apart(offset, direction)
    return xi, distance, miss


def newton_step(tangents: Floats, direction: Floats, rest: Floats) -> Floats:
    """Return the Newton step of xi, which solves t_1 a + t_2 b - s d = rest by Cramer's rule.

    Where the line is nearly tangent to the surface, return the least-squares step.
    """
    normal = cross(tangents)
    volume = np.einsum("ni,ni->n", normal, direction)
    squares = np.einsum("nij,nij->nj", tangents, tangents).prod(axis=1)
    grazing = ~(np.abs(volume) > _GRAZING * np.sqrt(squares))
    if tangents.shape[1] == 2:
        step = rest[:, 1:] * direction[:, :1] - rest[:, :1] * direction[:, 1:]
    else:  # t_2 . (d x rest), - t_1 . (d x rest)
        turned = np.cross(direction, rest) * [[[1.0]], [[-1.0]]]
        step = np.einsum("nij,jni->nj", tangents[:, :, ::-1], turned)
    step /= np.where(grazing, 1.0, volume)[:, None]
    if grazing.any():
        # The direction is scaled to the length of the tangents, so that rcond truncates neither.
        length = np.linalg.norm(tangents[grazing], axis=1).max(axis=1)
        along = -length[:, None, None] * direction[grazing, :, None]
        inverse = np.linalg.pinv(np.concatenate([tangents[grazing], along], axis=2), rcond=1e-8)
        step[grazing] = np.einsum("nij,nj->ni", inverse[:, :-1], rest[grazing])
    return step


def near_boxes(low: Floats, high: Floats, x: Floats, reach: float) -> tuple[Ints, Ints]:
    """Return pairs of points x (m), (m, dim), and boxes within ``reach`` of each other.

    Boxes have sides along the axes, from low to high (m), (n, dim) each.
    """
    half = 0.5 * (high - low).max(axis=1) + reach
    found = cKDTree(x).query_ball_point(0.5 * (low + high), half, p=np.inf)
    box = np.repeat(np.arange(len(found)), [len(each) for each in found])
    point = np.concatenate([*found, []]).astype(np.int64)
    at = x[point]
    near = ((at >= low[box] - reach) & (at <= high[box] + reach)).all(axis=1)
    return point[near], box[near]


class CellBounds:
    """Bounding boxes and spheres of the cells of a surface; ``tangents`` gives positions."""

    def __init__(
        self, cells: SurfaceCells, tangents: Callable[[Ints, Floats], tuple[Floats, Floats]]
    ) -> None:
        self.element = cells.element
        steps = lattice(cells.corners.shape[2], _SIDE, not cells.tensor)
        t = steps / _SIDE
        at, _ = cells.coordinates(t)
        x = tangents(at.element, at.xi)[0].reshape(len(cells.element), len(t), -1)
        corner = np.flatnonzero(np.isin(steps, (0, _SIDE)).all(axis=1))
        if cells.tensor:
            ends = steps[corner] == _SIDE
            shape = np.where(ends, t[:, None], 1 - t[:, None]).prod(axis=2)
        else:  # corners in C order: the first, that along the second direction, along the first
            shape = np.column_stack([1 - t.sum(axis=1), t[:, ::-1]])
        corners = x[:, corner]
        margin = _SAFETY * np.abs(x - shape @ corners).max(axis=1)
        self.low, self.high = corners.min(axis=1) - margin, corners.max(axis=1) + margin
        self.centre = corners.mean(axis=1)
        farthest = np.linalg.norm(corners - self.centre[:, None], axis=2).max(axis=1)
        self.radius = farthest + np.linalg.norm(margin, axis=1)
        # No starting points on the edges: the tangents vanish on a collapsed edge.
        far = steps.max(axis=1) if cells.tensor else steps.sum(axis=1)
        inner = (steps > 0).all(axis=1) & (far < _SIDE)
        self.starts = at.xi.reshape(*x.shape[:2], -1)[:, inner]
        self.samples = x[:, inner]


def _apart(offset: Floats, aim: Floats) -> tuple[Floats, Floats]:
    """Return components of offsets along unit directions, and distances across, (...,) each."""
    along = (offset * aim).sum(axis=-1)
    return along, np.linalg.norm(offset - along[..., None] * aim, axis=-1)


class Chart(ABC):
    """Elements of a surface, with the geometry that point location needs."""

    @property
    @abstractmethod
    def domains(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of xi of each element, (num_elements, dim - 1) each.

        Elements are rectangles with these bounds or, if cells are not tensor products, triangles.
        """

    @abstractmethod
    def cells(self) -> SurfaceCells:
        """Return the cells inside which traces are smooth: parallelograms or triangles of xi."""

    @abstractmethod
    def size(self, element: Ints) -> Floats:
        """Return the local mesh size (m) of elements, their largest cell diameter, shape (n,)."""

    @abstractmethod
    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Return positions (m), (n, dim), and derivatives dx_i/dxi_j, (n, dim, dim - 1).

        Outside the element the polynomials of the element are extrapolated.
        """

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        return self.domains[0].shape[1] + 1

    def locate(
        self, x: Floats, direction: Floats, reach: float, tolerance: float = TOLERANCE
    ) -> Location:
        """Locate points x (m) along unit directions, (n, dim) each, up to a distance ``reach`` (m).

        Of several hits the nearest along the direction is chosen, then the one whose normal is
        closest to the direction, as at a corner, then the lowest element; of several misses the
        smallest. A point is missed if its line passes farther than ``tolerance`` local mesh sizes.
        """
        n = len(x)
        at = SurfaceCoordinates(np.full(n, -1, dtype=np.int64), np.zeros((n, self.dim - 1)))
        missed = np.full(n, Status.MISSED, dtype=np.int8)
        out = Location(at, np.full(n, np.nan), missed, tolerance)
        for rows in chunks(n, _PER_POINT):
            point, element, xi = self.candidates(x[rows], direction[rows], reach)
            point = point + rows.start
            aim = direction[point]
            xi, distance, miss = _newton(self, element, xi, x[point], aim, tolerance)
            relative = miss / self.size(element)
            hit = (relative <= tolerance) & (np.abs(distance) <= reach)
            # Order: hits before misses; hits by distance, then by 1 - cosine of line and normal,
            # rounded so that elements tie at a shared edge and where they join smoothly.
            rank = np.where(hit, np.round(np.abs(distance) / reach, 10), relative)
            several = np.flatnonzero(hit & (np.bincount(point, hit)[point] > 1))
            flat = np.zeros(len(hit))
            normal = cross(self.tangents(element[several], xi[several])[1])
            length, along = (
                np.linalg.norm(normal, axis=1),
                np.einsum("ni,ni->n", normal, aim[several]),
            )
            flat[several] = np.round(1 - np.abs(along) / np.where(length > 0, length, 1.0), 6)
            order = np.lexsort((element, flat, rank, ~hit, point))
            found, first = np.unique(point[order], return_index=True)
            best = order[first]
            at.element[found], at.xi[found] = element[best], xi[best]
            out.distance[found] = distance[best]
            edge = self.on_edge(element[best], xi[best], 10 * tolerance)
            inside = np.where(edge, Status.EDGE, Status.INSIDE)
            out.status[found] = np.where(hit[best], inside, Status.MISSED)
        return out

    def candidates(self, x: Floats, direction: Floats, reach: float) -> tuple[Ints, Ints, Floats]:
        """Return points, elements and initial xi of pairs that include every hit."""
        bounds = self.bounds
        # Margin for rounding, since the reach may be zero.
        room = reach + 1e-6 * 2 * float(bounds.radius.max())
        point, cell = near_boxes(bounds.low, bounds.high, x, room)
        along, across = _apart(bounds.centre[cell] - x[point], direction[point])
        near = _NEAR * bounds.radius[cell]
        tried = (across <= near) & (np.abs(along) <= reach + near)
        point, cell = point[tried], cell[tried]
        offset = bounds.samples[cell] - x[point][:, None]
        along, across = _apart(offset, direction[point][:, None])
        best = np.hypot(across, np.maximum(np.abs(along) - reach, 0.0)).argmin(axis=1)
        return point, bounds.element[cell], bounds.starts[cell, best]

    @cached_property
    def bounds(self) -> CellBounds:
        """Bounding boxes and spheres of the cells."""
        return CellBounds(self.cells(), self.tangents)

    def clamp(self, element: Ints, xi: Floats) -> Floats:
        """Return the reference coordinates in the element nearest to xi, (n, dim - 1)."""
        if self.cells().tensor:
            low, high = self.domains
            return np.clip(xi, low[element], high[element])
        inside = np.maximum(xi, 0.0)
        along = np.clip((1 + xi[:, 0] - xi[:, 1]) / 2, 0.0, 1.0)
        slanted = np.column_stack([along, 1 - along])
        return np.where(inside.sum(axis=1, keepdims=True) > 1, slanted, inside)

    def on_edge(self, element: Ints, xi: Floats, tolerance: float) -> NDArray[np.bool_]:
        """Return whether xi is within ``tolerance``, relative to its range, of the cell's edges."""
        low, high = (ends[element] for ends in self.domains)
        t = (xi - low) / (high - low)
        far = 1 - (t.max(axis=1) if self.cells().tensor else t.sum(axis=1))
        return np.minimum(t.min(axis=1), far) <= tolerance
