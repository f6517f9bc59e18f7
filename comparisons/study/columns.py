"""Columns of tables: title, unit and form of the quantities that studies share."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import pandas as pd

from comparisons.study.numbers import MISSING, growth, number, shown
from scenes.spec.body import backend_name


@dataclass(frozen=True)
class Column:
    """How a column is shown; its title is that of an axis too."""

    title: str
    unit: str = ""
    show: Callable[[Any], str] | None = None  # text of a value; None: as it is, set to the left

    def cell(self, value: Any) -> str:
        """Text of a value; a dash where there is none."""
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
        """Whether it is set to the right and sorted by its values."""
        return self.show not in (None, backend_name)


def _stiffness(value: float) -> str:
    """A contact stiffness, infinite where the sides are tied."""
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
"""Quantities by the name of their column; an application gives its own beside a table."""


def is_missing(value: Any) -> bool:
    """Whether there is no value."""
    return value is None or value is pd.NA or (isinstance(value, float) and value != value)


def column(name: Any, frame: pd.DataFrame, own: Mapping[Any, Column] | None = None) -> Column:
    """How a column is shown: as the application says, as studies share it, or by its name."""
    for known in (own or {}, COLUMNS):
        if name in known:
            return known[name]
    title = number(name, 2) if isinstance(name, int | float) else str(name).replace("_", " ")
    kind = frame[name].dtype.kind if name in frame else "O"
    return Column(title, show={"f": shown(3), "i": number}.get(kind))


def wide(frame: pd.DataFrame, index: Sequence[str], across: str, values: str) -> pd.DataFrame:
    """A frame with a column for each value of ``across``, whose cells are those of ``values``.

    A row has the columns ``index`` in common; order is kept, and what has no row is missing.
    """
    if frame.empty:
        return frame
    rows = frame[[*index]].drop_duplicates()
    cells = frame.pivot(index=[*index], columns=across, values=values).reset_index()
    return rows.merge(cells, on=[*index], how="left")[[*index, *frame[across].unique()]]


def medians(frame: pd.DataFrame, *also: str, over: str = "repeat") -> pd.DataFrame:
    """A row for all that differ in one label: medians of measured numbers, the first of all else.

    Labels stand before ``over``, which is left out, what was measured behind it; the columns
    ``also`` tell rows of one case apart.
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
