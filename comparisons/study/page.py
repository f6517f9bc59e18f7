"""The page of a study: one self-contained file, with CSV and PNG files beside it."""

import json
from base64 import b64encode
from collections.abc import Iterator, Sequence
from functools import cache
from gzip import compress
from importlib import resources
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from matplotlib import rc_context

from cea.files import write_whole
from comparisons.study import plots
from comparisons.study.closing import closing
from comparisons.study.columns import Column, column, is_missing
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table, rows
from comparisons.study.shapes import STEPS, Shapes, merged
from comparisons.study.study import Study

REPORT = "report.html"  # name of a page
_HERE = Path(__file__).parent
_SCRIPTS = ("tables.js", "contents.js", "plots.js", "shapes.js", "viewer.js", "start.js")


def write_study(study: Study, result: StudyResult, out: Path) -> Path:
    """Write record, arrays, tables, figures and page of a study; only rank 0 calls it."""
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
    """Write ``report.html``, one self-contained file, and return its path.

    Frames and headlines are made from ``result``; empty sections are left out. ``text`` is shown
    above all sections; with ``files`` tables and figures are also written to separate files.
    """
    to = out if files else None
    parts = [made for s in present(sections, result) if (made := _section(s, result, to, shapes))]
    modes = [
        f"{key}/{mode}" for key, own in (shapes.modes if shapes else {}).items() for mode in own
    ]
    environment = Environment(
        loader=FileSystemLoader(_HERE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("page.html").render(
        heading=title,
        text=text,
        files=files,
        parts=parts,
        shapes=packed(json.dumps(shapes.plain()).encode()) if modes and shapes else "",
        keys=set(modes),
        first=modes[0] if modes else "",
        steps=STEPS,
        style=Markup((_HERE / "style.css").read_text("utf-8")),
        scripts=Markup(
            "\n".join((_HERE / "scripts" / name).read_text("utf-8") for name in _SCRIPTS)
        ),
        library=_library() if modes or any(part["plots"] for part in parts) else "",
    )
    write_whole(page.encode(), out / REPORT)
    return out / REPORT


def packed(content: bytes) -> str:
    """Compress bytes with gzip, reproducibly, and encode them in base64."""
    return b64encode(compress(content, 9, mtime=0)).decode()


@cache
def _library() -> str:
    """plotly.js of the Python package plotly, compressed, in base64."""
    return packed((resources.files("plotly") / "package_data" / "plotly.min.js").read_bytes())


def present(sections: Sequence[Section], result: Any) -> Iterator[Section]:
    """Sections whose table of rows (:attr:`Section.of`) is not empty."""
    return (s for s in sections if not s.of or not result.frame(s.of).empty)


def _section(
    section: Section, result: Any, out: Path | None, shapes: Shapes | None
) -> dict[str, Any] | None:
    """Data of a section for the template; None if the section is empty."""
    tables, drawn, images = [], list[dict[str, Any]](), list[dict[str, Any]]()
    for table in section.tables:
        frame = rows(table.frame, result)
        if out:
            raw = frame.drop(columns="shape", errors="ignore").to_csv(index=False)
            write_whole(raw.encode(), out / f"{table.name}.csv")
        if table.shown and not frame.empty:
            tables.append(table_cells(table, frame))
    for plot in section.plots:
        if isinstance(plot, Plot):
            points = rows(plot.frame, result)
            if points.empty:
                continue
            drawn.append({"plot": plot, "panels": plots.drawn_by_page(plot, points)})
            if out:
                with rc_context(plots.STYLE):
                    plots.save(plots.draw(plot, points), out / f"{plot.name}.png")
            continue
        with rc_context(plots.STYLE):
            figure = plot(result)
        if figure is not None and out is not None:
            file = f"{getattr(plot, '__name__', 'figure')}.png"
            content = b64encode(plots.save(figure, out / file)).decode()
            caption = " ".join((plot.__doc__ or "").split())
            source = f"data:image/png;base64,{content}"
            images.append({"source": source, "file": file, "caption": caption})
    shown = {
        "headline": (section.headline(result) if section.headline else None) or "",
        "tables": tables,
        "plots": drawn,
        "images": images,
        "modes": section.modes and shapes is not None and bool(shapes.modes),
    }
    if not any(shown.values()):
        return None
    name = section.title.lower().replace(" ", "-")
    return {"id": name, "title": section.title, "text": section.text} | shown


def table_cells(table: Table, frame: pd.DataFrame) -> dict[str, Any]:
    """Data of a table for the template; each cell has a text and the number to sort by."""
    columns = {name: column(name, frame, table.own) for name in frame if name != "shape"}
    return {
        "name": table.name,
        "caption": table.caption,
        "heads": columns.items(),
        "rows": list(_rows(frame, columns)),
    }


def _rows(frame: pd.DataFrame, columns: dict[Any, Column]) -> Iterator[dict[str, Any]]:
    for row in frame.astype(object).to_dict("records"):
        cells = [(c.cell(row[name]), _raw(row[name], c)) for name, c in columns.items()]
        yield {"shape": row.get("shape") or "", "cells": cells}


def _raw(value: Any, shown: Column) -> str | None:
    if not shown.number:
        return None
    if is_missing(value):
        return ""
    return None if isinstance(value, str) else repr(float(value)).replace("inf", "Infinity")
