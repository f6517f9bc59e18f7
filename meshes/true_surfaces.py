"""Exact surfaces of the shapes, which facets only interpolate.

Facets of a round face deviate from it between their nodes, straight ones by h^2 / (8 R). Contact
must use the gap between the exact surfaces: closures of stiff contacts are far smaller than the
deviation of facets.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from meshes.crowned import Crowned
from meshes.placement import IN_PLACE, Placement
from meshes.shapes import MeshFile, NurbsFile, Patches, Shape, VentilatedDisc, round_surfaces

Height = Callable[[Floats], tuple[Floats, Floats]]
"""Function of points (n, dim): height above a surface (n,), and its gradient (n, dim)."""

_STEPS = 20
"""Largest number of Newton steps; three or four are usual."""


@dataclass(frozen=True)
class TrueSurface:
    """Placed surface on which ``height`` is zero; None if it is flat, so that facets lie on it."""

    height: Height | None
    placement: Placement

    def distance(self, x: Floats, direction: Floats) -> Floats:
        """Distance along lines to the surface, by Newton's method, shape (n,)."""
        distance = np.zeros(len(x))
        if self.height is None:
            return distance
        rotation = self._rotation(x)
        start, aim = self._back(x), direction @ rotation
        for _ in range(_STEPS):
            height, gradient = self.height(start + distance[:, None] * aim)
            step = -height / np.einsum("ij,ij->i", gradient, aim)
            distance += step
            if np.abs(step).max(initial=0.0) <= np.finfo(float).eps * np.abs(x).max(initial=0.0):
                break
        return distance

    def normal(self, x: Floats, near: Floats) -> Floats:
        """Unit normals, oriented as the normals ``near`` of facets, shape (n, dim)."""
        if self.height is None:
            return near
        gradient = self.height(self._back(x))[1] @ self._rotation(x).T
        sign = np.sign(np.einsum("ij,ij->i", gradient, near))
        return gradient * (sign / np.linalg.norm(gradient, axis=1))[:, None]

    def _back(self, x: Floats) -> Floats:
        """Points in the coordinates of the shape."""
        return (x - np.asarray(self.placement.translation)[: x.shape[1]]) @ self._rotation(x)

    def _rotation(self, x: Floats) -> Floats:
        return self.placement.rotation[: x.shape[1], : x.shape[1]]


def true_surfaces(shape: Shape, placement: Placement = IN_PLACE) -> dict[str, TrueSurface]:
    """Exact surfaces of a shape by name; none of mesh files, NURBS files and patches."""
    if isinstance(shape, MeshFile | NurbsFile | Patches):
        return {}
    base = shape.base if isinstance(shape, Crowned) else shape
    heights: dict[str, Height | None] = dict.fromkeys(shape.surfaces)
    heights |= {name: _cylinders(radius) for name, radius in round_surfaces(base).items()}
    if isinstance(shape, Crowned):
        heights[shape.surface] = shape.height
    if isinstance(shape, VentilatedDisc):
        heights |= {"bore": _cylinders(shape.bore), "rim": _cylinders(shape.outer_radius)}
        if shape.holes:
            heights["holes"] = _cylinders(shape.hole_radius, shape.hole_centres)
    return {name: TrueSurface(height, placement) for name, height in heights.items()}


def _cylinders(radius: float, centres: Sequence[tuple[float, float]] = ((0.0, 0.0),)) -> Height:
    """Height above cylinders along z, or circles in the plane; a point belongs to the nearest."""

    def height(x: Floats) -> tuple[Floats, Floats]:
        arms = x[:, None, :2] - np.asarray(centres)
        nearest = np.abs(np.hypot(arms[..., 0], arms[..., 1]) - radius).argmin(axis=1)
        arm = arms[np.arange(len(x)), nearest]
        length = np.hypot(arm[:, 0], arm[:, 1])
        gradient = np.zeros_like(x)
        gradient[:, :2] = arm / np.maximum(length, np.finfo(float).tiny)[:, None]
        return length - radius, gradient

    return height
