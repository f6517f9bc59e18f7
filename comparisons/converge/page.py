"""What ``cea converge`` leaves behind: result.json, tables, scene files, a page."""

from pathlib import Path
from typing import Any

from cea.eigen.classify import threshold_text
from cea.files import write_whole
from cea.petsc import MPI
from comparisons.converge.study import COMMAND
from comparisons.kit.interactive import sign
from comparisons.kit.numbers import MISSING, number, shown
from comparisons.kit.page import REPORT, write_page
from comparisons.kit.provenance import machine
from comparisons.kit.records import read_result
from comparisons.kit.tables import VERDICTS, Column, Data, Table
from scenes.spec.names import backend_name

TEMPLATE = Path(__file__).with_name("page.html")


def modes_table(data: Data) -> Table:
    """Every mode with value, bars and verdict."""
    rows = [
        (
            i,
            sign(mode["verdict"]),
            mode["frequency"],
            mode["frequency_bar"],
            mode["growth"],
            mode["growth_bar"],
            backend_name(mode["backend"]),
            mode["estimates"],
            MISSING if mode["agree"] is None else VERDICTS[mode["agree"]],
        )
        for i, mode in enumerate(data["modes"], 1)
    ]
    return Table(
        "modes",
        "Modes with error bars. Unstable: growth above its bar and above the "
        f"{threshold_text(data['growth_threshold'])}; it grows slowly above its bar alone; "
        "undecided where its bar holds zero.",
        (
            Column("mode", "mode", number),
            Column("verdict", "verdict"),
            Column("frequency", "frequency", shown(9), "Hz"),
            Column("frequency_bar", "± bar", shown(2), "Hz"),
            Column("growth", "growth rate", shown(6), "1/s"),
            Column("growth_bar", "± bar", shown(2), "1/s"),
            Column("backend", "value of"),
            Column("estimates", "estimates", number),
            Column("agree", "bars of both meet"),
        ),
        rows,
    )


def levels_table(data: Data) -> Table:
    """Every mesh with its error and time."""
    rows = [
        (
            backend_name(level["backend"]),
            level["degree"] if level["file_degree"] is None else level["file_degree"],
            level["layers"],
            elements_text(level["elements"]),
            level["dofs"],
            level["seconds"],
            VERDICTS[level["corrected"]],
            level["worst"],
        )
        for level in data["levels"]
    ]
    return Table(
        "levels",
        "Every mesh. Errors are the largest distances of lambda from the final values, relative; "
        "those of the meshes that gave the final values are their bars.",
        (
            Column("backend", "backend"),
            Column("degree", "degree", number),
            Column("layers", "layers", number),
            Column("elements", "elements"),
            Column("dofs", "dofs", number),
            Column("seconds", "time", shown(3), "s"),
            Column("corrected", "corrected"),
            Column("worst", "worst error", shown(2)),
        ),
        rows,
    )


def elements_text(elements: Data) -> str:
    """Elements of all bodies in words."""
    parts = []
    for name, counts in elements.items():
        along = " × ".join(map(str, counts)) if isinstance(counts, list) else number(counts)
        parts.append(f"{name} {along}{' m' * isinstance(counts, float)}")
    return "; ".join(parts)


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
        write_page(TEMPLATE, data, [modes_table(data), levels_table(data), machine(data)], out)
    MPI.COMM_WORLD.Barrier()
    return out / REPORT
