"""Named parameters of a pencil, and the coefficients c_j(t) of its terms."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, prod
from typing import Protocol

from cea.errors import InputError


@dataclass(frozen=True)
class Parameter:
    """A number that a pencil depends on.

    ``name`` is the path of the field in a scene, e.g. ``contacts.pad_disc.mu``; ``value`` is the
    default. Zero is not allowed if ``positive``, infinity if ``finite``, and negative values only
    if ``signed``. A ``fixed`` parameter cannot be changed, since terms of the pencil, such as modal
    damping, were computed at its value.
    """

    name: str
    value: float
    unit: str = "1"
    positive: bool = False
    finite: bool = True
    signed: bool = False
    fixed: bool = False

    def check(self, value: float) -> float:
        """Return the value as a float; InputError when it is not allowed."""
        if self.fixed and value != self.value:
            allowed = f"{self.value:g}, at which modal damping was computed"
            raise InputError(self.name, value, allowed)
        if self.signed:
            if not isfinite(value):
                raise InputError(self.name, value, f"a finite number ({self.unit})")
            return float(value)
        least = value > 0 if self.positive else value >= 0
        if not (least and (value < inf or not self.finite)):
            allowed = ("positive" if self.positive else "zero or positive") + f" ({self.unit})"
            raise InputError(self.name, value, allowed + (", finite" if self.finite else ""))
        return float(value)


class Dependence(Protocol):
    """Coefficient c_j(t) of a term of a pencil, a function of parameters t."""

    @property
    def names(self) -> frozenset[str]:
        """Parameters it depends on."""
        ...

    def at(self, values: Mapping[str, float]) -> float:
        """Value at given parameters."""
        ...

    def derivative(self, name: str, values: Mapping[str, float]) -> float:
        """Derivative in one parameter."""
        ...


@dataclass(frozen=True)
class Coefficient:
    """A factor times powers (t / reference)^exponent of parameters, a :class:`Dependence`.

    ``powers`` maps parameters to (reference, exponent). At t = reference a power is exactly 1.
    """

    powers: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    factor: float = 1.0

    def times(self, name: str, exponent: float = 1.0, factor: float = 1.0) -> "Coefficient":
        """Return the coefficient multiplied by factor * p**exponent of one more parameter p."""
        return Coefficient({**self.powers, name: (1.0, exponent)}, factor * self.factor)

    @property
    def names(self) -> frozenset[str]:
        """Parameters it depends on."""
        return frozenset(self.powers)

    def at(self, values: Mapping[str, float]) -> float:
        """Value at given parameters."""
        return self.factor * prod(
            (values[name] / reference) ** exponent
            for name, (reference, exponent) in self.powers.items()
        )

    def derivative(self, name: str, values: Mapping[str, float]) -> float:
        """Derivative in one parameter."""
        powers = dict(self.powers)
        if name not in powers:
            return 0.0
        reference, exponent = powers.pop(name)
        slope = exponent / reference * (values[name] / reference) ** (exponent - 1)
        return slope * Coefficient(powers, self.factor).at(values)


CONSTANT = Coefficient()
"""The constant 1."""

NOTHING = Coefficient(factor=0.0)
"""The constant 0."""
