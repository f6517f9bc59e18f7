"""Contact laws: pressure as a function of penetration and its slope, Coulomb friction, sliding.

Laws are independent of geometry. After linearisation about steady sliding, the slope at the
penetrations of that state is the contact stiffness p, and friction multiplies it
(Mohanasundaram et al., 2023, eqs. 7, 8 and 16).
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cea.arrays import Floats, arms_about, of_size_one
from cea.errors import InputError, require
from cea.expressions import Expression

_GRAZING = 1e-6


@dataclass(frozen=True)
class LinearLaw:
    """Pressure proportional to the penetration, also in tension: the closed region is known."""

    # contact stiffness p (N/m^3), shape (n,) or one number; zero where the sides are open; either
    # finite, or infinite at all points: the sides are then tied along the normal
    stiffness: Floats | float
    linear: ClassVar[bool] = True
    """The slope is constant: no steady sliding state is needed."""

    def __post_init__(self) -> None:
        p = np.asarray(self.stiffness)
        least, even = float(p.min(initial=np.inf)), bool(np.isinf(p).all() or not np.isinf(p).any())
        require(least >= 0, "p", least, "zero or positive (N/m^3)")
        some = bool(p.any()) or not p.size
        require(some, "p", 0.0, "positive (N/m^3) somewhere: else there is no contact")
        require(even, "p", np.inf, "finite, or infinite everywhere")

    def pressure(self, penetration: Floats) -> Floats:
        """Return the pressure (N/m^2) at each point for penetrations (m), shape (n,)."""
        return self.stiffness * penetration

    def slope(self, penetration: Floats) -> Floats:
        """Return the contact stiffness p (N/m^3), shape (n,)."""
        return np.broadcast_to(np.asarray(self.stiffness, dtype=float), penetration.shape)


@dataclass(frozen=True)
class NormalCompliance:
    """Normal compliance: the pressure c (g)_+^m, zero where the contact is open.

    Parameters
    ----------
    c
        c_n (N/m^(2 + m_n)), positive.
    m
        m_n, 1 or more.
    """

    c: float
    m: float
    linear: ClassVar[bool] = False

    def __post_init__(self) -> None:
        require(0 < self.c < np.inf, "c_n", self.c, "positive (N/m^(2 + m_n))")
        require(1 <= self.m < np.inf, "m_n", self.m, "1 or more")

    def pressure(self, penetration: Floats) -> Floats:
        """Return the pressure (N/m^2) at each point for penetrations (m), shape (n,)."""
        return self.c * np.maximum(penetration, 0.0) ** self.m

    def slope(self, penetration: Floats) -> Floats:
        """Return the contact stiffness p (N/m^3), zero where the contact is open, shape (n,)."""
        closed = np.maximum(penetration, 0.0)
        return np.where(penetration > 0, self.m * self.c * closed ** (self.m - 1), 0.0)

    def closure(self, pressure: float) -> float:
        """Return the penetration (m) for a pressure (N/m^2), zero or positive."""
        return float((pressure / self.c) ** (1 / self.m))


NormalLaw = LinearLaw | NormalCompliance
"""Law of the normal pressure."""


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
            given = getattr(self.direction, "vector", direction[worst])
            value, at = np.asarray(given).tolist(), normal[worst]
            allowed = f"a direction that is not normal to side a, whose normal here is {at}"
            raise InputError("friction_direction_on_a", value, allowed)
        return (-tangent if self.reverse else tangent) / length[:, None]


@dataclass(frozen=True)
class Sliding:
    """Sliding data for the damping of small velocities (:mod:`cea.system.coupled`)."""

    # v (m/s) at all points, shape (n,); None: no effect of the turning sliding direction
    speed: Floats | None = None
    mu_slope: Floats | None = None  # mu'(v) (s/m) at all points, shape (n,); None for zero
    # sigma (N/m^2) at all points, shape (n,); None: pressure of the law in the state
    pressure: Floats | None = None

    def __post_init__(self) -> None:
        if self.speed is not None:
            least = float(self.speed.min())
            require(least > 0, "sliding.speed", least, "positive (m/s)")
        if self.pressure is not None:
            least = float(self.pressure.min())
            require(least >= 0, "sliding.pressure", least, "zero or positive (N/m^2)")
