"""Exact numbers from text, which are rounded only when a precision is chosen."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb, fmpq

from cea.errors import InputError

_LARGEST = 10**300
_ALLOWED = "a number, or a product such as pi, pi/2 or 3*pi/2, or inf"


class Exact:
    """A real number kept as written: ``0.1`` is one tenth, ``pi/2`` is half of pi.

    The value is a number, a string of decimal numbers and ``pi`` joined by ``*`` and ``/``, or
    ``inf``. Anything else is refused with the name of the field.
    """

    def __init__(self, value: "str | float | Exact", field: str = "value") -> None:
        self.text = str(value).replace(" ", "")
        self.rational = Fraction(1)
        self.pi_power = 0
        self.infinite = self.text in {"inf", "infinity", "oo"}
        if self.infinite:
            return
        operator = "*"
        for token in re.split(r"([*/])", self.text):
            if token in {"*", "/"}:
                operator = token
                continue
            sign = 1 if operator == "*" else -1
            if token == "pi":
                self.pi_power += sign
                continue
            try:
                self.rational *= _decimal(token) ** sign
            except (ValueError, ZeroDivisionError):
                raise InputError(field, value, _ALLOWED) from None
        if self.rational and not Fraction(1, _LARGEST) < abs(self.rational) < _LARGEST:
            raise InputError(field, value, "a number that a double can hold")

    def __float__(self) -> float:
        return math.inf if self.infinite else float(self.rational) * math.pi**self.pi_power

    def __str__(self) -> str:
        return self.text

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Exact) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[Fraction, int, bool]:
        return self.rational, self.pi_power, self.infinite

    @property
    def arb(self) -> arb:
        """The number at the current precision (finite numbers only)."""
        rational = arb(fmpq(self.rational.numerator, self.rational.denominator))
        return rational * arb.pi() ** self.pi_power


def _decimal(token: str) -> Fraction:
    """Return a decimal number; numbers that overflow or underflow doubles are refused."""
    rounded = float(token)
    if math.isinf(rounded) or (rounded == 0 and re.search("[1-9]", token.lower().split("e")[0])):
        raise ValueError(token)
    return Fraction(token)


def positive(field: str, value: "str | float | Exact", infinite: bool = False) -> Exact:
    """Return an exact number above zero, infinite only if allowed."""
    number = Exact(value, field)
    if not float(number) > 0 or (number.infinite and not infinite):
        raise InputError(field, str(value), "positive" + (" or inf" if infinite else ""))
    return number


def not_negative(field: str, value: "str | float | Exact") -> Exact:
    """Return an exact finite number, zero or above."""
    number = Exact(value, field)
    if not 0 <= float(number) < math.inf:
        raise InputError(field, str(value), "zero or a positive number")
    return number


def order(field: str, value: int) -> int:
    """Return a circumferential order; negative and fractional ones are refused."""
    if isinstance(value, bool) or int(value) != value or value < 0:
        raise InputError(field, value, "an integer of 0 or more (-m gives -Re lambda)")
    return int(value)


def check_window(max_frequency: float | None, count: int | None) -> None:
    """Refuse unless exactly one of ``max_frequency`` and ``count`` is given, and is positive."""
    if (max_frequency is None) == (count is None):
        raise InputError("max_frequency, count", (max_frequency, count), "exactly one of the two")
    if max_frequency is not None and not 0 < max_frequency < math.inf:
        raise InputError("max_frequency", max_frequency, "a positive number")
    if count is not None and count < 1:
        raise InputError("count", count, "1 or more")


def parameters(problem: type[Any]) -> list[str]:
    """Names of the numbers and materials of a problem, in the order of its fields."""
    return [each.name for each in fields(problem) if each.name not in ("m", "harmonics")]


def exact_numbers(
    problem: type[Any], given: Sequence[Any], named: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the parameters of a problem, given in order or by keyword, as exact numbers.

    ``p`` may be infinite and friction zero. Materials and None are returned unchanged.
    """
    chosen = {**dict(zip(parameters(problem), given, strict=False)), **named}
    checks: dict[str, Callable[[str, Any], Exact]] = {"mu": not_negative, "mu0": not_negative}
    checks["p"] = partial(positive, infinite=True)
    return {
        name: checks.get(name, positive)(name, value)
        if isinstance(value, str | int | float | Exact)
        else value
        for name, value in chosen.items()
    }


def increasing(**numbers: Exact) -> None:
    """Refuse numbers that do not increase strictly."""
    sizes = [float(number) for number in numbers.values()]
    if sizes != sorted(set(sizes)):
        raise InputError(", ".join(numbers), ", ".join(map(str, numbers.values())), "increasing")
