"""Face of a patch: geometry, trace of the basis, and physical derivatives on it.

With open knots only the outermost layer of control points has values on the face, and only the two
outermost layers have derivatives. A face stores these two layers.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cea.arrays import Floats, Ints
from cea.location import cross
from iga_cea.face_shape import FaceShape, tensor_splines
from iga_cea.patch import Patch
from iga_cea.splines import botella, greville, grid_points

_SINGULAR = 1e-12
"""Jacobian, relative to a power of its longest tangent, below which it is singular."""

_BESIDE = 1e-6
"""Distance from a collapsed edge at which limits are evaluated, in half parameter ranges."""


@dataclass(frozen=True)
class PatchFace:
    """Face of a patch with its two outermost layers of control points.

    The outward parameter eta is the patch parameter normal to the face, oriented and scaled so that
    the outermost spline has derivative 1 on the face, and the next one -1. Physical derivatives and
    normals do not depend on this scale.
    """

    # identification of the face
    patch: int
    axis: int
    side: int
    degrees: tuple[int, ...]  # degree along each of the remaining parameters, in axis order
    knots: tuple[Floats, ...]  # open knot vectors along them
    control_points: Floats  # control points (m) on the face and behind it, shape (n1, ..., 2, dim)
    weights: Floats  # their weights, shape (n1, ..., 2)
    dofs: Ints  # their scalar dofs, shape (n1, ..., 2)
    shape: FaceShape  # its map, on the knots before knot insertion

    @classmethod
    def of(cls, patch: Patch, dofs: Ints, end: tuple[int, int, int]) -> "PatchFace":
        """Return the face at an end (patch, axis, side)."""
        number, axis, side = end
        layers = [0, 1] if side == 0 else [-1, -2]
        rest = [k for k in range(patch.dim) if k != axis]

        def outer(net: np.ndarray) -> np.ndarray:
            """Return the two outermost layers of a net, with their axis last."""
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
        """Number of functions that are nonzero at a point of the face."""
        return int(np.prod([p + 1 for p in self.degrees]))

    @cached_property
    def breaks(self) -> tuple[Floats, ...]:
        """Ends of the nonempty knot spans along each parameter."""
        return tuple(np.unique(knots) for knots in self.knots)

    def abscissae(self, kind: str) -> Floats:
        """Return a tensor grid of ``greville`` abscissae, or B-spline maxima (``botella``)."""
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
        """Return numbers and values of the functions on the face, both (n, functions)."""
        at, splines, _ = tensor_splines(self.knots, self.degrees, xi, derivatives=False)
        weighted = splines * self._weights[at, 0]
        weighted /= weighted.sum(axis=1, keepdims=True)
        return at, weighted

    def tangents(self, xi: Floats) -> tuple[Floats, Floats]:
        """Return positions (n, dim) and dx_i/dxi_j (n, dim, dim - 1), also beyond the edges."""
        return self.shape.tangents(xi)

    def normals(self, xi: Floats) -> tuple[Floats, Floats, Floats]:
        """Return positions (n, dim), outward unit normals (n, dim), area per area of xi (n,).

        By Nanson's formula det J J^-T maps the outward reference normal to the cross product of the
        tangents. On collapsed edges, where that vanishes, limits are evaluated nearby.
        """
        x, tangents = self.tangents(xi)
        if self.shape.affine is not None:
            flat = cross(self.shape.affine[1][None])
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
        """Sign for which the cross product of the tangents points outward, at the face's centre."""
        middle = np.array([[(b[len(b) // 2 - 1] + b[len(b) // 2]) / 2 for b in self.breaks]])
        _, _, _, jacobian = self._jacobian(middle)
        return float(np.sign(cross(jacobian[:, :, :-1])[0] @ jacobian[0, :, -1]))

    def gradient(self, xi: Floats) -> tuple[Ints, Floats]:
        """Return dofs of the functions of both layers, (n, 2 * functions), and their gradients.

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
    def outer_dofs(self) -> Ints:
        """Scalar dofs of the functions that are nonzero on the face, flat."""
        return self._dofs[:, 0].copy()

    def _rational(
        self, at: Ints, splines: Floats, slopes: list[Floats]
    ) -> tuple[Floats, list[Floats]]:
        """Return rational functions of the outer layer and their derivatives along the face."""
        weights = self._weights[at, 0]
        total = (splines * weights).sum(axis=1, keepdims=True)
        values = splines * weights / total
        scaled = [s * weights / total for s in slopes]
        return values, [s - values * s.sum(axis=1, keepdims=True) for s in scaled]

    def _jacobian(self, xi: Floats) -> tuple[Ints, Floats, Floats, Floats]:
        """Return functions, derivatives along (xi, eta), positions, and the Jacobian dx/d(xi, eta).

        Derivatives have shape (n, 2 * functions, dim), the outer layer first. On collapsed edges,
        where the Jacobian is singular, limits are evaluated nearby.
        """
        at, derivatives, x, jacobian = self._jacobian_at(xi)
        largest = np.linalg.norm(jacobian, axis=1).max(axis=1)
        singular = np.flatnonzero(np.abs(np.linalg.det(jacobian)) <= _SINGULAR * largest**self.dim)
        if len(singular):
            beside = self._beside(xi[singular])
            at[singular], derivatives[singular], _, jacobian[singular] = self._jacobian_at(beside)
        return at, derivatives, x, jacobian

    def _beside(self, xi: Floats) -> Floats:
        """Return parameters moved slightly towards the centre of the face."""
        middle = np.array([(k[0] + k[-1]) / 2 for k in self.knots])
        return xi + _BESIDE * (middle - xi)

    def _jacobian_at(self, xi: Floats) -> tuple[Ints, Floats, Floats, Floats]:
        at, splines, slopes = tensor_splines(self.knots, self.degrees, xi, derivatives=True)
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
