"""What contact stresses of a static analysis say of themselves, fresh or opened from a file."""

from collections.abc import Mapping
from typing import Any, NamedTuple


class Extremes(NamedTuple):
    """Normal stress over one side of a contact (N/m^2): extremes, and their difference."""

    min: float
    max: float
    oscillation: float


def stress_rows(stresses: Mapping[str, Mapping[str, Extremes]]) -> list[dict[str, Any]]:
    """A row for each side of each contact; stresses by contact, then side "a" or "b"."""
    return [
        {"contact": name, "side": side, **extremes._asdict()}
        for name, sides in stresses.items()
        for side, extremes in sides.items()
    ]


def stress_lines(rows: list[dict[str, Any]]) -> list[str]:
    """Lines for people, one for each row of :func:`stress_rows`."""
    return [
        f"{row['contact']}, side {row['side']}: sigma_n from {row['min']:.6g} to "
        f"{row['max']:.6g}, oscillation {row['oscillation']:.6g} N/m^2"
        for row in rows
    ]
