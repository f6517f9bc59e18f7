"""Segments: Gauss points on the common refinement of two surface meshes.

Trace functions are smooth only inside the cells of their surface (facets of a mesh, knot spans of
a patch). A rule for products of both traces must break at the cell boundaries of both. Cells of
side b are mapped along the normal of a into the reference coordinates of each cell of a that they
may overlap, and clipped there. Cells bounded by parameter lines of both sides, or by straight lines
on flat facets, are clipped exactly; other edges are approximated by polylines. Where the boundary
of b is concave, or crosses that of a at a small angle, polylines extend slightly beyond it: points
there that have no opposite point are dropped.

A cell of b may overlap a cell of a only partly, so that some of its corners lie outside. Outside,
the polynomials of the cell are extrapolated, which keeps parameter lines straight in its
coordinates. Far outside, the polynomials fold over or come full circle, and a corner would appear
on the wrong side. Coordinates are therefore continued along the straight line from the centre of
the cell to the point, as long as the tangents turn by less than a right angle. The rest of the
line, if any, is projected on the tangent plane at the centre.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import KDTree

from cea.arrays import Floats, Ints
from cea.errors import ConvergenceError
from cea.location import cross, newton_step
from cea.surface import Surface
from cea.surface_points import SurfaceCells, SurfaceCoordinates, SurfacePoints, gauss_rule

_STRAIGHT = 1e-8
"""Distance of an edge from its chord, relative to the cell of a, below which it is straight.

Traces of b are continuous across its edges: a break misplaced by d causes an integration error of
order d^2 inside the surfaces, and d at their boundaries.
"""
_SLIVER = 1e-14  # segments below this area, relative to their cell, are dropped
_POLYLINE = 16
"""Largest number of pieces of the polyline for an edge of b that is curved in a's coordinates."""
_CHUNK = 10_000  # pairs of cells per chunk
_NEWTON = 1e-9
"""Newton step, relative to the cell, that ends the iteration; the error is its square."""
_MAX_ITERATIONS = 60
_SHORTEST = 2.0**-6  # damping factor below which continuation along a line stops
_FOLDED = 1e-8
"""Determinant of the deformation, relative to a power of its trace, that indicates a fold."""


def segment_points(a: Surface, b: Surface, points: int | None, reach: float) -> SurfacePoints:
    """Return Gauss points on a, with weights, on the common refinement of two surfaces.

    ``points`` is the number per direction in each segment; None: exact on flat interfaces for the
    degrees of both traces. The surfaces are within ``reach`` (m); parts of a without an opposite
    cell of b have no points. Raise ConvergenceError if a cell of b cannot be mapped to one of a.
    """
    sides = _Sides(a, a.cells, b, b.cells)
    pairs = sides.near(reach)
    parts = [(np.zeros(0, dtype=np.int64), np.zeros((0, a.dim - 1)), np.zeros(0))]
    if a.dim == 2 and len(pairs):
        parts.append(sides.intervals(pairs, points))
    for start in range(0, len(pairs), _CHUNK) if a.dim == 3 else ():
        crossing, straight = sides.crossing(pairs[start : start + _CHUNK])
        for pieces, chosen in ((1, straight), (_POLYLINE, ~straight)):
            some = crossing[chosen]
            if not len(some):
                continue
            owner, xi, weight = sides.polygons(some, points, pieces)
            kept = np.ones(len(owner), dtype=bool)
            if pieces > 1 and len(owner):
                on_a = sides.on_a(some[owner, 0], xi, weight)
                kept = sides.facing(on_a, some[owner, 1], reach)
            parts.append((some[owner[kept], 0], xi[kept], weight[kept]))
    cell, xi, weight = (np.concatenate(each) for each in zip(*parts, strict=True))
    return sides.on_a(cell, xi, weight)


