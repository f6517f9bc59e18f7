"""What a scene says of displacements that are held, at zero or at given values."""

from dataclasses import dataclass
from typing import Literal

from cea.errors import InputError
from cea.supports.boundary import Support
from cea.supports.frames import Cartesian, Cylindrical, Frame, SurfaceNormal

Component = Literal["x", "y", "z", "radial", "circumferential", "axial", "normal"]


_CARTESIAN: tuple[Component, ...] = ("x", "y", "z")


_CYLINDRICAL: tuple[Component, ...] = ("radial", "circumferential", "axial")


_NORMAL: tuple[Component, ...] = ("normal",)


_COMPONENTS = (_CARTESIAN, _CYLINDRICAL, _NORMAL)
"""Components of each frame; a support names those of one."""


@dataclass(frozen=True)
class SupportSpec:
    """Displacement components held on a surface; every one when none is named.

    Parameters
    ----------
    surface
        Name of the surface.
    components
        Some of x, y, z; or of radial, circumferential, axial; or normal, a roller.
    axis
        Direction of the axis of radial, circumferential, axial; left out in 2D.
    origin
        A point of it (m), by default the origin.
    value
        Displacement (m) at which they are held: a number for each component named (for x, y, z
        where none is), or one for all; by default zero. Small motions are held at zero.
    """

    surface: str
    components: tuple[Component, ...] = ()
    axis: tuple[float, float, float] | None = None
    origin: tuple[float, ...] | None = None
    value: float | tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if not any(set(self.components) <= set(names) for names in _COMPONENTS):
            allowed = "of one frame: " + ", or ".join(", ".join(names) for names in _COMPONENTS)
            raise InputError("components", list(self.components), allowed)
        for name, value in (("axis", self.axis), ("origin", self.origin)):
            if value is not None and not self._cylindrical:
                allowed = "left out beside components other than radial, circumferential, axial"
                raise InputError(name, list(value), allowed)
        self._check_value()

    def _check_value(self) -> None:
        """Refuse another number of values than components."""
        count = len(self.components)
        if isinstance(self.value, tuple) and count:
            if len(self.value) != count:
                raise InputError("value", list(self.value), f"one number (m), or {count}")
            if len(set(self.components)) != count:
                allowed = "each once where each has a value"
                raise InputError("components", list(self.components), allowed)
        self.support()

    @property
    def _cylindrical(self) -> bool:
        return bool(set(self.components) & set(_CYLINDRICAL))

    def support(self) -> Support:
        """The support as backends take it."""
        if not self.components:
            return Support(self.surface, value=self.value)
        names = next(names for names in _COMPONENTS if self.components[0] in names)
        numbers = tuple(names.index(component) for component in self.components)
        value = self.value
        if isinstance(value, tuple):
            value = tuple(each for _, each in sorted(zip(numbers, value, strict=True)))
        frame: Frame = Cartesian() if names == _CARTESIAN else SurfaceNormal()
        if self._cylindrical:
            frame = Cylindrical(self.origin or (), self.axis or ())
        return Support(self.surface, numbers, frame, value)
