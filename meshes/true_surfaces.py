"""Surfaces of the shapes as they are, beside facets that interpolate them.

Facets of a round face leave it between their nodes, by h^2 / (8 R) where they are straight. What
contact takes for the gap between two bodies must be that of the shapes: closures of stiff contacts
are far smaller than the distance of facets.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from meshes.crowned import Crowned
from meshes.placement import Placement
from meshes.shapes import MeshFile, NurbsFile, Patches, Shape, VentilatedDisc, round_surfaces

_IN_PLACE = Placement()
_STEPS = 20
"""Steps of Newton's method, at most; crowned faces take three or four."""


@dataclass(frozen=True)
class Plane:
    """A flat face: facets lie on it."""

    def distance(self, x: Floats, direction: Floats) -> Floats:
        """Zero, shape (n,)."""
        return np.zeros(len(x))

    def normal(self, x: Floats, near: Floats) -> Floats:
        """Normals of the facets, shape (n, dim)."""
        return near


@dataclass(frozen=True)
class Cylinders:
    """Cylinders along the z axis, or circles in the plane; a point belongs to the nearest."""

    radius: float
    centres: Sequence[tuple[float, float]] = ((0.0, 0.0),)

    def distance(self, x: Floats, direction: Floats) -> Floats:
        """Root nearest to zero of |x + s d| = R across the axis, shape (n,)."""
        arm, aim = self._arms(x), direction[:, :2]
        square, middle = (aim**2).sum(axis=1), (arm * aim).sum(axis=1)
        length = np.hypot(arm[:, 0], arm[:, 1])
        beyond = (length - self.radius) * (length + self.radius)
        root = np.sqrt(np.maximum(middle**2 - square * beyond, 0.0))
        return -beyond / (middle + np.copysign(root, middle))

    def normal(self, x: Floats, near: Floats) -> Floats:
        """Along the radius, to the side of the given normals, shape (n, dim)."""
        found = np.zeros_like(x)
        found[:, :2] = self._arms(x)
        return _unit(found, near)

    def _arms(self, x: Floats) -> Floats:
        """From the nearest axis to each point, shape (n, 2)."""
        arms = x[:, None, :2] - np.asarray(self.centres)
        nearest = np.abs(np.hypot(arms[..., 0], arms[..., 1]) - self.radius).argmin(axis=1)
        return arms[np.arange(len(x)), nearest]


@dataclass(frozen=True)
class CrownedFace:
    """The crowned face of a shape."""

    shape: Crowned

    def distance(self, x: Floats, direction: Floats) -> Floats:
        """Where the line meets the face, by Newton's method, shape (n,)."""
        shape, axis = self.shape, self.shape.across
        level = shape.extent[axis][shape.at_high_end]
        distance = np.zeros(len(x))
        for _ in range(_STEPS):
            at = x + distance[:, None] * direction
            above = self._outwards * (at[:, axis] - level) + shape.depth(at)
            step = -above / np.einsum("ij,ij->i", self._gradient(at), direction)
            distance += step
            if np.abs(step).max(initial=0.0) <= np.finfo(float).eps * np.abs(x).max(initial=0.0):
                break
        return distance

    def normal(self, x: Floats, near: Floats) -> Floats:
        """Across the face, shape (n, dim)."""
        return _unit(self._gradient(x), near)

    @property
    def _outwards(self) -> float:
        return 1.0 if self.shape.at_high_end else -1.0

    def _gradient(self, x: Floats) -> Floats:
        """Gradient of the height above the face, shape (n, dim)."""
        gradient = self.shape.slope(x)
        gradient[:, self.shape.across] += self._outwards
        return gradient


@dataclass(frozen=True)
class Placed:
    """A surface of a shape that is put somewhere."""

    surface: Plane | Cylinders | CrownedFace
    placement: Placement

    def distance(self, x: Floats, direction: Floats) -> Floats:
        """Distance in the coordinates of the shape, which are Cartesian too, shape (n,)."""
        turned = self._rotation(x.shape[1])
        return self.surface.distance(self._back(x), direction @ turned)

    def normal(self, x: Floats, near: Floats) -> Floats:
        """Unit normals to the side of given ones, shape (n, dim)."""
        turned = self._rotation(x.shape[1])
        return self.surface.normal(self._back(x), near @ turned) @ turned.T

    def _back(self, x: Floats) -> Floats:
        """Points in the coordinates of the shape."""
        dim = x.shape[1]
        return (x - np.asarray(self.placement.translation)[:dim]) @ self._rotation(dim)

    def _rotation(self, dim: int) -> Floats:
        return self.placement.rotation[:dim, :dim]


def true_surfaces(shape: Shape, placement: Placement = _IN_PLACE) -> dict[str, Placed]:
    """Surfaces of a shape by name; none of a mesh file: what it interpolates is unknown."""
    return {name: Placed(each, placement) for name, each in _surfaces(shape).items()}


def _surfaces(shape: Shape) -> dict[str, Plane | Cylinders | CrownedFace]:
    """Surfaces in the coordinates of the shape."""
    if isinstance(shape, Crowned):
        return _surfaces(shape.base) | {shape.surface: CrownedFace(shape)}
    if isinstance(shape, MeshFile | NurbsFile | Patches):
        return {}
    found: dict[str, Plane | Cylinders | CrownedFace] = {n: Plane() for n in shape.surfaces}
    if isinstance(shape, VentilatedDisc):
        found |= {"bore": Cylinders(shape.bore), "rim": Cylinders(shape.outer_radius)}
        if shape.holes:
            found["holes"] = Cylinders(shape.hole_radius, shape.hole_centres)
    return found | {name: Cylinders(radius) for name, radius in round_surfaces(shape).items()}


def _unit(vectors: Floats, near: Floats) -> Floats:
    """Unit vectors of two directions each to the side of given ones, shape (n, dim)."""
    sign = np.sign(np.einsum("ij,ij->i", vectors, near))
    return vectors * (sign / np.linalg.norm(vectors, axis=1))[:, None]
