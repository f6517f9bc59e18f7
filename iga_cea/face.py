"""One face of a patch: geometry, trace of the basis, and physical derivatives on it.

With open knots only the layer of control points on the face has a value there, and only that layer
and the one behind it a derivative. Both layers are all a face keeps.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cea.arrays import Floats, Ints
from iga_cea.botella import botella
from iga_cea.patch import Patch
from iga_cea.splines import basis_functions, greville

_SINGULAR = 1e-12
"""Jacobian taken for zero, relative to the power of its longest tangent."""

_BESIDE = 1e-6
"""How far from a collapsed edge limits are taken, relative to half the range of a parameter."""


@dataclass(frozen=True)
class PatchFace:
    """A face of a patch with its two outermost layers of control points.

    The outward parameter eta is the patch parameter across the face, turned and scaled so that the
    outermost spline has derivative 1 there; the next one then has -1. Physical derivatives and
    normals do not depend on its scale.

    Parameters
    ----------
    patch, axis, side
        Which face it is.
    degrees
        Degree along each of the remaining parameters, in axis order.
    knots
        Open knot vectors along them.
    control_points
        Control points (m) on the face and behind it, shape (n1, ..., 2, dim).
    weights
        Their weights, shape (n1, ..., 2).
    dofs
        Their scalar dofs, shape (n1, ..., 2).
    """

    patch: int
    axis: int
    side: int
    degrees: tuple[int, ...]
    knots: tuple[Floats, ...]
    control_points: Floats
    weights: Floats
    dofs: Ints

    @classmethod
    def of(cls, patch: Patch, dofs: Ints, end: tuple[int, int, int]) -> "PatchFace":
        """Cut a face from a patch.

        Parameters
        ----------
        patch
            The refined patch.
        dofs
            Scalar dofs of its control points, in their shape.
        end
            Number of the patch, axis and side.
        """
        number, axis, side = end
        layers = [0, 1] if side == 0 else [-1, -2]
        rest = [k for k in range(patch.dim) if k != axis]

        def outer(net: np.ndarray) -> np.ndarray:
            """Two outermost layers of a net, their axis behind the remaining ones."""
            taken = np.take(net, layers, axis=axis)
            return np.ascontiguousarray(np.moveaxis(taken, axis, patch.dim - 1))

        return cls(
            patch=number,
            axis=axis,
            side=side,
            degrees=tuple(patch.degrees[k] for k in rest),
            knots=tuple(patch.knots[k] for k in rest),
            control_points=outer(patch.control_points),
            weights=outer(patch.weights),
            dofs=outer(dofs),
        )

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return len(self.degrees) + 1

    @property
    def functions(self) -> int:
        """Number of functions with a value at a point of the face."""
        return int(np.prod([p + 1 for p in self.degrees]))

    @cached_property
    def breaks(self) -> tuple[Floats, ...]:
        """Ends of the non-empty knot spans along each parameter."""
        return tuple(np.unique(knots) for knots in self.knots)

    @cached_property
    def greville(self) -> tuple[Floats, ...]:
        """Greville abscissae along each parameter."""
        return tuple(greville(k, p) for k, p in zip(self.knots, self.degrees, strict=True))

    @cached_property
    def botella(self) -> tuple[Floats, ...]:
        """Parameters of the maxima of the B-splines along each parameter."""
        return tuple(botella(k, p) for k, p in zip(self.knots, self.degrees, strict=True))

    @cached_property
    def span_diameters(self) -> Floats:
        """Longest diagonal of each knot span (m), flat."""
        corners = grid_points(self.breaks)
        counts = [len(b) for b in self.breaks]
        x = self.tangents(corners)[0].reshape(*counts, self.dim)
        if self.dim == 2:
            return np.linalg.norm(np.diff(x, axis=0), axis=-1)
        rising = np.linalg.norm(x[1:, 1:] - x[:-1, :-1], axis=-1)
        falling = np.linalg.norm(x[1:, :-1] - x[:-1, 1:], axis=-1)
        return np.maximum(rising, falling).ravel()

    @cached_property
    def size(self) -> float:
        """Diameter of its largest knot span (m)."""
        return float(self.span_diameters.max())

    def trace(self, xi: Floats) -> tuple[Ints, Floats]:
        """Functions with a value on the face: their dofs and values, both (n, functions)."""
        at, splines, _ = self._splines(xi, derivatives=False)
        weighted = splines * self._weights[at, 0]
        return self._dofs[at, 0], weighted / weighted.sum(axis=1, keepdims=True)

    def tangents(self, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        at, splines, slopes = self._splines(xi, derivatives=True)
        values, derivatives = self._rational(at, splines, slopes)
        points = self._points[at, 0]
        x = np.einsum("na,nai->ni", values, points)
        return x, np.stack([np.einsum("na,nai->ni", d, points) for d in derivatives], axis=2)

    def normals(self, xi: Floats) -> tuple[Floats, Floats, Floats]:
        """Positions (n, dim), outward unit normals (n, dim), area per reference area (n,).

        The normal is J^-T of the outward reference normal, whatever the handedness of the patch.
        """
        _, _, x, jacobian = self._jacobian(xi)
        return x, *_normals(jacobian)

    def gradient(self, xi: Floats) -> tuple[Ints, Floats]:
        """Physical derivatives of the functions of both layers.

        Returns
        -------
        dofs : ndarray
            Shape (n, 2 * functions).
        gradient : ndarray
            Derivative along x_i in ``gradient[:, :, i]``, shape (n, 2 * functions, dim).
        """
        at, derivatives, _, jacobian = self._jacobian(xi)
        dofs = self._dofs[at].swapaxes(1, 2).reshape(len(at), -1)
        return dofs, derivatives @ np.linalg.inv(jacobian)

    @cached_property
    def _points(self) -> Floats:
        return self.control_points.reshape(-1, 2, self.dim)

    @cached_property
    def _weights(self) -> Floats:
        return self.weights.reshape(-1, 2)

    @cached_property
    def _dofs(self) -> Ints:
        return self.dofs.reshape(-1, 2)

    def _splines(self, xi: Floats, derivatives: bool) -> tuple[Ints, Floats, list[Floats]]:
        """Flat numbers, values and derivatives of the splines along the face, (n, functions)."""
        count = len(xi)
        number = np.zeros((count, 1), dtype=np.int64)
        values = np.ones((count, 1))
        slopes: list[Floats] = []
        for k, (knots, p) in enumerate(zip(self.knots, self.degrees, strict=True)):
            first, table = basis_functions(knots, p, xi[:, k], int(derivatives))
            along = first[:, None] + np.arange(p + 1)
            n = len(knots) - p - 1
            number = (number[:, :, None] * n + along[:, None]).reshape(count, -1)
            if derivatives:
                slopes = [_outer(s, table[0]) for s in slopes] + [_outer(values, table[1])]
            values = _outer(values, table[0])
        return number, values, slopes

    def _rational(
        self, at: Ints, splines: Floats, slopes: list[Floats]
    ) -> tuple[Floats, list[Floats]]:
        """Rational functions of the outer layer and their derivatives along the face."""
        weights = self._weights[at, 0]
        total = (splines * weights).sum(axis=1, keepdims=True)
        values = splines * weights / total
        scaled = [s * weights / total for s in slopes]
        return values, [s - values * s.sum(axis=1, keepdims=True) for s in scaled]

    def _jacobian(self, xi: Floats) -> tuple[Ints, Floats, Floats, Floats]:
        """Functions, their derivatives along (xi, eta), positions, and the Jacobian dx/d(xi, eta).

        Derivatives have shape (n, 2 * functions, dim): the outer layer first. On collapsed edges,
        where the Jacobian is singular, limits are taken from close by.
        """
        at, derivatives, x, jacobian = self._jacobian_at(xi)
        largest = np.linalg.norm(jacobian, axis=1).max(axis=1)
        singular = np.flatnonzero(np.abs(np.linalg.det(jacobian)) <= _SINGULAR * largest**self.dim)
        if len(singular):
            middle = np.array([(k[0] + k[-1]) / 2 for k in self.knots])
            beside = xi[singular] + _BESIDE * (middle - xi[singular])
            at[singular], derivatives[singular], _, jacobian[singular] = self._jacobian_at(beside)
        return at, derivatives, x, jacobian

    def _jacobian_at(self, xi: Floats) -> tuple[Ints, Floats, Floats, Floats]:
        at, splines, slopes = self._splines(xi, derivatives=True)
        values, along = self._rational(at, splines, slopes)
        weighted = splines[:, :, None] * self._weights[at]
        across = weighted / weighted[:, :, 0].sum(axis=1)[:, None, None]
        across[:, :, 1] *= -1
        across[:, :, 0] -= values * across.sum(axis=(1, 2))[:, None]

        layers = np.zeros((len(at), 2, self.functions, self.dim))
        layers[:, 0, :, :-1] = np.stack(along, axis=2)
        layers[..., -1] = across.swapaxes(1, 2)
        derivatives = layers.reshape(len(at), -1, self.dim)
        points = self._points[at].swapaxes(1, 2).reshape(len(at), -1, self.dim)
        x = np.einsum("na,nai->ni", values, self._points[at, 0])
        return at, derivatives, x, points.swapaxes(1, 2) @ derivatives


def grid_points(parameters: tuple[Floats, ...]) -> Floats:
    """Points of a tensor grid in C order, shape (n, number of parameters)."""
    return np.stack(np.meshgrid(*parameters, indexing="ij"), axis=-1).reshape(-1, len(parameters))


def _outer(a: Floats, b: Floats) -> Floats:
    return (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)


def _normals(jacobian: Floats) -> tuple[Floats, Floats]:
    """Outward unit normals and area per reference area (Nanson's formula)."""
    area_vector = np.abs(np.linalg.det(jacobian))[:, None] * np.linalg.inv(jacobian)[:, -1]
    area = np.linalg.norm(area_vector, axis=1)
    return area_vector / area[:, None], area
