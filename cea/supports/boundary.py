"""Supports, springs, pressures and forces on named surfaces of a body, and volume forces."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf
from typing import Literal

import numpy as np

from cea.arrays import Floats, arms_about
from cea.errors import InputError, did_you_mean, require
from cea.surface_points import SurfacePoints

Component = Literal["x", "y", "z", "radial", "circumferential", "axial", "normal"]
_ABOUT_AXIS = ("radial", "circumferential", "axial")
_FRAMES = (("x", "y", "z"), _ABOUT_AXIS, ("normal",))
"""Components of each frame; the components of a support belong to one frame."""
_ON_AXIS = 1e-9
"""Distance from the axis, relative to the surface, below which directions are undefined."""


@dataclass(frozen=True)
class Support:
    """Displacement components prescribed on a surface; all of them if none is named.

    Parameters
    ----------
    surface
        Name of the surface.
    components
        Some of x, y, z; or of radial, circumferential, axial; or normal, a roller.
    axis
        Direction of the axis of radial, circumferential, axial; omitted in 2D.
    origin
        A point of the axis (m), by default the origin.
    value
        Prescribed displacement (m): a number for each named component (for x, y, z if none is
        named), or one for all; by default zero. Small motions are zero there.
    """

    surface: str
    components: tuple[Component, ...] = ()
    axis: tuple[float, float, float] | None = None
    origin: tuple[float, ...] | None = None
    value: float | tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        components, count = list(self.components), len(self.components)
        of_one = any(set(components) <= set(names) for names in _FRAMES)
        frames = "of one frame: " + ", or ".join(", ".join(names) for names in _FRAMES)
        require(of_one, "components", components, frames)
        for name, vector in (("axis", self.axis), ("origin", self.origin)):
            allowed = "left out unless components are radial, circumferential, axial"
            require(vector is None or self._about_axis, name, vector, allowed)
        real = self.axis is None or any(self.axis)
        require(real, "axis", self.axis, "a finite vector that is not zero")
        if isinstance(self.value, tuple) and count:
            require(len(self.value) == count, "value", self.value, f"one number (m), or {count}")
            allowed = "distinct if each has a value"
            require(len(set(components)) == count, "components", components, allowed)

    @property
    def _about_axis(self) -> bool:
        return not set(self.components).isdisjoint(_ABOUT_AXIS)

    @property
    def prescribes(self) -> bool:
        """Whether a prescribed displacement is nonzero."""
        return self.value is not None and bool(np.any(self.value))

    def check(self, dim: int, field: str) -> None:
        """Raise InputError for components, axes or values that do not fit the dimension."""
        if self._about_axis:
            allowed = "left out in 2D" if dim == 2 else "three numbers, the direction of the axis"
            require((self.axis is None) == (dim == 2), f"{field}.axis", self.axis, allowed)
            fits = self.origin is None or len(self.origin) == dim
            require(fits, f"{field}.origin", self.origin, f"{dim} coordinates (m)")
        beyond = {"z", "axial"} & set(self.components) if dim == 2 else set()
        allowed = "those of 2D: x, y, radial, circumferential, normal"
        require(not beyond, f"{field}.components", self.components, allowed)
        held = self._held(dim)
        fits = not isinstance(self.value, tuple) or len(self.value) == len(held)
        allowed = f"a number (m) for each of the {len(held)} components held"
        require(fits, f"{field}.value", self.value, allowed)
        if self.prescribes and {"radial", "circumferential"} <= set(held):
            allowed = "zero where both radial and circumferential are held"
            raise InputError(f"{field}.value", self.value, allowed)

    def _held(self, dim: int) -> tuple[str, ...]:
        """Return the constrained components, each once."""
        return tuple(dict.fromkeys(self.components or ("x", "y", "z")[:dim]))

    def values(self, dim: int) -> Floats:
        """Return the prescribed displacements (m), shape (components,)."""
        given = 0.0 if self.value is None else self.value
        return np.array(np.broadcast_to(np.asarray(given, dtype=float), len(self._held(dim))))

    def directions(self, x: Floats, normal: Floats) -> Floats:
        """Return the constrained unit directions at points x (m) with outward unit normals.

        Shape (components, n, dim). Radial and circumferential together constrain the plane normal
        to the axis, with the same two directions at all points; for one of them alone, raise
        InputError if a point lies on the axis.
        """
        dim = x.shape[1]
        held = self._held(dim)
        if held == ("normal",):
            return normal[None]
        found: list[Floats] = []
        axis, arm = arms_about(self.axis or (0.0, 0.0, 1.0), self.origin or (), x)
        both = {"radial", "circumferential"} <= set(held)
        if both:  # rows after the first are orthogonal to the axis
            found.extend(np.linalg.svd(axis[None])[2][1:, :dim])
        for name in held:
            if name == "axial":
                found.append(axis)
            elif name in ("x", "y", "z"):
                found.append(np.eye(dim)["xyz".index(name)])
            elif not both:
                distance = np.linalg.norm(arm, axis=1, keepdims=True)
                size = max(np.ptp(x, axis=0).max(), distance.max()) if len(x) else 0.0
                if len(x) and distance.min() <= _ON_AXIS * size:
                    value = f"radial or circumferential at {x[distance.argmin()].tolist()}"
                    allowed = "both or neither on a surface that meets the axis"
                    raise InputError("support.components", value, allowed)
                turned = np.cross(axis, arm) if name == "circumferential" else arm
                found.append((turned / distance)[:, :dim])
        return np.stack([np.broadcast_to(direction, x.shape) for direction in found])


@dataclass(frozen=True)
class Spring:
    """Elastic foundation on a surface: traction ``-stiffness * u`` by component.

    Parameters
    ----------
    surface
        Name of the surface.
    stiffness
        Stiffness per area of each component (N/m^3); equal entries make it isotropic.
    """

    surface: str
    stiffness: tuple[float, ...]

    def __post_init__(self) -> None:
        valid = all(0 <= value < inf for value in self.stiffness)
        require(valid, "spring.stiffness", self.stiffness, "finite and not negative (N/m^3)")

    def check(self, dim: int, field: str) -> None:
        """Raise InputError if the number of components is not ``dim``."""
        allowed = f"{dim} values (N/m^3), one for each component"
        require(len(self.stiffness) == dim, f"{field}.stiffness", self.stiffness, allowed)


@dataclass(frozen=True)
class Pressure:
    """Uniform pressure on a surface: traction ``-value * n`` with n the outward normal."""

    surface: str  # name of the surface
    value: float  # pressure (N/m^2), positive pushes on the body

    def check(self, dim: int, field: str) -> None:
        """Do nothing: a pressure fits any dimension."""

    def traction(self, points: SurfacePoints) -> Floats:
        """Return the force per area (N/m^2) at points of the surface, (n, dim)."""
        return -self.value * points.normal


@dataclass(frozen=True)
class Force:
    """A force, distributed uniformly over a surface, or a volume force if no surface is named."""

    # components of the total (N; N/m in 2D), or per volume (N/m^3)
    value: tuple[float, ...]
    surface: str | None = None  # name of the surface; None: a volume force

    def check(self, dim: int, field: str) -> None:
        """Raise InputError if the number of components is not ``dim``."""
        require(len(self.value) == dim, f"{field}.value", self.value, f"{dim} components")

    def traction(self, points: SurfacePoints) -> Floats:
        """Return the force per area (N/m^2) at points of the surface, (n, dim)."""
        return np.tile(np.array(self.value) / points.weight.sum(), (len(points), 1))


def check_surface(name: str, known: Iterable[str], field: str) -> None:
    """Raise InputError if a surface does not exist."""
    names = list(known)
    if name not in names:
        there = ", ".join(names) or "none: no surface is named"
        raise InputError(field, name, f"one of {there}{did_you_mean(name, names)}")
