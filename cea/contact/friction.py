"""Direction of the friction traction on side a."""

from dataclasses import dataclass

import numpy as np

from cea.body import Floats
from cea.errors import InputError
from cea.fields import Expression

_GRAZING = 1e-6


@dataclass(frozen=True)
class AlongVector:
    """The same direction everywhere: a vector, of which the tangential part counts.

    Parameters
    ----------
    vector
        Direction, any length but zero.
    """

    vector: tuple[float, ...]

    def at(self, x: Floats, normal: Floats) -> Floats:
        """Unit tangents (n, dim) at positions x (m) with unit normals."""
        return _tangent(np.broadcast_to(np.asarray(self.vector, dtype=float), x.shape), normal)


@dataclass(frozen=True)
class Circumferential:
    """Direction of positive rotation about an axis.

    Parameters
    ----------
    circumferential_about
        Axis of rotation, any length but zero.
    origin
        A point of the axis (m).
    """

    circumferential_about: tuple[float, float, float]
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def at(self, x: Floats, normal: Floats) -> Floats:
        """Unit tangents (n, dim) at positions x (m) with unit normals."""
        dim = x.shape[1]
        arm = np.zeros((len(x), 3))
        arm[:, :dim] = x - np.asarray(self.origin, dtype=float)[:dim]
        return _tangent(np.cross(self.circumferential_about, arm)[:, :dim], normal)


@dataclass(frozen=True)
class AlongField:
    """A direction that varies, by expressions; the part of it that is tangential counts.

    Parameters
    ----------
    field
        Expressions in the coordinates (:class:`cea.fields.Expression`), one for each component.
    """

    field: tuple[str, ...]

    def __post_init__(self) -> None:
        for text in self.field:
            Expression(text).check("field")

    def at(self, x: Floats, normal: Floats) -> Floats:
        """Unit tangents (n, dim) at positions x (m) with unit normals."""
        if len(self.field) != x.shape[1]:
            allowed = f"{x.shape[1]} expressions, one for each component"
            raise InputError("friction_direction_on_a.field", list(self.field), allowed)
        return _tangent(np.stack([Expression(text)(x) for text in self.field], axis=1), normal)


FrictionDirection = AlongVector | Circumferential | AlongField


@dataclass(frozen=True)
class Reversed:
    """Against another direction: what friction on a is to b, in the second half of a full pass.

    Parameters
    ----------
    direction
        The direction on side a.
    """

    direction: FrictionDirection

    def at(self, x: Floats, normal: Floats) -> Floats:
        """Unit tangents (n, dim) at positions x (m) with unit normals."""
        return -self.direction.at(x, normal)


def _tangent(direction: Floats, normal: Floats) -> Floats:
    along = np.einsum("ij,ij->i", direction, normal)
    tangent = direction - along[:, None] * normal
    length = np.linalg.norm(tangent, axis=1)
    if (length <= _GRAZING * np.linalg.norm(direction, axis=1)).any():
        worst = int(np.argmin(length))
        raise InputError(
            "friction_direction_on_a",
            direction[worst].tolist(),
            f"a direction with a part tangent to side a, whose normal here is {normal[worst]}",
        )
    return tangent / length[:, None]
