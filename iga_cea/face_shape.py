"""Map of a face on the knots of the geometry, before knot insertion for the trial space.

Both maps agree on the face. Beyond its edges the polynomials of the outermost knot span are
extrapolated, and rounding errors grow with the distance, in spans, to the power of the degree. The
spans of the geometry are therefore better than the smaller spans of the trial space.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from iga_cea.patch import PatchGeometry, homogeneous
from iga_cea.splines import basis_functions


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

    def is_beyond(self, xi: Floats) -> NDArray[np.bool_]:
        """Return True for parameters beyond the edges of the face, shape (n,)."""
        ends = np.array([[knots[0], knots[-1]] for knots in self.knots])
        return np.asarray(((xi < ends[:, 0]) | (xi > ends[:, 1])).any(axis=1))

    def tangents(self, xi: Floats) -> tuple[Floats, Floats]:
        """Return positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        at, splines, slopes = tensor_splines(self.knots, self.degrees, xi, derivatives=True)
        return projected(np.stack([splines, *slopes], axis=1) @ self.net[at])


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


def projected(homogeneous: Floats) -> tuple[Floats, Floats]:
    """Return positions and derivatives from those of w x and w: (w x)' = w' x + w x'."""
    weight = homogeneous[:, 0, -1]
    x = homogeneous[:, 0, :-1] / weight[:, None]
    turned = homogeneous[:, 1:, :-1] - homogeneous[:, 1:, -1:] * x[:, None]
    return x, (turned / weight[:, None, None]).swapaxes(1, 2)
