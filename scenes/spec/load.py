"""What a scene says of its loads."""

from dataclasses import dataclass

from cea.errors import InputError


@dataclass(frozen=True)
class LoadSpec:
    """A load: a pressure or a force on a surface, or a force on every part of a body.

    Parameters
    ----------
    surface
        The surface "body.surface".
    pressure
        Uniform pressure on it (N/m^2), positive pushes on the body.
    force
        Components of a force (N; N/m in the plane) that is spread evenly over it.
    body
        The body, given instead of a surface.
    body_force
        Components of a force for each volume of it (N/m^3).
    """

    surface: str | None = None
    pressure: float | None = None
    force: tuple[float, ...] | None = None
    body: str | None = None
    body_force: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if (self.surface is None) == (self.body is None):
            raise InputError("surface", self.surface, f"either surface or body ({self.body})")
        if self.body is None:
            if (self.pressure is None) == (self.force is None):
                allowed = f"either pressure or force, not both ({self.force}), on a surface"
                raise InputError("pressure", self.pressure, allowed)
            if self.body_force is not None:
                raise InputError("body_force", self.body_force, "left out on a surface")
        else:
            for name, value in (("pressure", self.pressure), ("force", self.force)):
                if value is not None:
                    raise InputError(name, value, "left out where body is given")
            if self.body_force is None:
                raise InputError("body_force", None, "needed where body is given")

    @property
    def on(self) -> str:
        """Name of the body it acts on."""
        return (self.surface or self.body or "").split(".")[0]
