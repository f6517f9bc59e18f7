"""What a map leaves behind: sweep.nc, tables, pictures, the page that holds them, the record."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cea.petsc import MPI
from comparisons.kit.page import REPORT, Image, write_page
from comparisons.kit.plots import save
from comparisons.sweep.map_figures import branches_figure, growth_figure
from comparisons.sweep.map_tables import (
    headline,
    modes_table,
    snapshots_table,
    summary_table,
    thresholds_table,
    values_table,
)
from comparisons.sweep.netcdf import write_map
from comparisons.sweep.rows import Row
from comparisons.sweep.sensitivities import sensitivities_figure, sensitivities_table

TEMPLATE = Path(__file__).with_name("map.html")
_PICTURES = 3
"""Rows of a map of two axes or more whose branches are drawn."""
_ON_PAGE = 500
"""Rows of a table that the page holds; its file holds all."""


def write_result(data: dict[str, Any], rows: Sequence[Row], out: Path) -> Path:
    """Write a map to a folder, on rank 0; the record last.

    Returns
    -------
    Path
        The page to open.
    """
    if MPI.COMM_WORLD.rank:
        return out / REPORT
    out.mkdir(parents=True, exist_ok=True)
    write_map(rows, data["axes"], out / "sweep.nc")
    values_table(data, rows).write_csv(out)
    if (modes := modes_table(data, rows)) is not None:
        modes.write_csv(out)
    images = {
        name: [Image.of(file) for file in files] for name, files in _draw(data, rows, out).items()
    }
    sensitivities = sensitivities_table(data, rows)
    tables = [thresholds_table(data), snapshots_table(data), summary_table(data), sensitivities]
    shown = [replace(table, rows=table.rows[:_ON_PAGE]) for table in tables]
    told = data | {"headline": headline(data)}
    page = write_page(TEMPLATE, told, shown, out, images=images)
    for table in tables:
        table.write_csv(out)
    return page


def _draw(data: dict[str, Any], rows: Sequence[Row], out: Path) -> dict[str, list[Path]]:
    """Pictures of branches and what moves them; of a map that of growth, and of a few rows."""
    made: dict[str, list[Path]] = {"growth": [], "sensitivities": []}
    if len(data["axes"]) == 1:
        drawn = [("", rows[0], "")]
        made["growth"].append(out / "sweep.png")
    else:
        second = data["axes"][1]
        further, count = len(rows) // len(second["values"]), len(second["values"])
        made["growth"].append(out / "map.png")
        save(growth_figure({"data": data, "rows": rows[::further]}), out / "map.png")
        drawn = [
            (f"_{i + 1}", rows[i * further], f" at {second['name']} = {second['values'][i]:.4g}")
            for i in sorted({0, count // 2, count - 1})[:_PICTURES]
        ]
        made["growth"] += [out / f"branches{ending}.png" for ending, _, _ in drawn]
    for (ending, row, at), file in zip(drawn, made["growth"][-len(drawn) :], strict=True):
        about = {"data": data, "row": row, "at": at}
        save(branches_figure(about), file)
        made["sensitivities"].append(out / f"sensitivities{ending}.png")
        save(sensitivities_figure(about), made["sensitivities"][-1])
    return made