@dataclass(frozen=True)
class _Sides:
    """Two surfaces and their cells. Pairs are cell numbers of a and b, shape (n, 2)."""

    a: Surface
    cells_a: SurfaceCells
    b: Surface
    cells_b: SurfaceCells

    def on_a(self, cell: Ints, xi: Floats, weight: Floats) -> SurfacePoints:
        """Return points in cells of a, given their xi and reference weights."""
        at = SurfaceCoordinates(self.cells_a.element[cell], xi)
        x, tangents = self.a.tangents(at.element, xi)
        area = np.linalg.norm(cross(tangents), axis=1)
        return SurfacePoints(at, x, self.a.normal(at), weight * area)

    def facing(self, points: SurfacePoints, cell: Ints, reach: float) -> NDArray[np.bool_]:
        """Return True for points inside their cells of b, or located elsewhere on b."""
        corners = self.cells_b.corners[cell]
        element = self.cells_b.element[cell]
        xi = _continued_coordinates(self.b, element, corners, points.x[:, None])
        edge = np.roll(corners, -1, axis=1) - corners
        arm = xi - corners
        turn = edge[..., 0] * arm[..., 1] - edge[..., 1] * arm[..., 0]
        facing = np.abs(np.sign(turn).sum(axis=1)) == turn.shape[1]
        beside = points[~facing]
        facing[~facing] = ~self.b.locate(beside.x, beside.normal, reach).missed
        return facing

    def near(self, reach: float) -> Ints:
        """Return pairs of facing cells whose bounding spheres come within reach."""
        a, b = self.a.bounds, self.b.bounds
        found = KDTree(b.centre).query_ball_point(a.centre, a.radius + b.radius.max() + reach)
        i = np.repeat(np.arange(len(found)), [len(f) for f in found])
        j = np.concatenate([np.asarray(f, dtype=np.int64) for f in found])
        apart = np.linalg.norm(a.centre[i] - b.centre[j], axis=1) - a.radius[i] - b.radius[j]
        normal_a, normal_b = (
            surface.normal(SurfaceCoordinates(cells.element, cells.corners.mean(axis=1)))
            for surface, cells in ((self.a, self.cells_a), (self.b, self.cells_b))
        )
        facing = np.einsum("ij,ij->i", normal_a[i], normal_b[j]) < 0
        return np.column_stack([i, j])[(apart <= reach) & facing]

    def outlines_in_a(self, pairs: Ints, pieces: int) -> Floats:
        """Return outlines of cells of b in the extrapolated coordinates of cells of a."""
        x = _outlines(self.b, self.cells_b, pairs[:, 1], pieces)
        cells, own = self.cells_a, pairs[:, 0]
        return _continued_coordinates(self.a, cells.element[own], cells.corners[own], x)

    def intervals(self, pairs: Ints, points: int | None) -> tuple[Ints, Floats, Floats]:
        """Return Gauss points of the refinement of two curves: cell of a, xi, reference weight."""
        mapped = np.sort(self.outlines_in_a(pairs, 1)[..., 0], axis=1)
        own = np.sort(self.cells_a.corners[pairs[:, 0]][..., 0], axis=1)
        low = np.maximum(own[:, 0], mapped[:, 0])
        high = np.minimum(own[:, 1], mapped[:, 1])
        kept = high - low > _SLIVER * (own[:, 1] - own[:, 0])
        count = points or max(self.cells_a.degree, self.cells_b.degree) + 1
        ends = np.stack([low, high], axis=1)[kept, :, None]
        return _rule_on_cells(pairs[kept, 0], ends, count, simplex=False)

    def polygons(self, pairs: Ints, points: int | None, pieces: int) -> tuple[Ints, Floats, Floats]:
        """Return Gauss points of the refinement of two surfaces: pair, xi, reference weight."""
        degree = max(self.cells_a.degree, self.cells_b.degree)
        tensor = self.cells_a.tensor or self.cells_b.tensor
        own = self.cells_a.corners[pairs[:, 0]]
        smallest = np.ptp(own, axis=1).min(axis=1)
        other = _simplified(self.outlines_in_a(pairs, pieces), pieces, smallest)
        owner, overlap = _clip(own, other)
        on_triangles = points or (2 * degree if tensor else degree) + 1
        return _rule_on(owner, overlap, points or degree + 1, on_triangles)

    def crossing(self, pairs: Ints) -> tuple[Ints, NDArray[np.bool_]]:
        """Return pairs that may overlap, and whether the cell of b has straight edges there.

        Between samples an edge is assumed to leave their bounding box by at most half the largest
        second difference, four times the value of a parabola.
        """
        own = self.cells_a.corners[pairs[:, 0]]
        low, extent = own.min(axis=1)[:, None], np.ptp(own, axis=1)[:, None]
        edges = _edges((self.outlines_in_a(pairs, 4) - low) / extent, 4)
        chord = edges[:, :, -1:] - edges[:, :, :1]
        arm = edges[:, :, 1:-1] - edges[:, :, :1]
        off = np.abs(chord[..., 0] * arm[..., 1] - chord[..., 1] * arm[..., 0]).max(axis=2)
        straight = off <= _STRAIGHT * np.linalg.norm(chord[:, :, 0], axis=2)
        room = 0.5 * np.abs(np.diff(edges, 2, axis=2)).max(axis=(2, 3))[:, :, None]
        least, most = edges.min(axis=2) - room, edges.max(axis=2) + room
        touching = ((least < 1) & (most > 0)).all(axis=2)
        near = ((least.min(axis=1) < 1) & (most.max(axis=1) > 0)).all(axis=1)
        return pairs[near], (straight | ~touching).all(axis=1)[near]


