"""Supports, springs and pressures on named surfaces of a body."""

from dataclasses import dataclass

import numpy as np

from cea.errors import InputError


@dataclass(frozen=True)
class Support:
    """Displacement components held at zero on a surface.

    Parameters
    ----------
    surface
        Name of the surface.
    components
        Held components, 0, 1, 2 for x, y, z.
    """

    surface: str
    components: tuple[int, ...]

    def __post_init__(self) -> None:
        if not self.components or not set(self.components) <= {0, 1, 2}:
            raise InputError("support.components", self.components, "one or more of 0, 1, 2")


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
        if not np.isfinite(values).all() or (values < 0).any():
            raise InputError("spring.stiffness", self.stiffness, "finite and not negative (N/m^3)")


@dataclass(frozen=True)
class Pressure:
    """Uniform pressure on a surface: traction ``-value * n`` with n the outward normal.

    Parameters
    ----------
    surface
        Name of the surface.
    value
        Pressure (N/m^2), positive pushes on the body.
    """

    surface: str
    value: float

    def __post_init__(self) -> None:
        if not np.isfinite(self.value):
            raise InputError("pressure.value", self.value, "a finite number (N/m^2)")
