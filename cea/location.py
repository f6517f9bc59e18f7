"""Point location on a curved surface along given directions: clamped Newton on candidates.

For a point x with direction d and a surface element with position F(xi), solve
F(xi) - s d = x for xi and the signed distance s, xi kept inside the element. What is left of the
residual is the distance by which the line misses the element.
"""

from typing import Protocol

import numpy as np

from cea.arrays import Floats, Ints
from cea.surface import Location, Status, SurfaceCoordinates

TOLERANCE = 1e-8
"""Default miss allowed, relative to the local mesh size."""

_MAX_ITERATIONS = 40
_CHUNK = 200_000


class Chart(Protocol):
    """Surface elements as point location sees them."""

    @property
    def dim(self) -> int:
        """Dimension of space."""
        ...

    def candidates(self, x: Floats, reach: float) -> tuple[Ints, Ints, Floats]:
        """Pairs worth trying: point numbers, elements, starting xi (n_pairs, dim - 1).

        Every element that holds the answer for a point within ``reach`` must be among them.
        """
        ...

    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        ...

    def clamp(self, element: Ints, xi: Floats) -> Floats:
        """Nearest reference coordinates inside the element, (n, dim - 1)."""
        ...

    def on_edge(self, element: Ints, xi: Floats, tolerance: float) -> np.ndarray:
        """True where xi lies on the boundary of the element, within a reference tolerance."""
        ...

    def size(self, element: Ints) -> Floats:
        """Local mesh size (m) of each element, (n,)."""
        ...


def cross(tangents: Floats) -> Floats:
    """Normal with the length of the area element: t1 x t2 in 3D, (t_y, -t_x) in 2D, (n, dim)."""
    if tangents.shape[1] == 2:
        t = tangents[:, :, 0]
        return np.column_stack([t[:, 1], -t[:, 0]])
    return np.cross(tangents[:, :, 0], tangents[:, :, 1])


def locate_along(
    chart: Chart, x: Floats, direction: Floats, reach: float, tolerance: float = TOLERANCE
) -> Location:
    """Locate points on a surface along directions.

    Parameters
    ----------
    chart
        The surface.
    x
        Points (m), shape (n, dim).
    direction
        Unit directions, shape (n, dim).
    reach
        Largest distance (m) along the direction, either way.
    tolerance
        Miss allowed, relative to the local mesh size.

    Returns
    -------
    Location
        One entry per point. Of several hits the nearest along the direction wins, then the lowest
        element; of several misses the smallest.
    """
    x = np.ascontiguousarray(x, dtype=float)
    direction = np.ascontiguousarray(direction, dtype=float)
    parts = [
        _locate_chunk(chart, x[i : i + _CHUNK], direction[i : i + _CHUNK], reach, tolerance)
        for i in range(0, max(len(x), 1), _CHUNK)
    ]
    return Location(
        at=SurfaceCoordinates(
            np.concatenate([p.at.element for p in parts]), np.concatenate([p.at.xi for p in parts])
        ),
        distance=np.concatenate([p.distance for p in parts]),
        miss=np.concatenate([p.miss for p in parts]),
        status=np.concatenate([p.status for p in parts]),
        tolerance=tolerance,
    )


def _locate_chunk(
    chart: Chart, x: Floats, direction: Floats, reach: float, tolerance: float
) -> Location:
    point, element, xi = chart.candidates(x, reach)
    xi, distance, miss = _newton(chart, element, xi, x[point], direction[point], tolerance)
    relative = miss / chart.size(element)
    hit = (relative <= tolerance) & (np.abs(distance) <= reach)

    # Hits before misses; hits by distance, rounded so that one edge seen from two elements ties.
    rank = np.where(hit, np.round(np.abs(distance) / reach, 10), relative)
    order = np.lexsort((element, rank, ~hit, point))
    found, first = np.unique(point[order], return_index=True)
    best = order[first]

    n = len(x)
    out = Location(
        at=SurfaceCoordinates(np.full(n, -1, dtype=np.int64), np.zeros((n, chart.dim - 1))),
        distance=np.full(n, np.nan),
        miss=np.full(n, np.inf),
        status=np.full(n, Status.MISSED, dtype=np.int8),
        tolerance=tolerance,
    )
    out.at.element[found] = element[best]
    out.at.xi[found] = xi[best]
    out.distance[found] = distance[best]
    out.miss[found] = miss[best]
    edge = chart.on_edge(element[best], xi[best], 10 * tolerance)
    out.status[found] = np.where(
        hit[best], np.where(edge, Status.EDGE, Status.INSIDE), out.status[found]
    )
    return out


def _newton(
    chart: Chart, element: Ints, xi: Floats, x: Floats, direction: Floats, tolerance: float
) -> tuple[Floats, Floats, Floats]:
    """Clamped Newton on every pair at once; pairs whose xi no longer moves drop out."""
    xi = chart.clamp(element, xi)
    active = np.arange(len(element))
    size = chart.size(element)
    for _ in range(_MAX_ITERATIONS):
        if not active.size:
            break
        e, d = element[active], direction[active]
        position, tangents = chart.tangents(e, xi[active])
        jacobian = np.concatenate([tangents, -d[:, :, None]], axis=2)
        step = _solve_or_project(jacobian, x[active] - position, size[active])
        moved = chart.clamp(e, xi[active] + step[:, :-1])
        change = np.abs(moved - xi[active]).max(axis=1)
        xi[active] = moved
        active = active[change > 1e-3 * tolerance]
    position, _ = chart.tangents(element, xi)
    offset = position - x
    distance = np.einsum("ij,ij->i", offset, direction)
    miss = np.linalg.norm(offset - distance[:, None] * direction, axis=1)
    return xi, distance, miss


def _solve_or_project(jacobian: Floats, rhs: Floats, size: Floats) -> Floats:
    """Solve the small systems; where the line grazes the surface, take the least-squares step."""
    scaled = jacobian.copy()
    scaled[:, :, -1] *= size[:, None]
    volume = np.abs(np.linalg.det(scaled))
    bound = np.prod(np.linalg.norm(scaled, axis=1), axis=1)
    regular = volume > 1e-10 * bound
    step = np.zeros(rhs.shape)
    if regular.any():
        step[regular] = np.linalg.solve(jacobian[regular], rhs[regular, :, None])[..., 0]
    if not regular.all():
        inverse = np.linalg.pinv(scaled[~regular], rcond=1e-8)
        step[~regular] = np.einsum("nij,nj->ni", inverse, rhs[~regular])
        step[~regular, -1] *= size[~regular]
    return step