def _outlines(surface: Surface, cells: SurfaceCells, numbers: Ints, pieces: int) -> Floats:
    """Return positions (m) along cell boundaries, each edge in ``pieces`` pieces, (n, m, dim)."""
    corners = cells.corners[numbers]
    t = np.arange(pieces)[:, None] / pieces
    edges = [
        corners[:, k, None] * (1 - t) + np.roll(corners, -1, axis=1)[:, k, None] * t
        for k in range(corners.shape[1])
    ]
    xi = np.concatenate(edges, axis=1)
    n, m = xi.shape[:2]
    at = SurfaceCoordinates(np.repeat(cells.element[numbers], m), xi.reshape(n * m, -1))
    return surface.position(at).reshape(n, m, -1)


def _edges(outlines: Floats, pieces: int) -> Floats:
    """Return the points of each edge of outlines (n, m, 2), (n, edges, pieces + 1, 2)."""
    edges = outlines.reshape(len(outlines), -1, pieces, 2)
    return np.concatenate([edges, np.roll(edges[:, :, :1], -1, axis=1)], axis=2)


def _simplified(outlines: Floats, pieces: int, extent: Floats) -> NDArray[np.object_]:
    """Return outlines (n, m, 2) as polygons without unnecessary points.

    Edges are simplified one by one, so that cells that share an edge keep the same points.
    """
    edges = _edges(outlines, pieces)
    count, tolerance = edges.shape[1], _STRAIGHT * np.repeat(extent, edges.shape[1])
    lines = shapely.linestrings(edges.reshape(-1, pieces + 1, 2))
    lines = shapely.simplify(lines, tolerance, preserve_topology=False)
    points, line = shapely.get_coordinates(lines, return_index=True)
    ends = np.append(line[1:] != line[:-1], True)
    ring = line // count
    return shapely.polygons(shapely.linearrings(points[~ends], indices=ring[~ends]))


def _clip(cells: Floats, other: NDArray[np.object_]) -> tuple[Ints, NDArray[np.object_]]:
    """Return overlaps of convex cells and polygons, in reference coordinates, without slivers."""
    own = shapely.polygons(cells)
    broken = ~shapely.is_valid(other)
    other[broken] = shapely.make_valid(other[broken])
    overlap = shapely.intersection(own, other)
    kept = shapely.area(overlap) > _SLIVER * shapely.area(own)
    return np.flatnonzero(kept), overlap[kept]


def _rule_on(
    owner: Ints, overlaps: NDArray[np.object_], on_boxes: int, on_triangles: int
) -> tuple[Ints, Floats, Floats]:
    """Return Gauss rules on overlaps, split in triangles unless boxes: owner, xi, weight."""
    bounds = shapely.bounds(overlaps)
    area = (bounds[:, 2:] - bounds[:, :2]).prod(axis=1)
    is_box = np.abs(shapely.area(overlaps) - area) <= 1e-13 * area
    boxes = bounds[is_box][:, [[0, 1], [2, 1], [0, 3]]]
    collections = shapely.constrained_delaunay_triangles(overlaps[~is_box])
    triangles, index = shapely.get_parts(collections, return_index=True)
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    parts = (
        _rule_on_cells(owner[is_box], boxes, on_boxes, simplex=False),
        _rule_on_cells(owner[~is_box][index], corners, on_triangles, simplex=True),
    )
    every, xi, weight = (np.concatenate(p) for p in zip(*parts, strict=True))
    return every, xi, weight


def _rule_on_cells(
    owner: Ints, corners: Floats, n: int, *, simplex: bool
) -> tuple[Ints, Floats, Floats]:
    """Return Gauss rules, n points per direction, on intervals, parallelograms or triangles.

    ``corners`` are three each, (m, 3, 2), or two ends; exact to total degree 2 n - 1 in triangles.
    """
    t, w = gauss_rule(n, corners.shape[2], simplex=simplex)
    at, extent = SurfaceCells(owner, corners, n, not simplex).coordinates(t)
    return at.element, at.xi, (extent[:, None] * w).ravel()


