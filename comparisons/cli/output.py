"""What commands print: where they are, tables, modes."""

from typing import TYPE_CHECKING

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from comparisons.kit.tables import Table as ReportTable

if TYPE_CHECKING:
    from scenes.matrix_run import MatrixResult
    from scenes.results import ModesResult, StaticResult

console = Console()
_TABLE_WIDTH = 120


def print_table(table: ReportTable) -> None:
    """Print a table of a report."""
    shown = Table(title=table.caption, title_justify="left", box=SIMPLE_HEAD)
    for column in table.columns:
        unit = f" ({column.unit})" if column.unit else ""
        shown.add_column(
            column.title + unit, no_wrap=True, justify="right" if column.show else "left"
        )
    for cells in table.cells():
        shown.add_row(*cells)
    Console(width=max(console.width, _TABLE_WIDTH)).print(shown)


_COLOURS = {"unstable": "bold red", "undecided": "yellow", "stable": None}


def print_steady(result: "ModesResult | StaticResult") -> None:
    """Print what the contacts carry in steady sliding, where that was sought."""
    for line in result.steady_lines():
        console.print(line)


def print_modes(result: "ModesResult | MatrixResult") -> None:
    """Print the eigenvalues of a run, its verdict, what it must be read with, and why it is all."""
    from cea.eigen.mode_table import growth_text

    columns = ("mode", "frequency (Hz)", "growth rate (1/s)", "uncertainty", "residual")
    table = Table(*columns, "condition", "verdict")
    for mode in result.table():
        table.add_row(
            str(mode["mode"]),
            f"{mode['frequency']:.3f}",
            growth_text(mode["growth_rate"]),
            f"{mode['uncertainty']:.1e}",
            f"{mode['residual']:.1e}",
            f"{mode['condition']:.1f}",
            mode["verdict"],
            style=_COLOURS[mode["verdict"]],
        )
    console.print(table)
    typer.echo(result.modes.window.evidence)
    _print_warnings(result)
    console.print(f"verdict: {result.verdict}")


def print_stresses(result: "StaticResult") -> None:
    """Print the range of the normal stress on each side of each contact."""
    for row in result.table():
        console.print(
            f"{row['contact']}, side {row['side']}: sigma_n from {row['min']:.6g} to "
            f"{row['max']:.6g}, oscillation {row['oscillation']:.6g} N/m^2"
        )
    _print_warnings(result)


def _print_warnings(result: "ModesResult | StaticResult | MatrixResult") -> None:
    """Print what a result must be read with."""
    for warning in result.warnings:
        console.print(f"warning ({warning.kind}): {warning.message}", style="yellow")
