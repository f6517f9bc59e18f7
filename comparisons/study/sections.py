"""Sections of a page: a headline made from the numbers, fixed text, tables, plots."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pandas as pd

from comparisons.study.columns import Column as Column

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Frame = Callable[[Any], pd.DataFrame] | str
"""Function that makes a data frame from a result, or the name of a table of the study."""


def rows(frame: Frame, result: Any) -> pd.DataFrame:
    """The data frame of a result."""
    return result.frame(frame) if isinstance(frame, str) else frame(result)


@dataclass(frozen=True)
class Table:
    """A data frame on a page and in ``name.csv``; its column ``shape`` names the mode of a row."""

    name: str  # stem of the CSV file
    caption: str
    frame: Frame
    own: Mapping[Any, Column] = field(default_factory=dict)  # columns that are not as in COLUMNS
    printed: bool = False  # whether the command prints it
    shown: bool = True  # whether the page shows it, or the CSV file alone is written


@dataclass(frozen=True)
class Plot:
    """Lines with markers: a panel for each value of ``panel``, a line for each of ``series``.

    A column ``shape`` of the frame names the mode of a point.
    """

    name: str  # stem of the PNG file
    caption: str
    frame: Frame
    x: str
    y: str
    series: Sequence[str] = ()  # columns of lines: the first by colour, the last by marker
    panel: Sequence[str] = ()  # columns that distinguish panels
    log: str = ""  # logarithmic axes: "x", "y" or "xy"
    own: Mapping[Any, Column] = field(default_factory=dict)  # as of a table; titles of axes too
    style: str = "lines"  # or "markers"


def diagram(name: str, caption: str, frame: Frame, series: Sequence[str], **more: Any) -> Plot:
    """A stability diagram: growth rates of modes over their frequencies."""
    return Plot(name, caption, frame, "frequency", "growth", series, style="markers", **more)


Drawing = Callable[[Any], "Figure | None"]
"""Function that draws a result with matplotlib, or None; its docstring is the caption."""


@dataclass(frozen=True)
class Section:
    """A section of a page; empty sections are left out."""

    title: str
    text: str = ""  # what a reader must know, written once
    headline: Callable[[Any], str | None] | None = None  # the main result in a line
    tables: Sequence[Table] = ()
    plots: Sequence[Plot | Drawing] = ()
    modes: bool = False  # whether the viewer of mode shapes is shown here
    of: str = ""  # table of rows of a study without which the section is left out
