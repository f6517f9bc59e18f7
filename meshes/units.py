"""Units of length of files, and names of surfaces that fit scenes."""

from typing import Literal, get_args

from cea.arrays import Floats
from cea.errors import require

Unit = Literal["m", "cm", "mm", "um", "in", "ft"]
METRES: dict[Unit, tuple[float, float]] = {
    "m": (1, 1),
    "cm": (1, 100),
    "mm": (1, 1000),
    "um": (1, 10**6),
    "in": (254, 10**4),
    "ft": (3048, 10**4),
}
"""Each unit in metres, as a fraction: numbers of the file are multiplied, then divided."""


_LONGEST = 100
"""Characters of a name of a surface."""


def in_metres(values: Floats, unit: Unit) -> Floats:
    """Lengths of a file in metres."""
    above, below = METRES[unit]
    return values * above / below


def check_unit(unit: str | None) -> None:
    """Refuse a file whose unit of length nobody told."""
    allowed = f"the unit of length of the file, one of {', '.join(get_args(Unit))}"
    require(unit is not None, "unit", None, allowed)


def is_fit(name: str) -> bool:
    """Whether a name can stand in "body.surface"."""
    return 0 < len(name) <= _LONGEST and name.isprintable() and not set(name) & set(" .,[]")
