"""One face of a patch: geometry, trace of the basis, and physical derivatives on it.

With open knots only the layer of control points on the face has a value there, and only that layer
and the one behind it a derivative. Both layers are all a face keeps.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cea.arrays import Floats, Ints
from cea.location import cross
from iga_cea.face_shape import FaceShape, tensor_splines
from iga_cea.grids import grid_points, projected
from iga_cea.patch import Patch
from iga_cea.splines import botella, greville

_SINGULAR = 1e-12
"""Jacobian taken for zero, relative to the power of its longest tangent."""

_ROUNDING = 16 * np.finfo(float).eps
"""Distance of control points from those of a flat face of even parameters that is rounding."""

_BESIDE = 1e-6
"""How far from a collapsed edge limits are taken, relative to half the range of a parameter."""


@dataclass(frozen=True)
class PatchFace:
    """A face of a patch with its two outermost layers of control points.

    The outward parameter eta is the patch parameter across the face, turned and scaled so that the
    outermost spline has derivative 1 there; the next one then has -1. Physical derivatives and
    normals do not depend on its scale.
    """

    # which face it is
    patch: int
    axis: int
    side: int
    degrees: tuple[int, ...]  # degree along each of the remaining parameters, in axis order
    knots: tuple[Floats, ...]  # open knot vectors along them
    control_points: Floats  # control points (m) on the face and behind it, shape (n1, ..., 2, dim)
    weights: Floats  # their weights, shape (n1, ..., 2)
    dofs: Ints  # their scalar dofs, shape (n1, ..., 2)
    shape: FaceShape  # its map before knots were inserted, which goes on beyond its edges

    @classmethod
    def of(cls, patch: Patch, dofs: Ints, end: tuple[int, int, int]) -> "PatchFace":
        """Cut a face from a patch."""
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
            shape=FaceShape.of(patch.geometry, axis, side),
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

    def abscissae(self, kind: str) -> Floats:
        """Tensor grid of ``greville`` abscissae, or of maxima of the B-splines (``botella``)."""
        along = {"greville": greville, "botella": botella}[kind]
        return grid_points(
            tuple(along(k, p) for k, p in zip(self.knots, self.degrees, strict=True))
        )

    @cached_property
    def size(self) -> float:
        """Longest diagonal of a knot span (m)."""
        counts = [len(b) for b in self.breaks]
        x = self.tangents(grid_points(self.breaks))[0].reshape(*counts, self.dim)
        if self.dim == 2:
            return float(np.linalg.norm(np.diff(x, axis=0), axis=-1).max())
        rising = np.linalg.norm(x[1:, 1:] - x[:-1, :-1], axis=-1)
        falling = np.linalg.norm(x[1:, :-1] - x[:-1, 1:], axis=-1)
        return float(np.maximum(rising, falling).max())

    def trace(self, xi: Floats) -> tuple[Ints, Floats]:
        """Functions with a value on the face: flat numbers and values, both (n, functions)."""
        at, splines, _ = self._splines(xi, derivatives=False)
        weighted = splines * self._outer_weights[at]
        weighted /= weighted.sum(axis=1, keepdims=True)
        return at, weighted

    @cached_property
    def affine(self) -> tuple[Floats, Floats] | None:
        """Position (m) of its first corner, (dim,), and derivatives along xi, (dim, dim - 1).

        None where they vary by more than the rounding of control points. A spline whose
        coefficients are those of an affine map, its values at the Greville abscissae, is that map.
        """
        net, weights = self.control_points[..., 0, :], self.weights[..., 0]
        if np.ptp(weights) > _ROUNDING * weights.max():
            return None
        corner = net[(0,) * (self.dim - 1)]
        ends = [net[tuple(-int(k == axis) for k in self._axes)] for axis in self._axes]
        length = np.array([knots[-1] - knots[0] for knots in self.knots])
        edges = (np.array(ends) - corner).T / length
        flat = corner + self._from_first_corner(self.abscissae("greville")) @ edges.T
        off = np.abs(flat - self._points[:, 0]).max()
        return (corner, edges) if off <= _ROUNDING * np.abs(net).max() else None

    @property
    def _axes(self) -> range:
        return range(self.dim - 1)

    def _from_first_corner(self, xi: Floats) -> Floats:
        """Parameters counted from the least."""
        return xi - np.array([knots[0] for knots in self.knots])

    def tangents(self, xi: Floats) -> tuple[Floats, Floats]:
        """Positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1), beyond its edges too."""
        if self.affine is not None:
            corner, edges = self.affine
            x = corner + self._from_first_corner(xi) @ edges.T
            return x, np.broadcast_to(edges, (len(xi), *edges.shape))
        beyond = self.shape.is_beyond(xi)
        if not beyond.any():
            return self._tangents(xi)
        if beyond.all():
            return self.shape.tangents(xi)
        x = np.empty((len(xi), self.dim))
        tangents = np.empty((len(xi), self.dim, self.dim - 1))
        x[~beyond], tangents[~beyond] = self._tangents(xi[~beyond])
        x[beyond], tangents[beyond] = self.shape.tangents(xi[beyond])
        return x, tangents

    def _tangents(self, xi: Floats) -> tuple[Floats, Floats]:
        at, splines, slopes = self._splines(xi, derivatives=True)
        return projected(np.stack([splines, *slopes], axis=1) @ self._homogeneous[at])

    def normals(self, xi: Floats) -> tuple[Floats, Floats, Floats]:
        """Positions (n, dim), outward unit normals (n, dim), area per reference area (n,).

        By Nanson's formula det J J^-T maps the outward reference normal to the cross product of
        the tangents. On collapsed edges, where that vanishes, limits are taken from close by.
        """
        x, tangents = self.tangents(xi)
        if self.affine is not None:
            flat = cross(self.affine[1][None])
            size = np.linalg.norm(flat)
            normal = np.broadcast_to(self._handedness * flat / size, x.shape)
            return x, normal, np.full(len(x), size)
        vector = cross(tangents)
        area = np.linalg.norm(vector, axis=1)
        longest = np.linalg.norm(tangents, axis=1).max(axis=1)
        singular = np.flatnonzero(area <= _SINGULAR * longest ** (self.dim - 1))
        if len(singular):
            vector[singular] = cross(self.tangents(self._beside(xi[singular]))[1])
            area[singular] = np.linalg.norm(vector[singular], axis=1)
        return x, self._handedness * vector / area[:, None], area

    @cached_property
    def _handedness(self) -> float:
        """Sign that turns the cross product of the tangents outward, from the middle of a face."""
        middle = np.array([[(b[len(b) // 2 - 1] + b[len(b) // 2]) / 2 for b in self.breaks]])
        _, _, _, jacobian = self._jacobian(middle)
        return float(np.sign(cross(jacobian[:, :, :-1])[0] @ jacobian[0, :, -1]))

    def gradient(self, xi: Floats) -> tuple[Ints, Floats]:
        """Dofs of the functions of both layers, (n, 2 * functions), and their gradients.

        The derivative along x_i is in ``[:, :, i]``, shape (n, 2 * functions, dim).
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

    @cached_property
    def _outer_weights(self) -> Floats:
        return self._weights[:, 0].copy()

    @cached_property
    def outer_dofs(self) -> Ints:
        """Scalar dofs of the functions with a value on the face, flat."""
        return self._dofs[:, 0].copy()

    @cached_property
    def _homogeneous(self) -> Floats:
        """Control points of the outer layer times their weights, and these, (n, dim + 1)."""
        weights = self._outer_weights[:, None]
        return np.hstack([self._points[:, 0] * weights, weights])

    def _splines(self, xi: Floats, derivatives: bool) -> tuple[Ints, Floats, list[Floats]]:
        """Flat numbers, values and derivatives of the splines along the face, (n, functions)."""
        return tensor_splines(self.knots, self.degrees, xi, derivatives=derivatives)

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
            beside = self._beside(xi[singular])
            at[singular], derivatives[singular], _, jacobian[singular] = self._jacobian_at(beside)
        return at, derivatives, x, jacobian

    def _beside(self, xi: Floats) -> Floats:
        """Parameters a little nearer to the middle."""
        middle = np.array([(k[0] + k[-1]) / 2 for k in self.knots])
        return xi + _BESIDE * (middle - xi)

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
