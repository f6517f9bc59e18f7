"""Supports, springs and pressures on named surfaces of a body."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cea.body import Floats
from cea.checks import check_surface
from cea.errors import InputError
from cea.supports.frames import Cartesian, Frame

_CARTESIAN = Cartesian()


@dataclass(frozen=True)
class Support:
    """Displacement components held at zero on a surface.

    Parameters
    ----------
    surface
        Name of the surface.
    components
        Held components, numbers from 0 in the order of the frame: x, y, z; radial,
        circumferential, axial; normal. None holds every one.
    frame
        Frame of the components.
    """

    surface: str
    components: tuple[int, ...] | None = None
    frame: Frame = _CARTESIAN

    def __post_init__(self) -> None:
        if self.components is not None and (
            not self.components or not set(self.components) <= {0, 1, 2}
        ):
            raise InputError("support.components", self.components, "one or more of 0, 1, 2")

    def check(self, dim: int, field: str) -> None:
        """Refuse components and frames that do not suit the dimension of space.

        Parameters
        ----------
        dim
            Dimension of space, 2 or 3.
        field
            Name of the support in messages.

        Raises
        ------
        InputError
            Naming components, axis or origin.
        """
        self.frame.check(dim, field)
        size = self.frame.size(dim)
        if self.components is not None and max(self.components) >= size:
            raise InputError(f"{field}.components", self.components, f"below {size}")

    def directions(self, x: Floats, normal: Floats) -> Floats:
        """Held unit directions, shape (held components, n, dim).

        Parameters
        ----------
        x
            Points of the surface (m), shape (n, dim).
        normal
            Outward unit normals there, shape (n, dim).
        """
        components = self.components
        if components is None:
            components = tuple(range(self.frame.size(x.shape[1])))
        return self.frame.directions(tuple(sorted(set(components))), x, normal)


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


def check_boundary(
    supports: Sequence[Support],
    springs: Sequence[Spring],
    pressures: Sequence[Pressure],
    surfaces: Iterable[str],
    dim: int,
    field: str,
) -> None:
    """Refuse supports, springs and pressures on unknown surfaces, or of another dimension."""
    known = list(surfaces)
    conditions: dict[str, Sequence[Support | Spring | Pressure]] = {
        "supports": supports,
        "springs": springs,
        "pressures": pressures,
    }
    for kind, items in conditions.items():
        for number, item in enumerate(items):
            check_surface(item.surface, known, f"{field}.{kind}[{number}].surface")
    for number, support in enumerate(supports):
        support.check(dim, f"{field}.supports[{number}]")
    for number, spring in enumerate(springs):
        if len(spring.stiffness) != dim:
            allowed = f"{dim} values (N/m^3), one for each component"
            raise InputError(f"{field}.springs[{number}].stiffness", spring.stiffness, allowed)
