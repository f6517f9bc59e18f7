"""Segments: Gauss points on the common refinement of two surface meshes.

Trace functions are smooth inside the cells of their surface only (facets of a mesh, knot spans of
a patch). A rule that integrates products of both traces must break at the cell boundaries of both.
Cells of side b are mapped along the normal of a into the reference coordinates of each cell of a
they may touch and clipped there, so that cells bounded by parameter lines of both sides, or by
straight lines on flat facets, are cut exactly; other edges are followed by polylines. Where the rim
of b is hollow, or crosses that of a at a flat angle, polylines reach a little beyond it: points
there face nothing and are dropped.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from cea.arrays import Floats, Ints
from cea.contact.cell_coordinates import continued_coordinates
from cea.contact.overlaps import SLIVER, STRAIGHT, clip, rule_on, simplified
from cea.location import cross
from cea.surface import Surface
from cea.surface_points import SurfaceCells, SurfaceCoordinates, SurfacePoints, gauss_rule

_POLYLINE = 16
"""Pieces, at most, that stand for an edge of b that is curved in the coordinates of a."""
_CHUNK = 10_000
"""Pairs of cells that are worked on at once."""


@dataclass(frozen=True)
class _Pairs:
    """Cells that may overlap: numbers of cells of a and b."""

    a: Ints
    b: Ints

    def __getitem__(self, rows: Any) -> "_Pairs":
        return _Pairs(self.a[rows], self.b[rows])


def segment_points(a: Surface, b: Surface, points: int | None, reach: float) -> SurfacePoints:
    """Gauss points on a, weights with its Jacobian, on the common refinement of two surfaces.

    So many points per direction in each segment; None takes what is exact for the degrees of both
    traces on flat interfaces. Surfaces are within a reach (m); parts of a that face no cell of b
    hold none. A cell of b that cannot be mapped to the coordinates of one of a ends in a
    ConvergenceError.
    """
    cells_a, cells_b = a.cells(), b.cells()
    pairs = _near(a, cells_a, b, cells_b, reach)
    none = a.gauss_points(1)[:0]
    if not len(pairs.a):
        return none
    if a.dim == 2:
        element, xi, weight = _intervals(a, cells_a, b, cells_b, pairs, points)
        return _on_surface(a, element, xi, weight)
    parts = [none]
    for start in range(0, len(pairs.a), _CHUNK):
        near, straight = _crossing(a, cells_a, b, cells_b, pairs[start : start + _CHUNK])
        for pieces, chosen in ((1, straight), (_POLYLINE, ~straight)):
            some = near[chosen]
            if not len(some.a):
                continue
            owner, xi, weight = _polygons(a, cells_a, b, cells_b, some, points, pieces)
            part = _on_surface(a, cells_a.element[some.a[owner]], xi, weight)
            if pieces > 1 and len(part):
                part = part[_facing(part, b, cells_b, some.b[owner], reach)]
            parts.append(part)
    return _joined(parts)


def _on_surface(a: Surface, element: Ints, xi: Floats, weight: Floats) -> SurfacePoints:
    """Points of reference weights on a."""
    at = SurfaceCoordinates(element, xi)
    x, tangents = a.tangents(element, xi)
    return SurfacePoints(at, x, a.normal(at), weight * np.linalg.norm(cross(tangents), axis=1))


def _joined(parts: list[SurfacePoints]) -> SurfacePoints:
    return SurfacePoints(
        SurfaceCoordinates(
            np.concatenate([p.at.element for p in parts]), np.concatenate([p.at.xi for p in parts])
        ),
        np.concatenate([p.x for p in parts]),
        np.concatenate([p.normal for p in parts]),
        np.concatenate([p.weight for p in parts]),
    )


def _facing(
    points: SurfacePoints, b: Surface, cells: SurfaceCells, numbers: Ints, reach: float
) -> NDArray[np.bool_]:
    """True for points within their cells of b, and for those others that are found on b."""
    corners = cells.corners[numbers]
    xi = continued_coordinates(b, cells.element[numbers], corners, points.x[:, None])
    edge = np.roll(corners, -1, axis=1) - corners
    arm = xi - corners
    turn = edge[..., 0] * arm[..., 1] - edge[..., 1] * arm[..., 0]
    facing = np.abs(np.sign(turn).sum(axis=1)) == turn.shape[1]
    facing[~facing] = ~b.locate(points.x[~facing], points.normal[~facing], reach).missed
    return facing


def _near(
    a: Surface, cells_a: SurfaceCells, b: Surface, cells_b: SurfaceCells, reach: float
) -> _Pairs:
    """Pairs of cells that face each other and whose bounding spheres come within reach."""
    (centre_a, radius_a), (centre_b, radius_b) = _spheres(a, cells_a), _spheres(b, cells_b)
    found = KDTree(centre_b).query_ball_point(centre_a, radius_a + radius_b.max() + reach)
    counts = np.array([len(f) for f in found])
    i = np.repeat(np.arange(len(found)), counts)
    j = np.concatenate([np.asarray(f, dtype=np.int64) for f in found])
    apart = np.linalg.norm(centre_a[i] - centre_b[j], axis=1)
    near = apart <= radius_a[i] + radius_b[j] + reach
    normal_a, normal_b = _middle_normals(a, cells_a), _middle_normals(b, cells_b)
    near &= np.einsum("ij,ij->i", normal_a[i], normal_b[j]) < 0
    return _Pairs(i, j)[near]


def _middle_normals(surface: Surface, cells: SurfaceCells) -> Floats:
    """Outward unit normals at the centres of cells, (n, dim)."""
    return surface.normal(SurfaceCoordinates(cells.element, cells.corners.mean(axis=1)))


def _spheres(surface: Surface, cells: SurfaceCells) -> tuple[Floats, Floats]:
    """Centres (m) and radii (m) of spheres that hold the cells; room for curved edges."""
    count, corners = cells.corners.shape[:2]
    element = np.repeat(cells.element, corners)
    x = surface.position(SurfaceCoordinates(element, cells.corners.reshape(count * corners, -1)))
    x = x.reshape(count, corners, -1)
    centre = x.mean(axis=1)
    return centre, 1.25 * np.linalg.norm(x - centre[:, None], axis=2).max(axis=1)


def _to_reference(a: Surface, cells_a: SurfaceCells, pairs: _Pairs, x: Floats) -> Floats:
    """Coordinates in the cells of a of points x (pairs, m, dim), continued beyond the cells."""
    return continued_coordinates(a, cells_a.element[pairs.a], cells_a.corners[pairs.a], x)


def _intervals(
    a: Surface,
    cells_a: SurfaceCells,
    b: Surface,
    cells_b: SurfaceCells,
    pairs: _Pairs,
    points: int | None,
) -> tuple[Ints, Floats, Floats]:
    """Common refinement of two curves: element, xi and reference weight of each Gauss point."""
    ends_b = _corner_positions(b, cells_b, pairs.b)
    mapped = np.sort(_to_reference(a, cells_a, pairs, ends_b)[..., 0], axis=1)
    own = np.sort(cells_a.corners[pairs.a][..., 0], axis=1)
    low = np.maximum(own[:, 0], mapped[:, 0])
    high = np.minimum(own[:, 1], mapped[:, 1])
    kept = high - low > SLIVER * (own[:, 1] - own[:, 0])
    count = points or max(cells_a.degree, cells_b.degree) + 1
    t, w = gauss_rule(count, 1, simplex=False)
    length = (high - low)[kept, None]
    xi = low[kept, None] + length * t[:, 0]
    element = np.repeat(cells_a.element[pairs.a[kept]], len(t))
    return element, xi.reshape(-1, 1), (length * w).ravel()


def _corner_positions(surface: Surface, cells: SurfaceCells, numbers: Ints) -> Floats:
    """Positions (m) of the corners of cells, (n, corners, dim)."""
    corners = cells.corners[numbers]
    n, k = corners.shape[:2]
    at = SurfaceCoordinates(np.repeat(cells.element[numbers], k), corners.reshape(n * k, -1))
    return surface.position(at).reshape(n, k, -1)


def _polygons(
    a: Surface,
    cells_a: SurfaceCells,
    b: Surface,
    cells_b: SurfaceCells,
    pairs: _Pairs,
    points: int | None,
    pieces: int,
) -> tuple[Ints, Floats, Floats]:
    """Common refinement of two surfaces: pair, xi and reference weight of each Gauss point."""
    degree = max(cells_a.degree, cells_b.degree)
    on_boxes = points or degree + 1
    on_triangles = points or (2 * degree if cells_a.tensor or cells_b.tensor else degree) + 1
    outline = _to_reference(a, cells_a, pairs, _outlines(b, cells_b, pairs.b, pieces))
    own = cells_a.corners[pairs.a]
    owner, overlap = clip(own, simplified(outline, pieces, np.ptp(own, axis=1).min(axis=1)))
    return rule_on(owner, overlap, on_boxes, on_triangles)


def _outlines(surface: Surface, cells: SurfaceCells, numbers: Ints, pieces: int) -> Floats:
    """Positions (m) along the boundaries of cells, each edge in so many pieces, (n, m, dim)."""
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


def _crossing(
    a: Surface, cells_a: SurfaceCells, b: Surface, cells_b: SurfaceCells, pairs: _Pairs
) -> tuple[_Pairs, NDArray[np.bool_]]:
    """Pairs whose cells may overlap, and whether the cell of b has straight edges there.

    Between its samples an edge is taken to leave the box around them by half their largest second
    difference at most, four times what a parabola does.
    """
    outline = _to_reference(a, cells_a, pairs, _outlines(b, cells_b, pairs.b, 4))
    own = cells_a.corners[pairs.a]
    low, extent = own.min(axis=1)[:, None], np.ptp(own, axis=1)[:, None]
    outline = (outline - low) / extent
    edges = outline.reshape(len(outline), -1, 4, 2)
    edges = np.concatenate([edges, np.roll(edges[:, :, :1], -1, axis=1)], axis=2)
    chord = edges[:, :, -1:] - edges[:, :, :1]
    arm = edges[:, :, 1:-1] - edges[:, :, :1]
    off = np.abs(chord[..., 0] * arm[..., 1] - chord[..., 1] * arm[..., 0]).max(axis=2)
    straight = off <= STRAIGHT * np.linalg.norm(chord[:, :, 0], axis=2)
    room = 0.5 * np.abs(np.diff(edges, 2, axis=2)).max(axis=(2, 3))[:, :, None]
    least, most = edges.min(axis=2) - room, edges.max(axis=2) + room
    touching = ((least < 1) & (most > 0)).all(axis=2)
    near = ((least.min(axis=1) < 1) & (most.max(axis=1) > 0)).all(axis=1)
    return pairs[near], (straight | ~touching).all(axis=1)[near]
