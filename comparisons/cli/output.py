"""Output of commands: progress, tables, results."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Literal

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from cea.errors import printable

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from comparisons.study.sections import Table as FrameTable
    from scenes import Result

console = Console(highlight=False)

_COLOURS = {"unstable": "bold red", "grows slowly": "red", "undecided": "yellow"}
_NEEDED = 4  # columns that are never left out

Column = tuple[str, Sequence[str], bool]
"""Heading, texts of cells, and whether they are numbers, which are never wrapped."""


class Working:
    """Progress line of a block of work."""

    def __init__(self, shown: "Progress", task: "TaskID") -> None:
        self._shown, self._task, self._step = shown, task, ""

    def stage(self, name: str) -> None:
        """Show the name of a stage of the current step."""
        words = f"{self._step}: {name}" if self._step else name
        self._shown.update(self._task, description=words)

    def step(self, name: str) -> None:
        """Begin a step, and count the one before it, if any, as done."""
        if self._step:
            self._shown.advance(self._task)
        self._step = name
        self._shown.update(self._task, description=name)


@contextmanager
def working(title: str, *, steps: int | None = None, to: Console = console) -> Iterator[Working]:
    """Show the progress of a block on a terminal: time elapsed, and left if ``steps`` are known."""
    from rich import progress

    columns = [progress.SpinnerColumn(), progress.TextColumn("{task.description}", markup=False)]
    if steps is not None:
        columns += [progress.BarColumn(), progress.MofNCompleteColumn()]
        columns.append(progress.TimeRemainingColumn())
    columns.append(progress.TimeElapsedColumn())
    hidden = not to.is_terminal
    with progress.Progress(*columns, console=to, transient=True, disable=hidden) as shown:
        yield Working(shown, shown.add_task(title, total=steps))


def print_frame(table: "FrameTable", result: Any, to: Console = console) -> None:
    """Print a table of a study, made from a result."""
    from comparisons.study.page import table_cells
    from comparisons.study.sections import rows

    made = table_cells(table, rows(table.frame, result))
    cells = [row["cells"] for row in made["rows"]]
    columns = [
        (head.axis, [str(row[i][0]) for row in cells], head.number)
        for i, (_, head) in enumerate(made["heads"])
    ]
    if cells:
        print_columns(to, columns, f"{table.name}.csv", title=table.caption)


def print_result(result: "Result", to: Console = console, *, explain: bool = False) -> None:
    """Print the result of a run: number of unstable modes, modes, warnings, what it left out."""
    if result.spectrum is None:
        say(to, str(result))
    else:
        _print_modes(result, to)
    print_warnings([warning.plain() for warning in result.warnings], to)
    print_skipped(result.skipped, to, explain=explain)


def print_skipped(
    skipped: Mapping[str, str], to: Console = console, *, explain: bool = False
) -> None:
    """Print what a run leaves out and which fields it does not use; reasons if ``explain``."""
    from scenes.checking.skipped import CHANGED, GIVEN

    labels = {GIVEN: "given, not used", CHANGED: "changed on reading"}
    named: dict[str, list[str]] = {}
    for name, reason in skipped.items():
        label = next((labels[start] for start in labels if reason.startswith(start)), None)
        if explain:
            say(to, f"{'' if label else 'left out: '}{name}: {reason}", "dim")
        else:
            named.setdefault(label or "left out, not needed", []).append(name)
    for label, names in named.items():
        say(to, f"{label}: {', '.join(names)}", "dim")


def print_warnings(warnings: Iterable[Mapping[str, Any]], to: Console = console) -> None:
    """Print warnings in the form in which records store them."""
    for warning in warnings:
        say(to, f"warning ({warning['kind']}): {warning['message']}", "yellow")


def say(to: Console, text: str, style: str | None = None) -> None:
    """Print text as it is, wrapped at words on a terminal."""
    to.print(printable(text), style=style, markup=False, soft_wrap=not to.is_terminal)


def _print_modes(result: "Result", to: Console) -> None:
    """Print the verdict, the unstable modes, all modes, and the evidence that none is missing."""
    from cea.mode_table import MARKS, SIGNS, TITLES, shown_cells

    rows = result.table()
    texts = shown_cells(rows)
    summary = f"{MARKS.get(result.verdict, '')} {result.summary}".strip()
    say(to, summary, _COLOURS.get(result.verdict))
    for hint in result.modes.window.hints:
        say(to, hint, "yellow")
    for cells in texts:
        if cells["verdict"] == "unstable":
            mode = f"{MARKS['unstable']} mode {cells['mode']}: {cells['frequency']} Hz"
            rates = f"{cells['growth_rate']} 1/s, damping ratio {cells['damping_ratio']}"
            say(to, f"{mode}, growth rate {rates}", _COLOURS["unstable"])
    if rows:
        marks, colours = ([of.get(row["verdict"], "") for row in rows] for of in (MARKS, _COLOURS))
        columns: list[Column] = [("", marks, False)]
        for name, title in TITLES.items():
            columns.append((title, [line[name] for line in texts], name != "verdict"))
        print_columns(to, columns, "result.json", colours)
        say(to, SIGNS)
        for line in result.steady_lines():
            say(to, line)
    say(to, f"window: {result.modes.window.evidence}")


def print_columns(
    to: Console,
    columns: Sequence[Column],
    file: str = "",
    styles: Sequence[str] = (),
    title: str = "",
) -> None:
    """Print a table; on a terminal, leave out last columns that do not fit.

    Text is wrapped at words, numbers are not; ``file`` is named as the one with all columns.
    """
    sizes, count = [_sizes(*column) for column in columns], len(columns)
    free = to.width - _least(sizes)
    while to.is_terminal and count > _NEEDED and free < 0:
        count -= 1
        free = to.width - _least(sizes[:count])
    table = Table(title=title or None, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for (heading, _, number), (least, most) in zip(columns[:count], sizes, strict=False):
        more = max(0, min(most - least, free)) if to.is_terminal else most - least
        free -= more
        if number:
            heading = "\n".join(wrap(heading, least, break_on_hyphens=False))
        justify: Literal["left", "right"] = "right" if number else "left"
        table.add_column(heading, justify=justify, no_wrap=number, width=least + more)
    for i, row in enumerate(zip(*(cells for _, cells, _ in columns[:count]), strict=True)):
        texts = [Text(printable(cell)) for cell in row]
        table.add_row(*texts, style=styles[i] if styles else None)
    width = max(to.width, sum(2 + (column.width or 0) for column in table.columns) + 1)
    room = Console(width=width, file=to.file, force_terminal=to.is_terminal, highlight=False)
    room.print(table, crop=False)
    if left_out := [heading for heading, _, _ in columns[count:]]:
        say(to, f"no room for: {', '.join(left_out)} (in {file})")


def _sizes(heading: str, cells: Sequence[str], number: bool) -> tuple[int, int]:
    """Least width of a column, with text wrapped at every word, and its unwrapped width."""
    words = cells if number else [word for cell in cells for word in cell.split()]
    least = max([1, *map(cell_len, words), *map(cell_len, heading.split())])
    return least, least if number else max(least, cell_len(heading), *map(cell_len, cells))


def _least(sizes: Sequence[tuple[int, int]]) -> int:
    """Least width of a table, with the blanks between columns."""
    return sum(least + 2 for least, _ in sizes) + 1
