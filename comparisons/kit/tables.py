"""A table: raw values for a CSV file, formatted cells for a page."""

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from itertools import groupby
from math import isnan
from pathlib import Path
from typing import Any

from cea.files import write_whole
from comparisons.kit.numbers import MISSING

Data = Mapping[str, Any]
"""Plain data, as JSON holds them, that tables, words and figures are made of."""

VERDICTS = {True: "yes", False: "no"}
"""How a verdict is shown."""


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    name
        Header in the CSV file.
    title
        Header on the page.
    show
        Makes text of a value; None leaves the text as it is, set to the left.
    unit
        Unit of the values.
    """

    name: str
    title: str
    show: Callable[[Any], str] | None = None
    unit: str = ""

    def cell(self, value: Any) -> str:
        """Text of a value."""
        if value is None:
            return MISSING
        return self.show(value) if self.show else str(value)

    @staticmethod
    def raw(value: Any) -> str | None:
        """A number as a script reads it to sort by, empty where there is none; None of a text."""
        if isinstance(value, str):
            return None
        if value is None or isnan(value):
            return ""
        return repr(float(value)).replace("inf", "Infinity")


@dataclass(frozen=True)
class Table:
    """A table.

    Parameters
    ----------
    name
        Stem of its CSV file.
    caption
        What it shows, in words.
    columns
        Its columns.
    rows
        Raw values, one for each column; None where there is none.
    compressed
        Whether its CSV file is compressed, as maps are.
    """

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: Sequence[tuple[Any, ...]]
    compressed: bool = False

    def cells(self) -> list[list[str]]:
        """Formatted rows."""
        return [
            [c.cell(value) for c, value in zip(self.columns, row, strict=True)] for row in self.rows
        ]

    @property
    def grouped(self) -> bool:
        """Whether its first column names the section that a row belongs to."""
        return self.columns[0].name == "section"

    def groups(self) -> list[tuple[str, list[tuple[Any, ...]]]]:
        """Sections with their rows; all rows without a name where there are none."""
        if not self.grouped:
            return [("", list(self.rows))]
        return [(name, list(rows)) for name, rows in groupby(self.rows, key=lambda row: row[0])]

    def write_csv(self, folder: Path) -> Path:
        """Write the raw values to ``folder/name.csv``, ``.csv.gz`` where they are compressed."""
        stream = StringIO(newline="")
        writer = csv.writer(stream)
        writer.writerow(column.name for column in self.columns)
        writer.writerows(self.rows)
        ending = ".csv.gz" if self.compressed else ".csv"
        return write_whole(stream.getvalue().encode(), folder / f"{self.name}{ending}")
