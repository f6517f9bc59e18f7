"""The map of a patch at its Gauss points, on tensor grids.

With the weights w_i of the control points, a function is R_i = w_i N_i / W. Where the weights are
a product of factors along the parameters (boxes, arcs, whatever is turned about an axis), so are
the rational functions, and the map is a tensor product of them. Otherwise the tensor product is
that of homogeneous coordinates, N_i are the B-splines, and

    grad R_i = w_i / W (sum_k D_k N_i grad xi_k + N_i g),    g = - sum_k W_k / W grad xi_k.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError
from iga_cea.lines import Line
from iga_cea.patch import Patch

VALUE = 3
"""Number, beside the parameters 0, 1, 2, of what multiplies the value of a function."""

_PRODUCT = 4 * np.finfo(float).eps
"""Difference of weights from a product of factors, relative."""


@dataclass(frozen=True)
class Metric:
    """The map on a grid of points."""

    measure: Floats  # jacobian, over W^2 where weights are no product, (n1, n2, n3)
    # gradients of the parameters, and g under :data:`VALUE` where weights are no product, each
    # (dim, n1, n2, n3)
    gradients: dict[int, Floats]
    x: Floats  # positions (m), (dim, n1, n2, n3)
    # gradient of the field that goes with the map, (components, dim, n1, n2, n3)
    field_gradient: Floats


def factors_of(weights: Floats) -> list[Floats] | None:
    """Factors of weights along each parameter; None where they are no product to rounding."""
    corner = weights[(0,) * weights.ndim]
    factors = []
    for axis in range(weights.ndim):
        line = [0] * weights.ndim
        line[axis] = slice(None)  # type: ignore[call-overload]
        factors.append(weights[tuple(line)] / corner)
    product = corner * reduce(np.multiply.outer, factors)
    return factors if np.all(np.abs(product - weights) <= _PRODUCT * weights) else None


def lines_of(patch: Patch, factors: Sequence[Floats] | None) -> list[Line]:
    """The three parameters of a patch, the third of the plane trivial."""
    lines = [
        Line.of(patch, axis, None if factors is None else factors[axis])
        for axis in range(patch.dim)
    ]
    return [*lines, *[Line.trivial()] * (3 - patch.dim)]


class Map:
    """The map of a patch at the Gauss points of some spans.

    Weights may be in the lines (``rational``); matrices of values and slopes along the second and
    the third parameter are (points, functions) each, coefficients of a field (n1, ..., components).
    """

    def __init__(
        self,
        patch: Patch,
        rational: bool,
        across: Sequence[tuple[Floats, Floats]],
        field: Floats | None,
        name: str,
    ) -> None:
        self._dim, self._rational, self._name = patch.dim, rational, name
        # Far from the origin slopes would lose digits.
        self._centre = patch.control_points.reshape(-1, patch.dim).mean(axis=0)
        net = patch.control_points - self._centre
        if field is not None:
            net = np.concatenate([net, field], axis=-1)
        if not rational:
            weights = patch.weights[..., None]
            net = np.concatenate([net * weights, weights], axis=-1)
        shape = (*patch.shape, *(1,) * (3 - patch.dim))
        net = np.ascontiguousarray(np.moveaxis(net, -1, 0)).reshape(-1, *shape)
        (b, db), (c, dc) = across
        plain = net @ c.T
        self._parts = [b @ plain, db @ plain]
        if self._dim == 3:
            self._parts.append(b @ (net @ dc.T))

    def at(self, values: Floats, slopes: Floats, functions: slice = slice(None)) -> Metric:
        """Metric at points of the first parameter."""

        def along(matrix: Floats, part: Floats) -> Floats:
            part = part[:, functions]
            flat = part.reshape(len(part), part.shape[1], -1)
            return (matrix @ flat).reshape(len(part), len(matrix), *part.shape[2:])

        x = along(values, self._parts[0])
        tangents = [along(slopes, self._parts[0])]
        tangents += [along(values, part) for part in self._parts[1:]]
        if not self._rational:
            W = x[-1]
            x = x[:-1] / W
            rates = [t[-1] / W for t in tangents]
            tangents = [t[:-1] / W - x * r for t, r in zip(tangents, rates, strict=True)]
        dim = self._dim
        measure, inverse = self._inverse([t[:dim] for t in tangents])
        rates_of_field = [t[dim:, None] * g for t, g in zip(tangents, inverse, strict=True)]
        field_gradient = np.sum(rates_of_field, axis=0)
        gradients = dict(enumerate(inverse))
        if not self._rational:
            measure /= W**2
            gradients[VALUE] = -sum(r * g for r, g in zip(rates, inverse, strict=True))
        x = x[:dim] + self._centre[:, None, None, None]
        return Metric(measure, gradients, x, field_gradient)

    def _inverse(self, tangents: list[Floats]) -> tuple[Floats, list[Floats]]:
        """Jacobian, and gradients of the parameters."""
        if self._dim == 2:
            (ax, ay), (bx, by) = tangents
            normals = [np.stack([by, -bx]), np.stack([-ay, ax])]
        else:
            a, b, c = tangents
            normals = [_cross(b, c), _cross(c, a), _cross(a, b)]
        determinant = sum(t * n for t, n in zip(tangents[0], normals[0], strict=True))
        if determinant.min() <= 0 <= determinant.max():
            raise InputError(self._name, "a folded map", "a Jacobian of one sign")
        for normal in normals:
            normal /= determinant
        return np.abs(determinant), normals


def _cross(a: Floats, b: Floats) -> Floats:
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
