"""The page of a study: one file that needs no other; CSV and PNG files beside it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from cea.files import write_whole
from comparisons.kit.numbers import number, plain
from comparisons.kit.page import REPORT, Image, render
from comparisons.kit.plots import save
from comparisons.kit.shapes import Shapes
from comparisons.study import plots
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

    Returns
    -------
    Path
        The page.
    """
    shown = [made for s in sections if (made := _section(s, result, out, shapes)) is not None]
    keys = list(shapes.keys) if shapes else []
    page = render(
        TEMPLATE,
        plots=bool(keys) or any(s["plots"] for s in shown),
        shapes=shapes if shapes and shapes.scenes else None,
        heading=title,
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
    section: Section, result: Any, out: Path, shapes: Shapes | None
) -> dict[str, Any] | None:
    headline = (section.headline(result) if section.headline else None) or ""
    tables = [ShownTable.of(table, result) for table in section.tables]
    for table in tables:
        write_whole(table.csv(), out / f"{table.name}.csv")
    drawn, images = [], []
    for plot in section.plots:
        if isinstance(plot, Plot):
            made = plots.drawn_by_page(plot, result)
            if made:
                save(plots.draw(plot, result), out / f"{plot.name}.png")
                drawn.append({"plot": plot, "panels": made})
            continue
        name, figure = getattr(plot, "__name__", "figure"), plot(result)
        if figure is None:
            continue
        save(figure, out / f"{name}.png")
        caption = " ".join((plot.__doc__ or "").split())
        images.append({"image": Image.of(out / f"{name}.png"), "caption": caption})
    modes = section.modes and shapes is not None and bool(shapes.keys)
    shown = [t for t in tables if t.table.shown and not t.frame.empty]
    if not (shown or drawn or images or modes or headline):
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
    }


def closing() -> list[Section]:
    """Sections of every study: warnings, times, what was left out, what failed, versions."""
    return [
        Section("Warnings", tables=[Table("warnings", "What runs warn of.", _warnings, _WARNED)]),
        Section("Run times", tables=[Table("times", "Seconds of cases by stage.", _times)]),
        Section(
            "Left out",
            tables=[
                Table(
                    *("skipped", "What runs did without since their scenes do not need it."),
                    _left_out,
                )
            ],
        ),
        Section("Failed", tables=[Table("failed", "Cases without an answer.", StudyResult.failed)]),
        Section(
            "Parameters",
            tables=[
                Table("parameters", "Fields of the scenes as run; bars part values.", _parameters),
                Table("options", "Options of the study.", _options),
            ],
        ),
        Section("Machine and versions", tables=[Table("machine", "", _machine)]),
    ]


_WARNED = {"runs": Column("runs", show=number)}


def _warnings(result: StudyResult) -> pd.DataFrame:
    """Kinds of warnings with the first of each and the number of runs that gave it."""
    found: dict[str, dict[str, Any]] = {}
    for run in result.runs():
        for warning in run["warnings"]:
            kind, message = warning["kind"], warning["message"]
            row = found.setdefault(kind, {"warning": kind, "first": message, "runs": 0})
            row["runs"] += 1
    return pd.DataFrame(list(found.values()))


def _times(result: StudyResult) -> pd.DataFrame:
    rows = []
    for case in result.cases:
        stages: dict[str, float] = {}
        for run in case["runs"]:
            for name, seconds in run["stages"].items():
                stages[name] = stages.get(name, 0.0) + seconds
        rows.append(case["labels"] | stages | {"seconds": case["seconds"]})
    return pd.DataFrame(rows)


def _left_out(result: StudyResult) -> pd.DataFrame:
    runs = result.runs()
    rows = [
        {"left_out": what, "reason": reason}
        for run in runs
        for what, reason in run["skipped"].items()
    ]
    if not rows:
        return pd.DataFrame()
    counts = pd.DataFrame(rows).groupby(["left_out", "reason"], sort=False).size()
    return counts.reset_index(name="count").assign(runs=len(runs))


def _parameters(result: StudyResult) -> pd.DataFrame:
    from comparisons.kit.provenance import parameters

    table = parameters(("", "", run) for run in result.runs())
    return pd.DataFrame(
        [row[1:] for row in table.rows], columns=[c.name for c in table.columns[1:]]
    )


def _options(result: StudyResult) -> pd.DataFrame:
    return _named(result.record["inputs"])


def _machine(result: StudyResult) -> pd.DataFrame:
    record = result.record
    commits = ", ".join(dict.fromkeys(case["commit"] for case in result.cases))
    return _named(
        {**record["machine"], **record["versions"], "commit": commits or record["commit"]}
    )


def _named(values: Mapping[str, Any]) -> pd.DataFrame:
    return pd.DataFrame({"name": list(values), "value": [plain(v) for v in values.values()]})
