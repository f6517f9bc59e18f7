"""Supports, springs, pressures and forces on named surfaces of a body, and through all of it."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError, did_you_mean, require
from cea.supports.frames import Cartesian, Cylindrical, Frame
from cea.surface_points import SurfacePoints

_CARTESIAN = Cartesian()


@dataclass(frozen=True)
class Support:
    """Displacement components held on a surface, at zero or at given values.

    Parameters
    ----------
    surface
        Name of the surface.
    components
        Held components, numbers from 0 in the order of the frame: x, y, z; radial,
        circumferential, axial; normal. None holds every one.
    frame
        Frame of the components.
    value
        Displacement along each held component (m), in the order of the frame, or one for all; None
        holds all at zero. About an axis, radial and circumferential ones are not both held at
        values.
    """

    surface: str
    components: tuple[int, ...] | None = None
    frame: Frame = _CARTESIAN
    value: tuple[float, ...] | float | None = None

    def __post_init__(self) -> None:
        if self.components is not None:
            known = bool(self.components) and set(self.components) <= {0, 1, 2}
            require(known, "support.components", self.components, "one or more of 0, 1, 2")
        finite = self.value is None or bool(np.isfinite(self.value).all())
        require(finite, "support.value", self.value, "finite numbers (m)")

    @property
    def prescribes(self) -> bool:
        """Whether it holds anything elsewhere than at zero."""
        return self.value is not None and bool(np.any(self.value))

    def check(self, dim: int, field: str) -> None:
        """Refuse components, frames and values that do not suit the dimension of space."""
        self.frame.check(dim, field)
        size, held = self.frame.size(dim), self._held(dim)
        require(max(held) < size, f"{field}.components", self.components, f"below {size}")
        fits = not isinstance(self.value, tuple) or len(self.value) == len(held)
        allowed = f"a number (m) for each of the {len(held)} components held"
        require(fits, f"{field}.value", self.value, allowed)
        if self.prescribes and isinstance(self.frame, Cylindrical) and {0, 1} <= set(held):
            allowed = "zero where both radial and circumferential are held"
            raise InputError(f"{field}.value", self.value, allowed)

    def _held(self, dim: int) -> tuple[int, ...]:
        """Held components, in the order of the frame."""
        components = self.components
        if components is None:
            components = tuple(range(self.frame.size(dim)))
        return tuple(sorted(set(components)))

    def values(self, dim: int) -> Floats:
        """Displacement along each of the held directions (m), shape (held components,)."""
        held = self._held(dim)
        given = 0.0 if self.value is None else self.value
        return np.array(np.broadcast_to(np.asarray(given, dtype=float), len(held)))

    def directions(self, x: Floats, normal: Floats) -> Floats:
        """Held unit directions at points x (m) of the surface with outward unit normals."""
        return self.frame.directions(self._held(x.shape[1]), x, normal)


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
        values = np.asarray(self.stiffness, dtype=float)
        valid = bool(np.isfinite(values).all() and (values >= 0).all())
        require(valid, "spring.stiffness", self.stiffness, "finite and not negative (N/m^3)")

    def check(self, dim: int, field: str) -> None:
        """Refuse a spring of another dimension."""
        allowed = f"{dim} values (N/m^3), one for each component"
        require(len(self.stiffness) == dim, f"{field}.stiffness", self.stiffness, allowed)


@dataclass(frozen=True)
class Pressure:
    """Uniform pressure on a surface: traction ``-value * n`` with n the outward normal."""

    surface: str  # name of the surface
    value: float  # pressure (N/m^2), positive pushes on the body

    def __post_init__(self) -> None:
        finite = bool(np.isfinite(self.value))
        require(finite, "pressure.value", self.value, "a finite number (N/m^2)")

    def check(self, dim: int, field: str) -> None:
        """Accept any dimension."""

    def traction(self, points: SurfacePoints) -> Floats:
        """Force per area (N/m^2) at points of its surface, (n, dim)."""
        return -self.value * points.normal


@dataclass(frozen=True)
class Force:
    """A force on a body: spread evenly over a surface, or for each volume where none is named."""

    # components of the whole of it (N; N/m in the plane), or of that of a unit volume (N/m^3)
    value: tuple[float, ...]
    surface: str | None = None  # its name; None of a force on every part of the body

    def __post_init__(self) -> None:
        finite = bool(np.isfinite(np.asarray(self.value, dtype=float)).all())
        require(finite, "force.value", self.value, "finite numbers (N, or N/m^3)")

    def check(self, dim: int, field: str) -> None:
        """Refuse a force of another dimension."""
        require(len(self.value) == dim, f"{field}.value", self.value, f"{dim} components")

    def traction(self, points: SurfacePoints) -> Floats:
        """Force per area (N/m^2) at points of its surface, (n, dim)."""
        return np.tile(np.array(self.value) / points.weight.sum(), (len(points), 1))


def check_surface(name: str, known: Iterable[str], field: str) -> None:
    """Refuse a surface that does not exist."""
    names = list(known)
    if name not in names:
        there = ", ".join(names) or "none: no surface is named"
        raise InputError(field, name, f"one of {there}{did_you_mean(name, names)}")
