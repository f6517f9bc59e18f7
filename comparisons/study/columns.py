"""Columns of tables: title, unit and format of the quantities that studies share."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import pandas as pd

from comparisons.study.numbers import MISSING, growth, number, shown
from scenes.spec.body import backend_name


@dataclass(frozen=True)
class Column:
    """Title, unit and format of a column of a table, or of an axis of a plot."""

    title: str
    unit: str = ""
    show: Callable[[Any], str] | None = None  # formats a value; None: str, left-aligned

    def cell(self, value: Any) -> str:
        """Text of a value; a dash if it is missing."""
        if is_missing(value):
            return MISSING
        if isinstance(value, bool):
            return "yes" if value else "no"
        return self.show(value) if self.show else str(value)

    @property
    def axis(self) -> str:
        """Title of an axis."""
        return f"{self.title} ({self.unit})" if self.unit else self.title

    @property
    def number(self) -> bool:
        """Whether the column is right-aligned and sorted by value."""
        return self.show not in (None, backend_name)


def _stiffness(value: float) -> str:
    """Text of a contact stiffness, ∞ if the sides are tied."""
    return number(value, 2) if isfinite(value) else "∞"


COLUMNS = {
    "backend": Column("backend", show=backend_name),
    "P": Column("P", "N/m", _stiffness),
    "p": Column("p", "N/m³", _stiffness),
    "mu": Column("μ", show=shown(3)),
    "clock": Column("clock", "s", shown(3)),
    "processor": Column("processor", "s", shown(3)),
    "seconds": Column("run time", "s", shown(3)),
    "memory": Column("peak memory", "MB", shown(3)),
    "frequency": Column("frequency", "Hz", shown(6)),
    "growth": Column("growth rate", "1/s", growth),
    "residual": Column("residual", show=shown(2)),
    "condition": Column("condition", show=shown(3)),
    "error": Column("error", show=shown(2)),
}
"""Shared columns by name; a table may define columns of its own."""


def is_missing(value: Any) -> bool:
    """Whether a value is None, NA or NaN."""
    return value is None or value is pd.NA or (isinstance(value, float) and value != value)


def column(name: Any, frame: pd.DataFrame, own: Mapping[Any, Column] | None = None) -> Column:
    """The column of a name: from ``own``, from COLUMNS, or made from its name and data type."""
    for known in (own or {}, COLUMNS):
        if name in known:
            return known[name]
    title = number(name, 2) if isinstance(name, int | float) else str(name).replace("_", " ")
    kind = frame[name].dtype.kind if name in frame else "O"
    return Column(title, show={"f": shown(3), "i": number}.get(kind))


def wide(frame: pd.DataFrame, index: Sequence[str], across: str, values: str) -> pd.DataFrame:
    """Pivot a frame: a column for each value of ``across``, with cells from ``values``.

    Each row has one value of the columns ``index``; order is kept, absent combinations are missing.
    """
    if frame.empty:
        return frame
    rows = frame[[*index]].drop_duplicates()
    cells = frame.pivot(index=[*index], columns=across, values=values).reset_index()
    return rows.merge(cells, on=[*index], how="left")[[*index, *frame[across].unique()]]


def medians(frame: pd.DataFrame, *also: str, over: str = "repeat") -> pd.DataFrame:
    """Merge rows that differ only in ``over``: medians of floats, first values of all else.

    Columns before ``over`` are labels, those after it measurements; ``also`` names measured columns
    that distinguish rows of one case. ``over`` is dropped.
    """
    if frame.empty:
        return frame
    labels = [*frame.columns[: frame.columns.get_loc(over)], *also]
    # "first" of pandas skips missing values
    measured = {
        name: "median" if frame[name].dtype.kind == "f" else lambda values: values.iloc[0]
        for name in frame.columns
        if name not in (*labels, over)
    }
    return frame.groupby(labels, sort=False, dropna=False).agg(measured).reset_index()
