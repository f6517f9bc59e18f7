"""Output of ``cea converge``: result.json, tables, scene files, a page."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from cea.eigen.classify import threshold_text
from cea.files import write_whole
from cea.petsc import MPI
from comparisons.converge.study import COMMAND
from comparisons.study.closing import machine, warned
from comparisons.study.columns import Column
from comparisons.study.numbers import number, shown
from comparisons.study.page import REPORT, write
from comparisons.study.plots import sign
from comparisons.study.result import RESULT, Data, read_result
from comparisons.study.sections import Section, Table
from scenes.results.record import write_record


def modes(data: Data) -> pd.DataFrame:
    """Return a row for each mode, with value, bars and verdict."""
    shown = ("frequency", "frequency_bar", "growth", "growth_bar", "backend", "estimates", "agree")
    return pd.DataFrame(
        [
            {"mode": i, "verdict": sign(mode["verdict"])} | {name: mode[name] for name in shown}
            for i, mode in enumerate(data["modes"], 1)
        ]
    )


def levels(data: Data) -> pd.DataFrame:
    """Return a row for each mesh, with error and time."""
    return pd.DataFrame(
        [
            {
                "backend": level["backend"],
                "degree": level["degree"] if level["file_degree"] is None else level["file_degree"],
                "layers": level["layers"],
                "elements": elements_text(level["elements"]),
                **{name: level[name] for name in ("dofs", "seconds", "worst")},
            }
            for level in data["levels"]
        ]
    )


def elements_text(elements: Mapping[str, Any]) -> str:
    """Describe the elements of all bodies."""
    parts = []
    for name, counts in elements.items():
        along = " × ".join(map(str, counts)) if isinstance(counts, list) else number(counts)
        parts.append(f"{name} {along}{' m' * isinstance(counts, float)}")
    return "; ".join(parts)


def threshold(data: Data) -> str:
    """State the growth rate above which a mode is unstable."""
    return f"Threshold: {threshold_text(data['growth_threshold'])}."


COLUMNS = {
    "frequency": Column("frequency", "Hz", shown(9)),
    "frequency_bar": Column("± bar", "Hz", shown(2)),
    "growth": Column("growth rate", "1/s", shown(6)),
    "growth_bar": Column("± bar", "1/s", shown(2)),
    "estimates": Column("estimates", show=number),
    "agree": Column("bars overlap"),
    "layers": Column("layers", show=number),
    "elements": Column("elements"),
    "worst": Column("worst error", show=shown(2)),
}
MODES = Table(
    "modes",
    "Modes with error bars. Unstable: growth above its bar and above the threshold; grows slowly: "
    "growth above its bar only; undecided: the bar contains zero.",
    modes,
    COLUMNS,
)
LEVELS = Table(
    "levels",
    "Every mesh. The error is the largest relative distance of lambda from the final values.",
    levels,
    COLUMNS,
)
SECTIONS = [
    Section(
        "Modes",
        headline=lambda data: f"{data['first']} {data['words']} {threshold(data)}",
        tables=[MODES],
    ),
    Section("Warnings", tables=[Table("warnings", "Warnings about the result.", warned)]),
    Section("Meshes", tables=[LEVELS]),
    Section("Machine and versions", tables=[Table("machine", "", machine)]),
]


def read_converge(out: Path) -> dict[str, Any]:
    """Read the data that :func:`write_converge` wrote; a folder without them is refused."""
    return read_result(out, COMMAND)


def write_converge(data: dict[str, Any], out: Path) -> Path:
    """Write the record, its tables, the scene files and the page on rank 0; collective."""
    if MPI.COMM_WORLD.rank == 0:
        for name, text in data["scenes"].items():
            write_whole(text.encode(), out / f"{name}.toml")
        write_record(data, out / RESULT)
        mortar = (
            f"Contact {name}: mortar instead of {method}, whose error does not decrease with mesh "
            "size."
            for name, method in data["mortar"].items()
        )
        title = f"{data['inputs']['scene']}: modes with error bars"
        write(title, SECTIONS, data, out, text=" ".join(mortar))
    MPI.COMM_WORLD.Barrier()
    return out / REPORT
