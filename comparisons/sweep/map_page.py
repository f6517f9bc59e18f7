"""What a map leaves behind: sweep.nc, tables, pictures, and the record, which is written last."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cea.petsc import MPI
from comparisons.kit.plots import save
from comparisons.kit.records import RESULT
from comparisons.sweep.map_figures import branches_figure, growth_figure
from comparisons.sweep.map_tables import modes_table, onsets_table, snapshots_table, values_table
from comparisons.sweep.netcdf import write_map
from comparisons.sweep.rows import Row
from scenes.stored import write_record

_PICTURES = 3
"""Rows of a map of two axes or more whose branches are drawn."""


def write_result(data: dict[str, Any], rows: Sequence[Row], out: Path) -> Path:
    """Write a map to a folder, on rank 0.

    Returns
    -------
    Path
        The picture to open.
    """
    wide = len(data["axes"]) > 1
    picture = out / ("map.png" if wide else "sweep.png")
    if MPI.COMM_WORLD.rank:
        return picture
    out.mkdir(parents=True, exist_ok=True)
    write_map(rows, data["axes"], out / "sweep.nc")
    tables = [values_table(data, rows), onsets_table(data), snapshots_table(data)]
    if (modes := modes_table(data, rows)) is not None:
        tables.append(modes)
    for table in tables:
        table.write_csv(out)
    _draw(data, rows, out)
    write_record(data, out / RESULT)
    return picture


def _draw(data: dict[str, Any], rows: Sequence[Row], out: Path) -> None:
    """One picture of branches; of a map that of growth, and branches of a few rows."""
    if len(data["axes"]) == 1:
        save(branches_figure({"data": data, "row": rows[0], "at": ""}), out / "sweep.png")
        return
    second = data["axes"][1]
    further = len(rows) // len(second["values"])
    save(growth_figure({"data": data, "rows": rows[::further]}), out / "map.png")
    count = len(second["values"])
    for number in sorted({0, count // 2, count - 1})[:_PICTURES]:
        at = f" at {second['name']} = {second['values'][number]:.4g}"
        drawn = {"data": data, "row": rows[number * further], "at": at}
        save(branches_figure(drawn), out / f"branches_{number + 1}.png")
