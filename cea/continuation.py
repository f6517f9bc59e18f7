"""Coordinates of points in the cells of a surface, continued beyond the cells.

A cell of the opposite surface may overlap a cell in part only, so that some of its corners have
coordinates beyond it. There the polynomials of the cell go on, which keeps parameter lines straight
in its coordinates. Far out they turn back or have no solution, and a corner would seem to lie on
the wrong side. There the tangent plane at the centre of the cell tells the side, and stands in for
polynomials that disagree with it.
"""

import numpy as np
from numpy.typing import NDArray

from cea.body import Floats, Ints, Surface, SurfaceCoordinates
from cea.errors import ConvergenceError

_NEWTON = 1e-9
"""Last step of Newton's method, relative to the cell; the error after it is its square."""
_MAX_ITERATIONS = 30
_MARGIN = 0.5
"""Width of the margin around a cell, relative to it, within which its polynomials are trusted."""


def continued_coordinates(surface: Surface, element: Ints, corners: Floats, x: Floats) -> Floats:
    """Project points on cells along the normals at their centres.

    Parameters
    ----------
    surface
        The surface.
    element
        Element of each cell, shape (n,).
    corners
        Reference coordinates of its corners, shape (n, corners, dim - 1).
    x
        Points for each cell (m), shape (n, m, dim).

    Returns
    -------
    ndarray
        Reference coordinates, inside or beyond the cells, shape (n, m, dim - 1).

    Raises
    ------
    ConvergenceError
        When a point that belongs inside its cell cannot be mapped.
    """
    m = x.shape[1]
    middle = corners.mean(axis=1)
    normal = surface.normal(SurfaceCoordinates(element, middle))
    centre, low, high, direction = (
        np.repeat(each, m, axis=0)
        for each in (middle, corners.min(axis=1), corners.max(axis=1), normal)
    )
    element = np.repeat(element, m)
    points = x.reshape(len(element), -1)

    by_plane = centre + _step(surface, element, centre, points, direction)
    extent = (high - low).max(axis=1)
    by_polynomials, met = _newton(surface, element, by_plane, points, direction, extent)
    side, told = (_side(xi, low, high) for xi in (by_polynomials, by_plane))
    margin = _MARGIN * (high - low)
    near = (_side(by_polynomials, low - margin, high + margin) == 0).all(axis=1)
    agree = met & (near | (side == told).all(axis=1))
    lost = ~agree & (told == 0).all(axis=1)
    xi = np.where(agree[:, None], by_polynomials, by_plane).reshape(*x.shape[:2], -1)
    if lost.any():
        raise ConvergenceError(
            f"{lost.sum()} of {len(points)} points of side b cannot be mapped to cells of side a",
            best=xi,
        )
    return xi


def _side(xi: Floats, low: Floats, high: Floats) -> Floats:
    """For each coordinate -1 below the cell, 0 in it, 1 above it."""
    return (xi > high).astype(float) - (xi < low)


def _newton(
    surface: Surface, element: Ints, start: Floats, x: Floats, direction: Floats, extent: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """Solve F(xi) - s d = x without keeping xi inside the cell; which converged comes second."""
    xi = start.copy()
    met = np.zeros(len(xi), dtype=bool)
    active = np.arange(len(xi))
    # What diverges overflows, or meets a pole of a rational face, before it is given up.
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for _ in range(_MAX_ITERATIONS):
            if not active.size:
                break
            step = _step(surface, element[active], xi[active], x[active], direction[active])
            xi[active] += step
            met[active] = np.abs(step).max(axis=1) <= _NEWTON * extent[active]
            active = active[~met[active] & np.isfinite(step).all(axis=1)]
    return xi, met


def _step(surface: Surface, element: Ints, xi: Floats, x: Floats, direction: Floats) -> Floats:
    """Newton's step from xi; not a number where the tangents are none."""
    position, tangents = surface.tangents(element, xi)
    jacobian = np.concatenate([tangents, -direction[:, :, None]], axis=2)
    regular = np.isfinite(jacobian).all(axis=(1, 2))
    regular[regular] = np.linalg.det(jacobian[regular]) != 0
    step = np.full(xi.shape, np.nan)
    rest = (x - position)[regular, :, None]
    step[regular] = np.linalg.solve(jacobian[regular], rest)[:, :-1, 0]
    return step
