"""Tables of modes: rows for programs, and text for a terminal or a notebook.

Modes are numbered from 1 in all output.
"""

from collections.abc import Mapping, Sequence
from importlib import import_module
from math import floor, log10
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.errors import InputError

MARKS: dict[str, str] = {"unstable": "▲", "grows slowly": "△", "undecided": "◆"}
"""Symbol shown beside a mode, or a run, by its verdict; other verdicts have none."""
SIGNS = (
    "▲ unstable, △ grows slowly, ◆ undecided; growth rate Re lambda, damping ratio "
    "-Re lambda / |lambda|; errors are algebraic (residual and rounding): cea converge "
    "estimates those of the mesh"
)
"""Legend of symbols and columns."""
TITLES = {
    "mode": "mode",
    "frequency": "frequency (Hz)",
    "growth_rate": "growth rate (1/s)",
    "damping_ratio": "damping ratio",
    "verdict": "verdict",
    "uncertainty": "algebraic error (1/s)",
    "residual": "residual",
    "condition": "condition",
}
"""Headings of the columns of the printed table, in order."""

_DIGITS = 0.01  # growth rate (1/s) below which three decimals are too few
_RATIO = 1e-3  # damping ratio below which four decimals are too few
_FEWEST, _MOST = 3, 9
"""Smallest and largest number of decimals of frequencies (Hz)."""


class ModeTable(list[dict[str, Any]]):
    """List of modes, each a dictionary; accepted by pandas, and printed as a table.

    Keys are ``mode`` (number from 1), ``frequency`` (Hz), ``growth_rate`` (1/s), ``damping_ratio``
    (None for rigid body modes), ``verdict``, ``unstable``, ``rigid``, ``uncertainty`` (1/s),
    ``residual``, ``condition``.
    """

    def column(self, name: str) -> NDArray[Any]:
        """Return one column, shape (n,); None becomes NaN."""
        if self and name not in self[0]:
            raise InputError("name", name, f"one of {', '.join(self[0])}")
        return np.array([np.nan if row[name] is None else row[name] for row in self])

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame`` indexed by the number of the mode."""
        return import_module("pandas").DataFrame.from_records(list(self), index="mode")

    def __repr__(self) -> str:
        return "\n".join(aligned(self))


def shown_cells(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Return the printed text of each mode by column, with the keys of :data:`TITLES`."""
    places = _places(max((row["frequency"] for row in rows), default=0.0))
    return [
        {
            "mode": str(row["mode"]),
            "frequency": f"{row['frequency']:.{places}f}",
            "growth_rate": _signed(row["growth_rate"], 3, _DIGITS),
            "damping_ratio": _signed(row["damping_ratio"], 4, _RATIO),
            "verdict": row["verdict"],
            "uncertainty": f"{row['uncertainty']:.1e}",
            "residual": f"{row['residual']:.1e}",
            "condition": f"{row['condition']:.1f}",
        }
        for row in rows
    ]


def _signed(number: float | None, places: int, least: float) -> str:
    """Return a signed number with ``places`` decimals, or "-" for None.

    Below ``least`` use scientific notation, since the sign of a small growth rate matters.
    """
    if number is None:
        return "-"
    large = number == 0 or abs(number) >= least
    return f"{number:+.{places}f}" if large else f"{number:+.{5 - places}e}"


def aligned(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the lines of a table of modes: headings, and one line per mode with its symbol."""
    cells = [list(TITLES.values()), *(list(row.values()) for row in shown_cells(rows))]
    widths = [max(len(line[i]) for line in cells) for i in range(len(TITLES))]
    marks = [" ", *(MARKS.get(row["verdict"], " ") for row in rows)]
    return [
        "  ".join([mark, *(text.rjust(width) for text, width in zip(line, widths, strict=True))])
        for mark, line in zip(marks, cells, strict=True)
    ]


def _places(highest: float) -> int:
    """Return the decimals that show the highest frequency (Hz) with six digits; at least three."""
    if not highest > 0:
        return _FEWEST
    return min(max(5 - floor(log10(highest)), _FEWEST), _MOST)
