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
    """A data frame as a page shows it; ``name.csv`` holds its raw values.

    Parameters
    ----------
    name
        Stem of the CSV file.
    caption
        What it shows.
    frame
        Makes it of the result. A column ``shape`` names the mode of a row in the viewer, and is
        not shown.
    own
        How columns of the application are shown; others are as in
        :data:`comparisons.study.columns.COLUMNS`.
    group
        Column whose values stand as headings above their rows.
    printed
        Whether the command prints it.
    shown
        Whether the page shows it; otherwise only the CSV file is written.
    """

    name: str
    caption: str
    frame: Frame
    own: Mapping[Any, Column] = field(default_factory=dict)
    group: str = ""
    printed: bool = False
    shown: bool = True


@dataclass(frozen=True)
class Plot:
    """Lines with markers: a panel for all values of ``panel``, a line for those of ``series``.

    Parameters
    ----------
    name
        Stem of the PNG file.
    caption
        What it shows.
    frame
        Makes its points of the result; a column ``shape`` names the mode of a point.
    x, y
        Columns.
    series
        Columns that set lines apart: the backend by its marker, others by colour.
    panel
        Columns that set panels apart.
    log
        Logarithmic axes: "x", "y" or "xy".
    own
        How columns of the application are shown; their titles are those of the axes.
    lines
        Makes lines without markers, in the same columns; those of ``frame`` are markers then.
    style
        "lines" or "markers".
    """

    name: str
    caption: str
    frame: Frame
    x: str
    y: str
    series: Sequence[str] = ()
    panel: Sequence[str] = ()
    log: str = ""
    own: Mapping[Any, Column] = field(default_factory=dict)
    lines: Frame | None = None
    style: str = "lines"


Drawing = Callable[[Any], "Figure | None"]
"""Draws a figure of a result with matplotlib, or none; its name and docstring are name, caption."""


@dataclass(frozen=True)
class Section:
    """A section of a page.

    Parameters
    ----------
    title
        Its heading.
    text
        What a reader must know, written once.
    headline
        The finding in one line, made of the numbers; None where there is none.
    tables, plots
        What it shows.
    modes
        Whether the viewer of the modes that cases kept stands here.
    of
        Table of rows of a study without which the section is left out.
    """

    title: str
    text: str = ""
    headline: Callable[[Any], str | None] | None = None
    tables: Sequence[Table] = ()
    plots: Sequence[Plot | Drawing] = ()
    modes: bool = False
    of: str = ""
