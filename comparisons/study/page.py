"""The page of a study: one file that needs no other; CSV and PNG files beside it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from cea.files import write_whole
from comparisons.kit.page import REPORT, Image, render
from comparisons.kit.plots import save
from comparisons.kit.shapes import Shapes
from comparisons.study import plots
from comparisons.study.closing import closing
from comparisons.study.columns import Column, column, is_missing, is_number
from comparisons.study.modes_view import merged
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.study import Study

TEMPLATE = Path(__file__).with_name("page.html")


@dataclass(frozen=True)
class ShownTable:
    """Cells of a table, raw numbers to sort them by, headings of groups, modes of the rows."""

    table: Table
    frame: pd.DataFrame
    columns: Sequence[tuple[Any, Column]]

    @classmethod
    def of(cls, table: Table, result: Any) -> "ShownTable":
        """A table of a result."""
        frame = table.frame(result)
        names = [name for name in frame if name not in ("shape", table.group)]
        return cls(table, frame, [(name, column(name, frame, table.own)) for name in names])

    @property
    def name(self) -> str:
        """Stem of its file."""
        return self.table.name

    def csv(self) -> bytes:
        """Raw values; empty where there is none."""
        frame = self.frame.drop(columns="shape", errors="ignore")
        return frame.to_csv(index=False).encode()

    def groups(self) -> list[tuple[str, list[dict[str, Any]]]]:
        """Headings with their rows: cells, and the shape of the row."""
        group = self.table.group
        if self.frame.empty:
            return []
        if not group:
            return [("", self._rows(self.frame))]
        shown = column(group, self.frame, self.table.own)
        return [(shown.cell(v), self._rows(f)) for v, f in self.frame.groupby(group, sort=False)]

    def _rows(self, frame: pd.DataFrame) -> list[dict[str, Any]]:
        rows = frame.astype(object).to_dict("records")
        return [
            {
                "shape": row.get("shape") or "",
                "cells": [
                    (c.cell(row[name]), _raw(row[name]) if is_number(c) else None)
                    for name, c in self.columns
                ],
            }
            for row in rows
        ]

    def heads(self) -> list[dict[str, Any]]:
        """Headings of its columns."""
        return [
            {"name": name, "title": c.title, "unit": c.unit, "number": is_number(c)}
            for name, c in self.columns
        ]


def _raw(value: Any) -> str | None:
    """A number as a script sorts by it; empty where there is none, None of a text."""
    if is_missing(value):
        return ""
    return None if isinstance(value, str) else repr(float(value)).replace("inf", "Infinity")


def write_study(study: Study, result: StudyResult, out: Path) -> Path:
    """Write record, arrays, tables, figures and page of a study; rank 0 alone calls it."""
    result.save(out)
    sections = [*study.sections, *closing()]
    return write(study.title, sections, result, out, shapes=merged(result))


def write(
    title: str,
    sections: Sequence[Section],
    result: Any,
    out: Path,
    *,
    shapes: Shapes | None = None,
    text: str = "",
    files: bool = True,
) -> Path:
    """Write tables, figures and the page.

    Parameters
    ----------
    title
        Title of the page.
    sections
        Its sections; one that shows nothing is left out.
    result
        What their frames and headlines are made of.
    out
        Folder for ``report.html``, CSV and PNG files.
    shapes
        Modes of the viewer.
    text
        What stands above all sections.
    files
        Whether tables and plots are written to files too.

    Returns
    -------
    Path
        The page.
    """
    to = out if files else None
    shown = [made for s in sections if (made := _section(s, result, to, shapes)) is not None]
    keys = list(shapes.keys) if shapes else []
    page = render(
        TEMPLATE,
        plots=bool(keys) or any(s["plots"] for s in shown),
        shapes=shapes if shapes and shapes.scenes else None,
        heading=title,
        text=text,
        files=files,
        parts=shown,
        keys=set(keys),
        first=_first(shapes),
    )
    write_whole(page.encode(), out / REPORT)
    return out / REPORT


def _first(shapes: Shapes | None) -> str:
    """The mode that the viewer shows first."""
    for key, modes in shapes.modes.items() if shapes else ():
        for mode in modes:
            return f"{key}/{mode}"
    return ""


def _section(
    section: Section, result: Any, out: Path | None, shapes: Shapes | None
) -> dict[str, Any] | None:
    """What the template shows of a section; None of one that shows nothing."""
    headline = (section.headline(result) if section.headline else None) or ""
    tables = [ShownTable.of(table, result) for table in section.tables]
    for table in tables:
        if out:
            write_whole(table.csv(), out / f"{table.name}.csv")
    drawn, images = [], []
    for plot in section.plots:
        if isinstance(plot, Plot):
            made = plots.drawn_by_page(plot, result)
            if made and out:
                save(plots.draw(plot, result), out / f"{plot.name}.png")
            if made:
                drawn.append({"plot": plot, "panels": made})
            continue
        figure = plot(result)
        if figure is not None and out is not None:
            file = out / f"{getattr(plot, '__name__', 'figure')}.png"
            save(figure, file)
            images.append(
                {"image": Image.of(file), "caption": " ".join((plot.__doc__ or "").split())}
            )
    modes = section.modes and shapes is not None and bool(shapes.keys)
    geometry = next(iter(shapes.scenes), "") if section.geometry and shapes else ""
    shown = [t for t in tables if t.table.shown and not t.frame.empty]
    if not (shown or drawn or images or modes or geometry or headline):
        return None
    return {
        "id": section.title.lower().replace(" ", "-"),
        "title": section.title,
        "text": section.text,
        "headline": headline,
        "tables": shown,
        "plots": drawn,
        "images": images,
        "modes": modes,
        "geometry": geometry,
    }