def _continued_coordinates(surface: Surface, element: Ints, corners: Floats, x: Floats) -> Floats:
    """Return coordinates of points projected on cells along the normals at the cell centres."""
    m = x.shape[1]
    middle = corners.mean(axis=1)
    low, high = corners.min(axis=1), corners.max(axis=1)
    normal = surface.normal(SurfaceCoordinates(element, middle))
    _, tangents = surface.tangents(element, middle)
    inverse = np.linalg.inv(np.concatenate([tangents, -normal[:, :, None]], axis=2))
    chart = _Lines(surface, element, middle, high - low, normal, inverse)
    cell = np.repeat(np.arange(len(element)), m)
    points = x.reshape(len(cell), -1)

    xi, met = chart.follow(cell, points)
    xi[~met] = chart.beyond(cell[~met], xi[~met], points[~met])
    lost = ~met & ((xi >= low[cell]) & (xi <= high[cell])).all(axis=1)
    xi = xi.reshape(*x.shape[:2], -1)
    if lost.any():
        raise ConvergenceError(
            f"{lost.sum()} of {len(points)} points cannot be mapped to cells of {surface.name}: "
            "some of its cells turn by a right angle or are folded; refine them",
            best=xi,
        )
    return xi


@dataclass(frozen=True)
class _Lines:
    """Straight lines from the centres of cells, projected along the normals at the centres."""

    surface: Surface
    element: Ints  # element of each cell, (n,)
    middle: Floats  # reference coordinates of its centre, (n, dim - 1)
    extent: Floats  # size of the cell in each coordinate, (n, dim - 1)
    normal: Floats  # unit normal at its centre, (n, dim)
    inverse: Floats  # inverse of [tangents, -normal] at the centre, (n, dim, dim)

    def follow(self, cell: Ints, x: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Continue along the line to each point while the polynomials are valid.

        Newton's method, damped by the monotonicity test with the simplified Newton step
        (Deuflhard, Newton Methods for Nonlinear Problems, 2011, section 3.3), stays on the line and
        never reaches coordinates beyond a fold or a full circle.
        """
        xi = self.middle[cell]
        met = np.zeros(len(xi), dtype=bool)
        active = np.arange(len(xi))
        damping = np.ones(len(xi))
        position, known = self.surface.tangents(self.element[cell], xi)
        step = newton_step(known, self.normal[cell], x - position)
        # Trial points far outside may overflow or meet a pole of a rational face.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for _ in range(_MAX_ITERATIONS):
                met[active] = self._size(cell[active], step[active]) <= _NEWTON
                done = active[met[active]]
                xi[done] += step[done]
                active = active[~met[active] & (damping[active] >= _SHORTEST)]
                if not active.size:
                    break
                at, factor = cell[active], damping[active]
                tried = xi[active] + factor[:, None] * step[active]
                position, tangents = self.surface.tangents(self.element[at], tried)
                rest = x[active] - position
                trusted = self._trusted(at, position, tangents)
                nearer = np.zeros(len(active), dtype=bool)
                again = newton_step(known[active[trusted]], self.normal[at[trusted]], rest[trusted])
                nearer[trusted] = self._size(at[trusted], again) <= (
                    1 - factor[trusted] / 4
                ) * self._size(at[trusted], step[active[trusted]])
                taken = active[nearer]
                xi[taken] = tried[nearer]
                known[taken] = tangents[nearer]
                step[taken] = newton_step(known[taken], self.normal[at[nearer]], rest[nearer])
                damping[active] = np.where(nearer, np.minimum(1.0, 2 * factor), factor / 2)
        return xi, met

    def beyond(self, cell: Ints, xi: Floats, x: Floats) -> Floats:
        """Continue from xi to the points in the tangent planes at the centres."""
        position, _ = self.surface.tangents(self.element[cell], xi)
        return xi + np.einsum("nij,nj->ni", self.inverse[cell, :-1], x - position)

    def _size(self, cell: Ints, step: Floats) -> Floats:
        """Return the largest component of a step, relative to the cell."""
        return np.abs(step / self.extent[cell]).max(axis=1)

    def _trusted(self, cell: Ints, position: Floats, tangents: Floats) -> NDArray[np.bool_]:
        """Return True where tangents are not folded and turn by less than a right angle.

        The trace of a map in the plane is positive if its polar rotation is below a right angle.
        """
        trusted = np.isfinite(position).all(axis=1) & np.isfinite(tangents).all(axis=(1, 2))
        change = self.inverse[cell[trusted], :-1] @ tangents[trusted]
        trace = np.trace(change, axis1=1, axis2=2)
        folded = np.linalg.det(change) <= _FOLDED * trace ** change.shape[1]
        trusted[trusted] = ~folded & (trace > 0)
        return trusted
