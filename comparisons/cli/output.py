"""What commands print: where they are, tables, modes."""

from math import tau
from typing import Any

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from comparisons.kit.tables import Table as ReportTable

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


def print_modes(data: dict[str, Any]) -> None:
    """Print the eigenvalues of a run, the unstable ones set off, and why they are all."""
    table = Table("mode", "frequency (Hz)", "growth rate (1/s)", "residual", "condition")
    unstable = {mode["mode"] for mode in data["unstable"]}
    for i, mode in enumerate(data["eigenvalues"]):
        table.add_row(
            str(i + 1),
            f"{mode['im'] / tau:.3f}",
            f"{mode['re']:+.3f}",
            f"{mode['residual']:.1e}",
            f"{mode['condition']:.1f}",
            style="bold red" if i in unstable else None,
        )
    console.print(table)
    typer.echo(data["window"]["evidence"])


def print_stresses(data: dict[str, Any]) -> None:
    """Print the range of the normal stress on each side of each contact."""
    for name, sides in data["stresses"].items():
        for side, stress in sides.items():
            console.print(
                f"{name}, side {side}: sigma_n from {stress['min']:.6g} to {stress['max']:.6g}, "
                f"oscillation {stress['oscillation']:.6g} N/m^2"
            )
