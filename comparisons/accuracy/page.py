"""The page of a study: JSON, CSV files, figures and Markdown, all drawn from plain data."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from cea.errors import InputError
from comparisons.accuracy import figures, tables, words
from comparisons.kit.tables import Table
from scenes.stored import in_json, read_record, write_whole

Data = dict[str, Any]

RESULT = "result.json"
"""Everything measured; the rest is drawn from it."""
_DPI = 150


def read(out: Path) -> Data:
    """Data of a study that was written to a folder, as it is or compressed.

    Raises
    ------
    InputError
        When the folder holds none.
    """
    file, compressed = out / RESULT, out / f"{RESULT}.gz"
    chosen = file if file.is_file() else compressed
    if not chosen.is_file():
        raise InputError("out", str(out), f"a folder with the {RESULT} of a study")
    data = read_record(chosen)
    if data.get("command") != "accuracy":
        raise InputError("out", str(out), f"a folder whose {RESULT} is that of a study of accuracy")
    return data


def write(data: Data, out: Path) -> Path:
    """Write data, tables, figures and the page.

    Returns
    -------
    Path
        The page.
    """
    out.mkdir(parents=True, exist_ok=True)
    write_whole(_compact(in_json(data)).encode(), out / RESULT)
    made = {table.name: table for table in (make(data) for make in tables.TABLES)}
    for table in made.values():
        table.write_csv(out)
    for problem in data["problems"]:
        _save(figures.error_against_cost, data, problem, out / f"error_{problem}.png")
        _save(figures.growth_against_stiffness, data, problem, out / f"growth_{problem}.png")
    page = out / "report.md"
    page.write_text("\n".join(_page(data, made)) + "\n", encoding="utf-8")
    return page


def _compact(data: Data) -> str:
    """JSON with a line for each run: small, and changes can be read."""
    parts = []
    for key, value in data.items():
        text = json.dumps(value, separators=(",", ":"), allow_nan=False)
        if isinstance(value, list) and value:
            items = (json.dumps(v, separators=(",", ":"), allow_nan=False) for v in value)
            text = "[\n" + ",\n".join(items) + "\n]"
        parts.append(f"{json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _save(draw: Callable[[Data, str], Figure], data: Data, problem: str, file: Path) -> None:
    draw(data, problem).savefig(file, dpi=_DPI)


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
    if data.get("still"):
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
        f"{machine['system']} {machine['machine']}, {machine['cpus']} processors; {versions}. "
        f"Study: {json.dumps(data['study'])}. All numbers: `{RESULT}`, `runs.csv`, `uses.csv`, "
        "`pareto.csv`.",
    ]
