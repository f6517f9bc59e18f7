"""Coulomb friction of steady sliding, and the direction of its traction on side a."""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats, arms_about, of_size_one
from cea.errors import InputError, require
from cea.expressions import Expression

_GRAZING = 1e-6


@dataclass(frozen=True)
class AlongVector:
    """Uniform direction: the tangential part of a vector.

    Parameters
    ----------
    vector
        Direction, any nonzero length.
    """

    vector: tuple[float, ...]

    def __post_init__(self) -> None:
        require(any(self.vector), "vector", self.vector, "finite numbers, not all zero")

    def check(self, dim: int, field: str) -> None:
        """Raise InputError if the vector has another dimension than space."""
        fits = len(self.vector) == dim
        require(fits, f"{field}.vector", self.vector, f"{dim} numbers, the dimension of space")

    def at(self, x: Floats) -> Floats:
        """Return vectors (n, dim) at positions x (m)."""
        return np.broadcast_to(of_size_one(self.vector), x.shape)


@dataclass(frozen=True)
class Circumferential:
    """Direction of positive rotation about an axis.

    Parameters
    ----------
    circumferential_about
        Axis of rotation, any nonzero length.
    origin
        A point of the axis (m).
    """

    circumferential_about: tuple[float, float, float]
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        axis = self.circumferential_about
        require(any(axis), "circumferential_about", axis, "finite numbers, not all zero")

    def check(self, dim: int, field: str) -> None:
        """Raise InputError in 2D for an axis that is not along z or an origin with z != 0."""
        axis, place = self.circumferential_about, f"{field}.circumferential_about"
        if dim == 2:
            require(not any(axis[:2]), place, axis, "an axis along z in the plane")
            require(not self.origin[2], f"{field}.origin", self.origin, "z = 0 in the plane")

    def at(self, x: Floats) -> Floats:
        """Return vectors (n, dim) at positions x (m)."""
        axis, arm = arms_about(self.circumferential_about, self.origin, x)
        return np.cross(axis, arm)[:, : x.shape[1]]


@dataclass(frozen=True)
class AlongField:
    """Direction field given by expressions; its tangential part is used.

    Parameters
    ----------
    field
        Expressions in the coordinates, one for each component
        (:class:`cea.expressions.Expression`).
    """

    field: tuple[str, ...]

    def __post_init__(self) -> None:
        for text in self.field:
            Expression(text).check("field")

    def check(self, dim: int, field: str) -> None:
        """Raise InputError for a wrong number of expressions or unknown coordinates."""
        allowed = f"{dim} expressions, one for each component"
        require(len(self.field) == dim, f"{field}.field", list(self.field), allowed)
        for i, text in enumerate(self.field):
            Expression(text).check(f"{field}.field.{i}", dim)

    def at(self, x: Floats) -> Floats:
        """Return vectors (n, dim) at positions x (m)."""
        return np.stack([Expression(text)(x) for text in self.field], axis=1)


FrictionDirection = AlongVector | Circumferential | AlongField


@dataclass(frozen=True)
class Friction:
    """Coulomb friction of steady sliding, along a direction of the traction on side a."""

    mu: Floats | float  # coefficient, shape (n,) or one number, zero or positive
    direction: FrictionDirection
    # whether side a carries the opposite traction, as in the second half of a full pass
    reverse: bool = False

    def __post_init__(self) -> None:
        mu = np.asarray(self.mu)
        require(bool((mu >= 0).all()), "mu", float(mu.min()), "zero or positive")

    def along(self, x: Floats, normal: Floats) -> Floats:
        """Return unit tangents (n, dim) at positions x (m) with unit normals."""
        direction = self.direction.at(x)
        tangent = direction - np.einsum("ij,ij->i", direction, normal)[:, None] * normal
        length = np.linalg.norm(tangent, axis=1)
        if (length <= _GRAZING * np.linalg.norm(direction, axis=1)).any():
            worst = int(np.argmin(length))
            value, at = direction[worst].tolist(), normal[worst]
            allowed = f"a direction that is not normal to side a, whose normal here is {at}"
            raise InputError("friction_direction_on_a", value, allowed)
        return (-tangent if self.reverse else tangent) / length[:, None]
