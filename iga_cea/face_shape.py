"""Map of a face on the knots of the geometry, before knot insertion for the trial space.

On the face the map does not depend on inserted knots. Beyond its edges the polynomials of the
outermost knot span are extrapolated, and rounding errors grow with the distance, in spans, to the
power of the degree. The spans of the geometry are therefore better than the smaller spans of the
trial space.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cea.arrays import Floats, Ints
from iga_cea.patch import PatchGeometry, homogeneous
from iga_cea.splines import basis_functions, greville, grid_points

_ROUNDING = 16 * np.finfo(float).eps
"""Relative distance of control points from an affine net that is treated as rounding."""


@dataclass(frozen=True)
class FaceShape:
    """Map of a face of the unrefined patch."""

    degrees: tuple[int, ...]  # degree along each of the remaining parameters, in axis order
    knots: tuple[Floats, ...]  # open knot vectors along them
    net: Floats  # control points (m) times weights, then weights, shape (functions, dim + 1)

    @classmethod
    def of(cls, geometry: PatchGeometry, axis: int, side: int) -> "FaceShape":
        """Return a face of the geometry of a patch."""
        rest = [k for k in range(len(geometry.degrees)) if k != axis]
        net = np.take(homogeneous(geometry), -side, axis=axis)
        return cls(
            degrees=tuple(geometry.degrees[k] for k in rest),
            knots=tuple(np.asarray(geometry.knots[k], dtype=float) for k in rest),
            net=net.reshape(-1, net.shape[-1]),
        )

    @cached_property
    def affine(self) -> tuple[Floats, Floats] | None:
        """Position (m) of its first corner, (dim,), and derivatives along xi, (dim, dim - 1).

        None if the map is not affine to rounding of the control points. A spline whose coefficients
        are the values of an affine map at the Greville abscissae is that map.
        """
        points, weights = self.net[:, :-1] / self.net[:, -1:], self.net[:, -1]
        if np.ptp(weights) > _ROUNDING * weights.max():
            return None
        along = [greville(k, p) for k, p in zip(self.knots, self.degrees, strict=True)]
        net = points.reshape(*map(len, along), -1)
        corner = net[(0,) * len(along)]
        ends = [net[tuple(row)] for row in -np.eye(len(along), dtype=int)]
        length = np.array([knots[-1] - knots[0] for knots in self.knots])
        edges = (np.array(ends) - corner).T / length
        flat = corner + (grid_points(tuple(along)) - self._first) @ edges.T
        off = np.abs(flat - points).max()
        return (corner, edges) if off <= _ROUNDING * np.abs(points).max() else None

    @property
    def _first(self) -> Floats:
        """Lower ends of the parameters."""
        return np.array([knots[0] for knots in self.knots])

    def tangents(self, xi: Floats) -> tuple[Floats, Floats]:
        """Return positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        if self.affine is not None:
            corner, edges = self.affine
            x = corner + (xi - self._first) @ edges.T
            return x, np.broadcast_to(edges, (len(xi), *edges.shape))
        at, splines, slopes = tensor_splines(self.knots, self.degrees, xi, derivatives=True)
        return _projected(np.stack([splines, *slopes], axis=1) @ self.net[at])


def tensor_splines(
    knots: tuple[Floats, ...], degrees: tuple[int, ...], xi: Floats, *, derivatives: bool
) -> tuple[Ints, Floats, list[Floats]]:
    """Return nonzero tensor-product splines at points, also outside the knots.

    The results are flat numbers in C order and values, both (n, functions), and a list of their
    derivatives along each parameter, empty if not requested.
    """
    count = len(xi)
    number = np.zeros((count, 1), dtype=np.int64)
    values = np.ones((count, 1))
    slopes: list[Floats] = []
    for k, (vector, p) in enumerate(zip(knots, degrees, strict=True)):
        first, table = basis_functions(vector, p, xi[:, k], slopes=derivatives)
        along = first[:, None] + np.arange(p + 1)
        n = len(vector) - p - 1
        number = (number[:, :, None] * n + along[:, None]).reshape(count, -1)
        if derivatives:
            slopes = [_products(s, table[0]) for s in slopes] + [_products(values, table[1])]
        values = _products(values, table[0])
    return number, values, slopes


def _products(a: Floats, b: Floats) -> Floats:
    """Return products of all columns of a and b, row by row, (n, columns of a and b)."""
    return (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)


def _projected(homogeneous: Floats) -> tuple[Floats, Floats]:
    """Return positions and derivatives from those of w x and w: (w x)' = w' x + w x'."""
    weight = homogeneous[:, 0, -1]
    x = homogeneous[:, 0, :-1] / weight[:, None]
    turned = homogeneous[:, 1:, :-1] - homogeneous[:, 1:, -1:] * x[:, None]
    return x, (turned / weight[:, None, None]).swapaxes(1, 2)
