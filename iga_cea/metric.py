"""Map of a patch and its derivatives at Gauss points, on tensor grids.

With weights w_i of the control points, a function is R_i = w_i N_i / W. If the weights are products
of factors along the parameters (boxes, arcs, bodies of revolution), so are the rational functions,
and the map is a tensor product of them. Otherwise homogeneous coordinates are a tensor product,
N_i are the B-splines, and

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
"""Index, after those of the parameters, of the coefficient of function values."""

_PRODUCT = 4 * np.finfo(float).eps
"""Relative difference of weights from a product of factors treated as rounding."""


@dataclass(frozen=True)
class Metric:
    """Map and derivatives on a grid of points."""

    measure: Floats  # Jacobian, divided by W^2 if weights are no product, (n1, n2, n3)
    # gradients of the parameters, and g under :data:`VALUE` if weights are no product, each
    # (dim, n1, n2, n3)
    gradients: dict[int, Floats]
    x: Floats  # positions (m), (dim, n1, n2, n3)
    # gradient of an additional field, (components, dim, n1, n2, n3)
    field_gradient: Floats


def factors_of(weights: Floats) -> list[Floats] | None:
    """Return the factors of weights along each parameter; None if they are no product."""
    corner = weights[(0,) * weights.ndim]
    factors = []
    for axis in range(weights.ndim):
        line = [0] * weights.ndim
        line[axis] = slice(None)  # type: ignore[call-overload]
        factors.append(weights[tuple(line)] / corner)
    product = corner * reduce(np.multiply.outer, factors)
    return factors if np.all(np.abs(product - weights) <= _PRODUCT * weights) else None


def lines_of(patch: Patch, factors: Sequence[Floats] | None) -> list[Line]:
    """Return the bases along three parameters; the third is trivial in 2D."""
    lines = [
        Line.of(patch, axis, None if factors is None else factors[axis])
        for axis in range(patch.dim)
    ]
    return [*lines, *[Line.trivial()] * (3 - patch.dim)]


class Map:
    """Map of a patch at the Gauss points of a range of spans.

    ``rational`` tells whether the bases include the weights. ``across`` are values and slopes along
    the second and third parameter, (points, functions) each, ``field`` (n1, ..., components).
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
        # Coordinates relative to the centre: slopes lose digits far from the origin.
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
        """Return the metric at points of the first parameter."""

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
        """Return the Jacobian, and gradients of the parameters."""
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
