"""What ``cea converge`` leaves behind: result.json, tables, scene files, a page."""

from pathlib import Path
from typing import Any

from cea.files import write_whole
from cea.petsc import MPI
from comparisons.converge.study import COMMAND
from comparisons.converge.tables import TABLES
from comparisons.kit.page import REPORT, write_page
from comparisons.kit.provenance import machine
from comparisons.kit.records import read_result

TEMPLATE = Path(__file__).with_name("page.html")


def read_converge(out: Path) -> dict[str, Any]:
    """Data that :func:`write_converge` wrote; refused where the folder holds none."""
    return read_result(out, COMMAND)


def write_converge(data: dict[str, Any], out: Path) -> Path:
    """Write the record, its tables, the scene files and the page on rank 0; collective.

    Parameters
    ----------
    data
        What :func:`comparisons.converge.study.run_converge` found.
    out
        Folder for all of it.

    Returns
    -------
    Path
        The page.
    """
    if MPI.COMM_WORLD.rank == 0:
        for name, text in data["scenes"].items():
            write_whole(text.encode(), out / f"{name}.toml")
        write_page(TEMPLATE, data, [*(make(data) for make in TABLES), machine(data)], out)
    MPI.COMM_WORLD.Barrier()
    return out / REPORT
