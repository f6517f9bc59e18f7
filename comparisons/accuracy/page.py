"""The page of a study: JSON, CSV files, figures and Markdown, all drawn from plain data."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from cea.files import write_whole
from comparisons.accuracy import figures, tables, words
from comparisons.accuracy.matrix import matrix_lines
from comparisons.accuracy.runner import COMMAND
from comparisons.kit.plots import png
from comparisons.kit.records import RESULT, read_result
from comparisons.kit.tables import Table
from scenes.results.record import write_record

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
    sections = list(_sections(data, made))
    contents = [f"- [{title}](#{_anchor(title)})" for title, _ in sections]
    text = ["# Error of flutter eigenvalues against run time", "", *_matrix(data, made)]
    text += ["## Contents", "", *contents, ""]
    for title, lines in sections:
        text += [f"## {title}", "", *lines]
    return text


def _matrix(data: Data, made: dict[str, Table]) -> list[str]:
    """What the page opens with: which formulation may be used at which stiffness."""
    return [
        "## Where each formulation may be used",
        "",
        *matrix_lines(data),
        words.verdict_rule(),
        "",
        words.in_short(data),
        "",
        *_files(made["matrix"], made["uses"]),
    ]


def _sections(data: Data, made: dict[str, Table]) -> Iterator[tuple[str, list[str]]]:
    """Titles and lines of all else."""
    if data.get("no_flutter"):
        lines = _bullets(words.without_flutter(data))
        yield "Where nothing may grow", [*lines, "", *_files(made["no_flutter"])]
    if data.get("finest"):
        yield "Finest meshes", [*_bullets(words.finest(data)), "", *_files(made["finest"])]
    for problem in data["problems"]:
        yield problem, _problem(data, problem)
    yield "Tables", _files(*(made[name] for name in ("runs", "pareto", "orders")))
    yield "Omissions", _omissions(data, made)
    yield "How it was measured", [words.how_measured(data), ""]
    yield "As run", _machine(data)


def _problem(data: Data, problem: str) -> list[str]:
    described = data["problems"][problem]
    low, high = described["band"]
    return [
        f"Exact eigenvalues with {low:g} <= Im lambda <= {high:g} rad/s, friction "
        f"{described['friction']}, p in units of {described['unit']:g} N/m³.",
        "",
        f"![error against run time and dofs](error_{problem}.png)",
        "",
        f"![error of growth against p](growth_{problem}.png)",
        "",
        "No other run is better in both error and time:",
        "",
        *_bullets(words.front(data, problem)),
        "",
    ]


def _anchor(title: str) -> str:
    """Address of a heading, as programs that show Markdown make it."""
    return title.lower().replace(" ", "-")


def _bullets(sentences: list[str]) -> list[str]:
    return [f"- {sentence}" for sentence in sentences]


def _files(*tables: Table) -> list[str]:
    """Tables in files of their own, each with what it shows."""
    return [*(f"- [{t.name}.csv]({t.name}.csv): {t.caption}" for t in tables), ""]


def _omissions(data: Data, made: dict[str, Table]) -> list[str]:
    parts = [made[name] for name in ("omissions", "incomplete")]
    if not any(table.rows for table in parts):
        return ["Nothing was left out and nothing failed.", ""]
    return [*_bullets([*words.reasons(data), words.lost(data)]), "", *_files(*parts)]


def _machine(data: Data) -> list[str]:
    versions = ", ".join(f"{name} {version}" for name, version in data["versions"].items())
    machine = data["machine"]
    return [
        f"{machine['system']} {machine['machine']}, {machine['cpus']} processors; {versions}; "
        f"commit {data['commit']}. "
        f"Study: {json.dumps(data['inputs']['study'])}. All numbers: `{RESULT}`, `runs.csv`.",
    ]
