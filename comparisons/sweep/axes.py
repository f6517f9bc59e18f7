"""Axes of a sweep as they are given: ``mu=0:1:101``, ``P=1e6:1e14:log:81``."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cea.errors import InputError
from scenes.spec.consistency import LARGEST, SMALLEST

_MOST = 10_000
"""Values of an axis."""
_ALLOWED = "name=first:last:count, or name=first:last:log:count"


@dataclass(frozen=True)
class Axis:
    """Values of one field.

    Parameters
    ----------
    name
        The field as it was given: a path such as ``contacts.pad_disc.mu``, with asterisks for any
        name, or ``mu``, ``P`` and ``p`` of every contact that can slide, ``E`` and ``rho`` of every
        body.
    first, last
        The ends.
    count
        Number of values.
    logarithmic
        Whether they are evenly spaced in their logarithm.
    """

    name: str
    first: float
    last: float
    count: int
    logarithmic: bool = False

    def __post_init__(self) -> None:
        for end in (self.first, self.last):
            check_end(self.name, end, positive=self.logarithmic)
        if self.first == self.last:
            raise InputError(self.name, self.last, "another last value than the first")
        if not 2 <= self.count <= _MOST:
            raise InputError(self.name, self.count, f"2 to {_MOST} values")

    @property
    def values(self) -> list[float]:
        """The values."""
        spaced = np.geomspace if self.logarithmic else np.linspace
        return spaced(self.first, self.last, self.count).tolist()

    @property
    def ends(self) -> tuple[float, float]:
        """Least and greatest value."""
        return min(self.first, self.last), max(self.first, self.last)

    def plain(self) -> Mapping[str, object]:
        """It as plain data."""
        return {
            "name": self.name,
            "first": self.first,
            "last": self.last,
            "count": self.count,
            "log": self.logarithmic,
        }


def check_end(name: str, value: float, *, positive: bool) -> None:
    """Refuse an end of what varies that no field of a scene may have.

    Raises
    ------
    InputError
        When it is not finite or too large; where it must be positive, too small as well.
    """
    if not abs(value) <= LARGEST:
        raise InputError(name, value, f"a finite number of at most {LARGEST:g}")
    if positive and value < SMALLEST:
        raise InputError(name, value, f"positive, at least {SMALLEST:g}")


def read_axis(text: str) -> Axis:
    """An axis from its text.

    Raises
    ------
    InputError
        When it is no axis.
    """
    name, equals, rest = text.partition("=")
    parts = rest.split(":")
    logarithmic = len(parts) == 4 and parts[2] == "log"
    if not (name and equals) or len(parts) != (4 if logarithmic else 3):
        raise InputError("axis", text, _ALLOWED)
    try:
        first, last, count = float(parts[0]), float(parts[1]), int(parts[-1])
    except ValueError:
        raise InputError("axis", text, _ALLOWED) from None
    return Axis(name, first, last, count, logarithmic)
