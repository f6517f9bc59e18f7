"""The page of a study: JSON, CSV files, figures and Markdown, all drawn from plain data."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from cea.files import write_whole
from comparisons.accuracy import figures, tables, words
from comparisons.accuracy.runner import COMMAND
from comparisons.kit.plots import png
from comparisons.kit.records import RESULT, read_result
from comparisons.kit.tables import Table
from scenes.stored import write_record

Data = dict[str, Any]

_DPI = 150


def read(out: Path) -> Data:
    """Data of a study that was written to a folder, as it is or compressed.

    Raises
    ------
    InputError
        When the folder holds none.
    """
    return read_result(out, COMMAND)


def write(data: Data, out: Path) -> Path:
    """Write data, tables, figures and the page.

    Returns
    -------
    Path
        The page.
    """
    write_record(data, out / RESULT)
    made = {table.name: table for table in (make(data) for make in tables.TABLES)}
    for table in made.values():
        table.write_csv(out)
    for problem in data["problems"]:
        _save(figures.error_against_cost, data, problem, out / f"error_{problem}.png")
        _save(figures.growth_against_stiffness, data, problem, out / f"growth_{problem}.png")
    page = out / "report.md"
    write_whole(("\n".join(_page(data, made)) + "\n").encode(), page)
    return page


def _save(draw: Callable[[Data, str], Figure], data: Data, problem: str, file: Path) -> None:
    write_whole(png(draw(data, problem), _DPI), file)


def _page(data: Data, made: dict[str, Table]) -> list[str]:
    text = [
        "# Error of flutter eigenvalues against run time",
        "",
        words.how_measured(data),
        "",
        "## Where each formulation may be used",
        "",
        words.in_short(data),
        "",
        words.verdict_rule(),
        "",
        *_bullets(words.where_each_may_be_used(data)),
        "",
    ]
    if data.get("no_flutter"):
        text += ["## Where nothing may grow", "", *_bullets(words.without_flutter(data)), ""]
    if data.get("finest"):
        text += ["## Finest meshes", "", *_bullets(words.finest(data)), ""]
        text += _table(made["finest"])
    for problem, described in data["problems"].items():
        low, high = described["band"]
        text += [
            f"## {problem}",
            "",
            f"Exact eigenvalues with {low:g} <= Im lambda <= {high:g} rad/s, friction "
            f"{described['friction']}, p in units of {described['unit']:g} N/m³.",
            "",
            f"![error against run time and dofs](error_{problem}.png)",
            "",
            f"![error of growth against p](growth_{problem}.png)",
            "",
            "Fastest for its error (no other run is better in both):",
            "",
            *_bullets(words.front(data, problem)),
            "",
            *_table(made["orders"], problem),
        ]
    return [*text, *_omissions(made), *_machine(data)]


def _bullets(sentences: list[str]) -> list[str]:
    return [f"- {sentence}" for sentence in sentences]


def _omissions(made: dict[str, Table]) -> list[str]:
    parts = [made[name] for name in ("omissions", "incomplete")]
    text = ["## Omissions", ""]
    if not any(table.rows for table in parts):
        return [*text, "Nothing was left out and nothing failed.", ""]
    return [*text, *(line for table in parts for line in _table(table))]


def _table(table: Table, problem: str | None = None) -> list[str]:
    """A table in Markdown, the rows of one problem or all."""
    rows = [
        cells
        for cells, row in zip(table.cells(), table.rows, strict=True)
        if problem is None or row[0] == problem
    ]
    if not rows:
        return []
    heads = [c.title + (f" ({c.unit})" if c.unit else "") for c in table.columns]
    lines = [heads, ["---:" if c.show else "---" for c in table.columns], *rows]
    body = ["| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines]
    return [f"{table.caption} (`{table.name}.csv`)", "", *body, ""]


def _machine(data: Data) -> list[str]:
    versions = ", ".join(f"{name} {version}" for name, version in data["versions"].items())
    machine = data["machine"]
    return [
        "## As run",
        "",
        f"{machine['system']} {machine['machine']}, {machine['cpus']} processors; {versions}; "
        f"commit {data['commit']}. "
        f"Study: {json.dumps(data['inputs']['study'])}. All numbers: `{RESULT}`, `runs.csv`, "
        "`uses.csv`, `pareto.csv`.",
    ]
