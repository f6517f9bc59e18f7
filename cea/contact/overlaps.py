"""Overlaps of convex cells with polygons in reference coordinates, and Gauss rules on them.

Overlaps that are boxes along the axes have a rule of products, others are cut into triangles.
"""

import numpy as np
import shapely
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.surface_points import gauss_rule

STRAIGHT = 1e-8
"""Distance of an edge from its chord, relative to the cell of a, that counts as straight.

Traces of b are continuous across its edges: a break off by d costs an integral d^2 inside the
surfaces, and d at their rims.
"""
SLIVER = 1e-14
"""Segments below this part of their cell's area are dropped."""


def simplified(outlines: Floats, pieces: int, extent: Floats) -> NDArray[np.object_]:
    """Outlines (n, m, 2) as polygons, each edge with no more of its pieces than it needs.

    Edge by edge, so that two cells that share one keep the same points of it.
    """
    n, m = outlines.shape[:2]
    count = m // pieces
    edges = outlines.reshape(n, count, pieces, 2)
    edges = np.concatenate([edges, np.roll(edges[:, :, :1], -1, axis=1)], axis=2)
    lines = shapely.simplify(
        shapely.linestrings(edges.reshape(n * count, pieces + 1, 2)),
        STRAIGHT * np.repeat(extent, count),
        preserve_topology=False,
    )
    points, line = shapely.get_coordinates(lines, return_index=True)
    ends = np.append(line[1:] != line[:-1], True)
    ring = line // count
    return shapely.polygons(shapely.linearrings(points[~ends], indices=ring[~ends]))


def clip(cells: Floats, other: NDArray[np.object_]) -> tuple[Ints, NDArray[np.object_]]:
    """Overlaps of convex cells with polygons, both in reference coordinates; slivers dropped."""
    own = shapely.polygons(cells)
    broken = ~shapely.is_valid(other)
    other[broken] = shapely.make_valid(other[broken])
    overlap = shapely.intersection(own, other)
    kept = shapely.area(overlap) > SLIVER * shapely.area(own)
    return np.flatnonzero(kept), overlap[kept]


def rule_on(
    owner: Ints, overlaps: NDArray[np.object_], on_boxes: int, on_triangles: int
) -> tuple[Ints, Floats, Floats]:
    """Gauss rules on overlaps: owner, coordinates and weight of each point."""
    boxes, is_box = _boxes(overlaps)
    parts = (
        _rule_on_boxes(owner[is_box], boxes, on_boxes),
        _rule_on_triangles(*_triangles(owner[~is_box], overlaps[~is_box]), on_triangles),
    )
    every, xi, weight = (np.concatenate(p) for p in zip(*parts, strict=True))
    return every, xi, weight


def _boxes(overlaps: NDArray[np.object_]) -> tuple[Floats, NDArray[np.bool_]]:
    """Bounds (n, 4) of the overlaps that are boxes along the axes, and which are."""
    bounds = shapely.bounds(overlaps)
    area = (bounds[:, 2] - bounds[:, 0]) * (bounds[:, 3] - bounds[:, 1])
    is_box = np.abs(shapely.area(overlaps) - area) <= 1e-13 * area
    return bounds[is_box], is_box


def _rule_on_boxes(owner: Ints, bounds: Floats, n: int) -> tuple[Ints, Floats, Floats]:
    unit, w = gauss_rule(n, 2, simplex=False)
    low, size = bounds[:, None, :2], (bounds[:, 2:] - bounds[:, :2])[:, None]
    xi = low + size * unit
    weight = size.prod(axis=2) * w
    return np.repeat(owner, n * n), xi.reshape(-1, 2), weight.ravel()


def _triangles(owner: Ints, overlaps: NDArray[np.object_]) -> tuple[Ints, Floats]:
    """Triangles (n, 3, 2) that fill overlaps, with the overlap's owner each."""
    collections = shapely.constrained_delaunay_triangles(overlaps)
    triangles, index = shapely.get_parts(collections, return_index=True)
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    return owner[index], corners


def _rule_on_triangles(owner: Ints, corners: Floats, n: int) -> tuple[Ints, Floats, Floats]:
    """Collapsed Gauss rule, n x n points, exact to total degree 2 n - 1."""
    t, w = gauss_rule(n, 2, simplex=True)
    sides = corners[:, 1:] - corners[:, :1]
    xi = corners[:, :1] + t @ sides
    twice_area = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    weight = twice_area[:, None] * w
    return np.repeat(owner, n * n), xi.reshape(-1, 2), weight.ravel()
