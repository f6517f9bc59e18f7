"""Named parameters of a pencil, and the coefficients through which its pieces depend on them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, prod
from typing import Protocol

from cea.errors import InputError


@dataclass(frozen=True)
class Parameter:
    """A number that a pencil depends on.

    Its name is the path of the field in a scene, e.g. ``contacts.pad_disc.mu``; its value holds
    where none is given. Zero is refused where it is to be positive, infinity where it is to be
    finite; only signed ones may be below zero. A fixed one keeps its value: what depends on it, as
    modes that are damped one by one, was found at that.
    """

    name: str
    value: float
    unit: str = "1"
    positive: bool = False
    finite: bool = True
    signed: bool = False
    fixed: bool = False

    def check(self, value: float) -> float:
        """The value, or a refusal of it."""
        if self.fixed and value != self.value:
            raise InputError(self.name, value, f"{self.value:g}, where damped modes were found")
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
    """How a piece of a pencil depends on parameters: its c_j(t)."""

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

    Powers are given as (reference, exponent) by parameter. At its reference a parameter counts as 1
    to the last bit.
    """

    powers: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    factor: float = 1.0

    def times(self, name: str, exponent: float = 1.0, factor: float = 1.0) -> "Coefficient":
        """The coefficient multiplied by factor * p**exponent of one more parameter."""
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
"""1, whatever the parameters."""

NOTHING = Coefficient(factor=0.0)
"""0, whatever the parameters."""
