"""What the study of the brake leaves behind: result.json, tables, a figure."""

from pathlib import Path
from typing import Any

from cea.petsc import MPI
from comparisons.brake.figures import brake_figure
from comparisons.brake.study import COMMAND
from comparisons.brake.tables import modes_table, runs_table, stiffness_table, unstable_table
from comparisons.kit.plots import save
from comparisons.kit.records import RESULT, read_result
from scenes.stored import write_record


def read_brake(out: Path) -> dict[str, Any]:
    """Data that :func:`write_brake` wrote; refused where the folder holds none."""
    return read_result(out, COMMAND)


def write_brake(data: dict[str, Any], out: Path) -> Path:
    """Write data, CSV files and the figure on rank 0; the others wait. Collective.

    Returns
    -------
    Path
        The figure.
    """
    figure = out / "brake.png"
    MPI.COMM_WORLD.Barrier()  # ranks may still read what is written here
    if MPI.COMM_WORLD.rank == 0:
        write_record(data, out / RESULT)
        for make in (runs_table, modes_table, unstable_table, stiffness_table):
            make(data).write_csv(out)
        save(brake_figure(data), figure)
    MPI.COMM_WORLD.Barrier()
    return figure
