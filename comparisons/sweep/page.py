"""What a sweep leaves behind: result.json, tables, a picture."""

from pathlib import Path
from typing import Any

from cea.petsc import MPI
from comparisons.kit.plots import save
from comparisons.kit.records import RESULT, read_result
from comparisons.sweep.figures import sweep_figure
from comparisons.sweep.study import COMMAND
from comparisons.sweep.tables import modes_table, unstable_table, values_table
from scenes.results.record import write_record


def read_sweep(out: Path) -> dict[str, Any]:
    """Data that :func:`write_sweep` wrote; refused where the folder holds none."""
    return read_result(out, COMMAND)


def write_sweep(data: dict[str, Any], out: Path) -> Path:
    """Write data, CSV files and the picture, on rank 0.

    Returns
    -------
    Path
        The picture.
    """
    picture = out / "sweep.png"
    if MPI.COMM_WORLD.rank == 0:
        write_record(data, out / RESULT)
        for table in (values_table(data), unstable_table(data), modes_table(data)):
            table.write_csv(out)
        save(sweep_figure(data), picture)
    return picture
