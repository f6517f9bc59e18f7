"""Coordinates of points in the cells of a surface, extrapolated beyond the cells.

A cell of the opposite surface may overlap a cell only partly, so that some of its corners lie
outside. Outside, the polynomials of the cell are extrapolated, which keeps parameter lines straight
in its coordinates. Far outside, the polynomials fold over or come full circle, and a corner would
appear on the wrong side. Coordinates are therefore continued along the straight line from the
centre of the cell to the point, as long as the tangents turn by less than a right angle. The rest
of the line, if any, is projected on the tangent plane at the centre.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.errors import ConvergenceError
from cea.location import newton_step
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates

_NEWTON = 1e-9
"""Newton step, relative to the cell, that ends the iteration; the error is its square."""
_MAX_ITERATIONS = 60
_SHORTEST = 2.0**-6  # damping factor below which continuation along a line stops
_FOLDED = 1e-8
"""Determinant of the deformation, relative to a power of its trace, that indicates a fold."""


def continued_coordinates(surface: Surface, element: Ints, corners: Floats, x: Floats) -> Floats:
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
