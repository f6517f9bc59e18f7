"""What commands print: progress, tables, results."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rich.console import Console

from cea.errors import printable
from comparisons.cli.fitting import ShownColumn, blocks, total
from comparisons.kit.tables import Table as ReportTable

if TYPE_CHECKING:
    from comparisons.study.sections import Table as FrameTable
    from scenes import Result

console = Console(highlight=False)

_COLOURS = {"unstable": "bold red", "grows slowly": "red", "undecided": "yellow"}
_FIRST = ("mode", "frequency", "growth_rate", "damping_ratio", "verdict")
"""Columns of modes, the most important first; others follow where the terminal has room."""
_NEEDED = 3
"""Columns that are never left out."""


def width_of(console: Console) -> int | None:
    """Columns of a terminal; None where it is none: a file has room."""
    return console.width if console.is_terminal else None


def print_table(table: ReportTable, to: Console = console) -> None:
    """Print a table of a report; columns for which there is no room stand below the others.

    Parameters
    ----------
    table
        The table.
    to
        Where it is printed.
    """
    rows = table.cells()
    columns = [
        ShownColumn(
            f"{column.title} ({column.unit})" if column.unit else column.title,
            [printable(row[i]) for row in rows],
            column.show is not None,
        )
        for i, column in enumerate(table.columns)
    ]
    for i, block in enumerate(blocks(columns, width_of(to))):
        _print(block.table("" if i else table.caption), to)


def print_frame(table: "FrameTable", result: Any, to: Console = console) -> None:
    """Print a table of a study.

    Parameters
    ----------
    table
        The table.
    result
        What its frame is made of.
    to
        Where it is printed.
    """
    from comparisons.study.page import ShownTable

    made = ShownTable.of(replace(table, group=""), result)
    cells = [row["cells"] for _, rows in made.groups() for row in rows]
    columns = [
        ShownColumn(shown.axis, [printable(row[i][0]) for row in cells], head["number"])
        for i, ((_, shown), head) in enumerate(zip(made.columns, made.heads(), strict=True))
    ]
    for i, block in enumerate(blocks(columns, width_of(to)) if cells else ()):
        _print(block.table("" if i else table.caption), to)


def print_result(result: "Result", to: Console = console) -> None:
    """Print what a run found: first how many modes are unstable, last what it left out.

    Parameters
    ----------
    result
        The run.
    to
        Where it is printed.
    """
    if result.spectrum is None:
        say(to, str(result))
    else:
        _print_modes(result, to)
    print_warnings([warning.plain() for warning in result.warnings], to)
    _say_left_out(result.skipped, to)


def print_warnings(warnings: Iterable[Mapping[str, Any]], to: Console = console) -> None:
    """Print what a result must be read with.

    Parameters
    ----------
    warnings
        Warnings as a record has them.
    to
        Where they are printed.
    """
    for warning in warnings:
        say(to, f"warning ({warning['kind']}): {warning['message']}", "yellow")


def _say_left_out(skipped: Mapping[str, str], to: Console) -> None:
    """Name what the run did without; the reasons stand in result.json."""
    from scenes.checking.unused import GIVEN

    given = [name for name, reason in skipped.items() if reason.startswith(GIVEN)]
    others = [name for name in skipped if name not in given]
    for words, names in (("left out, not needed", others), ("given, not used", given)):
        if names:
            say(to, f"{words}: {', '.join(names)}", "dim")


def _print_modes(result: "Result", to: Console) -> None:
    """Print the verdict, the unstable modes, all modes, and why they are all."""
    from cea.mode_table import MARKS, SIGNS, TITLES, shown_cells

    rows = result.table()
    texts = shown_cells(rows)
    summary = f"{MARKS.get(result.verdict, '')} {result.summary}".strip()
    say(to, summary, _COLOURS.get(result.verdict))
    for hint in result.modes.hints:
        say(to, hint, "yellow")
    for index in result.most_unstable(len(rows)) if result.unstable.any() else ():
        cells = texts[index]
        say(
            to,
            f"{MARKS['unstable']} mode {cells['mode']}: {cells['frequency']} Hz, growth rate "
            f"{cells['growth_rate']} 1/s, damping ratio {cells['damping_ratio']}",
            _COLOURS["unstable"],
        )
    if not rows:
        say(to, f"window: {result.modes.window.evidence}")
        return
    names = [*_FIRST, *(name for name in TITLES if name not in _FIRST)]
    marks = ShownColumn("", [MARKS.get(row["verdict"], "") for row in rows], number=False)
    columns = [
        ShownColumn(TITLES[name], [line[name] for line in texts], name != "verdict")
        for name in names
    ]
    shown = _fitting([marks, *columns], width_of(to))
    (block,) = blocks(shown, None)
    _print(block.table(styles=[_COLOURS.get(row["verdict"]) for row in rows]), to)
    left_out = [TITLES[name] for name in names[len(shown) - 1 :]]
    if left_out:
        say(to, f"no room for: {', '.join(left_out)} (in result.json)")
    say(to, SIGNS)
    for line in result.steady_lines():
        say(to, line)
    say(to, f"window: {result.modes.window.evidence}")


def _fitting(columns: Sequence[ShownColumn], width: int | None) -> list[ShownColumn]:
    """The first columns, as many as fit beside each other, and those that are needed."""
    count = len(columns)
    while width is not None and count > 1 + _NEEDED:
        if total([column.natural for column in columns[:count]]) <= width:
            break
        count -= 1
    return list(columns[:count])


def _print(table: object, to: Console) -> None:
    """Print a table as wide as it is: a terminal wraps what a single number makes too wide."""
    room = Console(width=1 << 12, file=to.file, force_terminal=to.is_terminal, highlight=False)
    room.print(table, crop=False)


def say(to: Console, text: str, style: str | None = None) -> None:
    """Print text as it is, wrapped at words on a terminal."""
    to.print(printable(text), style=style, markup=False, soft_wrap=not to.is_terminal)
