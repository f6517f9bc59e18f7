"""The map of a face as its geometry gives it, before knots were inserted for the trial space.

On the face both are one map. Beyond its edges the polynomials of the outermost knot span go on, and
what they are of a span that was made tiny is lost in rounding: it grows with the distance, counted
in spans, to the power of the degree. The spans of the geometry are as large as the face allows.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from iga_cea.grids import outer_products, projected
from iga_cea.patch import PatchGeometry, homogeneous
from iga_cea.splines import basis_functions


@dataclass(frozen=True)
class FaceShape:
    """The map of a face of a patch that is not refined."""

    degrees: tuple[int, ...]  # degree along each of the remaining parameters, in axis order
    knots: tuple[Floats, ...]  # open knot vectors along them
    net: Floats  # control points (m) times weights, then weights, shape (functions, dim + 1)

    @classmethod
    def of(cls, geometry: PatchGeometry, axis: int, side: int) -> "FaceShape":
        """Cut a face from the geometry of a patch."""
        rest = [k for k in range(len(geometry.degrees)) if k != axis]
        net = np.take(homogeneous(geometry), -side, axis=axis)
        return cls(
            degrees=tuple(geometry.degrees[k] for k in rest),
            knots=tuple(np.asarray(geometry.knots[k], dtype=float) for k in rest),
            net=net.reshape(-1, net.shape[-1]),
        )

    def is_beyond(self, xi: Floats) -> NDArray[np.bool_]:
        """True for parameters beyond the edges of the face, shape (n,)."""
        ends = np.array([[knots[0], knots[-1]] for knots in self.knots])
        return np.asarray(((xi < ends[:, 0]) | (xi > ends[:, 1])).any(axis=1))

    def tangents(self, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        at, splines, slopes = tensor_splines(self.knots, self.degrees, xi, derivatives=True)
        return projected(np.stack([splines, *slopes], axis=1) @ self.net[at])


def tensor_splines(
    knots: tuple[Floats, ...], degrees: tuple[int, ...], xi: Floats, *, derivatives: bool
) -> tuple[Ints, Floats, list[Floats]]:
    """Splines of several parameters that do not vanish, at points of any place.

    Flat numbers (n, functions) in C order, values of that shape, and their derivatives along each
    parameter, of that shape each; none where they are not wanted.
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
            slopes = [outer_products(s, table[0]) for s in slopes] + [
                outer_products(values, table[1])
            ]
        values = outer_products(values, table[0])
    return number, values, slopes
