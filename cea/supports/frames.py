"""Frames in which supports name the components they hold."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError, require

_ON_AXIS = 1e-9
"""Distance from an axis at which directions about it lose sense, relative to the surface."""


class Frame(ABC):
    """Components that a support may name."""

    def size(self, dim: int) -> int:
        """Number of components in space of dimension ``dim``."""
        return dim

    def check(self, dim: int, field: str) -> None:
        """Refuse a frame that does not suit the dimension of space."""
        return

    @abstractmethod
    def directions(self, components: tuple[int, ...], x: Floats, normal: Floats) -> Floats:
        """Held unit directions at points with outward normals, shape (components, n, dim)."""


@dataclass(frozen=True)
class Cartesian(Frame):
    """Components x, y, z (x, y in the plane)."""

    def directions(self, components: tuple[int, ...], x: Floats, normal: Floats) -> Floats:
        """Held unit directions at points, shape (components, n, dim)."""
        axes = np.eye(x.shape[1])[list(components)]
        return np.broadcast_to(axes[:, None], (len(axes), *x.shape))


@dataclass(frozen=True)
class Cylindrical(Frame):
    """Components radial, circumferential, axial about an axis; the first two about a point in 2D.

    Parameters
    ----------
    origin
        A point of the axis (m); the origin of coordinates when empty.
    axis
        Direction of the axis, any length but zero; empty in 2D.
    """

    origin: tuple[float, ...] = ()
    axis: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        finite = bool(np.isfinite(self.origin).all())
        require(finite, "origin", self.origin, "finite coordinates (m)")
        real = not self.axis or bool(np.isfinite(self.axis).all() and np.any(self.axis))
        require(real, "axis", self.axis, "a finite vector that is not zero")

    def check(self, dim: int, field: str) -> None:
        """Refuse an axis or origin of another dimension than that of space."""
        allowed = "left out in the plane" if dim == 2 else "three numbers, the axis meant"
        fits = len(self.axis) == (0 if dim == 2 else 3)
        require(fits, f"{field}.axis", self.axis or None, allowed)
        fits = len(self.origin) in (0, dim)
        require(fits, f"{field}.origin", self.origin, f"{dim} coordinates (m)")

    def directions(self, components: tuple[int, ...], x: Floats, normal: Floats) -> Floats:
        """Held unit directions at points, shape (components, n, dim).

        Radial and circumferential together hold the plane across the axis, for which the same two
        directions serve everywhere; one alone is refused where a point lies on the axis.
        """
        dim = x.shape[1]
        axis = np.asarray(self.axis or (0.0, 0.0, 1.0), dtype=float)
        axis = axis / np.linalg.norm(axis)
        held: list[Floats] = []
        if {0, 1} <= set(components):
            # Rows beyond the first are orthogonal to the axis; in the plane all of it is held.
            across = np.linalg.svd(axis[None])[2][1:] if dim == 3 else np.eye(2)
            held.extend(across)
        elif {0, 1} & set(components):
            radial, circumferential = self._about(axis, x)
            held.append(radial if 0 in components else circumferential)
        if 2 in components:
            held.append(axis)
        return np.stack([np.broadcast_to(direction, x.shape) for direction in held])

    def _about(self, axis: Floats, x: Floats) -> tuple[Floats, Floats]:
        dim = x.shape[1]
        arm = np.zeros((len(x), 3))
        arm[:, :dim] = x - (np.asarray(self.origin, dtype=float) if self.origin else 0.0)
        arm -= (arm @ axis)[:, None] * axis
        distance = np.linalg.norm(arm, axis=1)
        if len(x) and distance.min() <= _ON_AXIS * max(np.ptp(x, axis=0).max(), distance.max()):
            raise InputError(
                "support.components",
                f"radial or circumferential at {x[distance.argmin()].tolist()}",
                "both or neither on a surface that meets the axis",
            )
        radial = arm / distance[:, None]
        return radial[:, :dim], np.cross(axis, radial)[:, :dim]


@dataclass(frozen=True)
class SurfaceNormal(Frame):
    """One component, along the outward normal of the surface: a roller."""

    def size(self, dim: int) -> int:
        """Number of components in space of dimension ``dim``."""
        return 1

    def directions(self, components: tuple[int, ...], x: Floats, normal: Floats) -> Floats:
        """Held unit directions at points, shape (1, n, dim)."""
        return normal[None]
