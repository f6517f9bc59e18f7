"""Sections of a page: a headline made of the numbers, fixed text, tables, plots."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pandas as pd

from comparisons.study.columns import Column as Column

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Frame = Callable[[Any], pd.DataFrame] | str
"""Makes a data frame of a result; a text names the table of a study whose rows it has."""


def rows(frame: Frame, result: Any) -> pd.DataFrame:
    """The data frame of a result, of a study that was just run or read back alike."""
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
    """Lines with markers: a panel for all values of ``panel``, a line for those of ``series``.

    A column ``shape`` of the frame names the mode of a point.
    """

    name: str  # stem of the PNG file
    caption: str
    frame: Frame
    x: str
    y: str
    series: Sequence[str] = ()  # columns that set lines apart: backends by marker, else by colour
    panel: Sequence[str] = ()  # columns that set panels apart
    log: str = ""  # logarithmic axes: "x", "y" or "xy"
    own: Mapping[Any, Column] = field(default_factory=dict)  # as of a table; titles of axes too
    lines: Frame | None = None  # lines without markers; points of ``frame`` are markers then
    style: str = "lines"  # or "markers"


def diagram(name: str, caption: str, frame: Frame, series: Sequence[str], **more: Any) -> Plot:
    """A stability diagram: growth rates of modes over their frequencies."""
    return Plot(name, caption, frame, "frequency", "growth", series, style="markers", **more)


Drawing = Callable[[Any], "Figure | None"]
"""Draws a figure of a result with matplotlib, or none; its name and docstring are name, caption."""


@dataclass(frozen=True)
class Section:
    """A section of a page; one that shows nothing is left out."""

    title: str
    text: str = ""  # what a reader must know, written once
    headline: Callable[[Any], str | None] | None = None  # the finding in a line, of the numbers
    tables: Sequence[Table] = ()
    plots: Sequence[Plot | Drawing] = ()
    modes: bool = False  # whether the viewer of the modes that cases kept stands here
    of: str = ""  # table of rows of a study without which the section is left out
