"""Output of ``cea converge``: result.json, tables, scene files, a page."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from cea.files import write_whole
from cea.petsc import MPI
from comparisons.study.closing import machine, warned
from comparisons.study.columns import Column
from comparisons.study.numbers import plain, shown
from comparisons.study.page import REPORT, write
from comparisons.study.plots import sign
from comparisons.study.result import RESULT, Data
from comparisons.study.sections import Section, Table
from scenes.results.record import write_record


def modes(data: Data) -> pd.DataFrame:
    """Return a row for each mode, with value, bars and verdict."""
    shown = ("frequency", "frequency_bar", "growth", "growth_bar", "backend", "estimates", "agree")
    frame = pd.DataFrame(data["modes"], columns=["verdict", *shown])
    numbers = range(1, len(frame) + 1)
    return frame.assign(mode=numbers, verdict=frame["verdict"].map(sign))[["mode", *frame]]


def levels(data: Data) -> pd.DataFrame:
    """Return a row for each mesh, with error and time."""
    shown = ("backend", "degree", "layers", "elements", "dofs", "seconds", "worst")
    frame = pd.DataFrame(data["levels"], columns=[*shown, "file_degree"])
    degree = frame.pop("file_degree").fillna(frame["degree"]).astype(int)
    return frame.assign(degree=degree, elements=frame["elements"].map(_elements))


def _elements(counts: Mapping[str, Any]) -> str:
    """Describe the elements of all bodies."""
    parts = []
    for name, count in counts.items():
        along = " × ".join(map(str, count)) if isinstance(count, list) else plain(count)
        parts.append(f"{name} {along}")
    return "; ".join(parts)


COLUMNS = {
    "frequency": Column("frequency", "Hz", shown(9)),
    "frequency_bar": Column("± bar", "Hz", shown(2)),
    "growth": Column("growth rate", "1/s", shown(6)),
    "growth_bar": Column("± bar", "1/s", shown(2)),
    "agree": Column("bars overlap"),
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
    "Every mesh; worst is the largest relative distance of lambda from the final values, "
    "elements are those of each body by direction, their number, or their size (m).",
    levels,
    COLUMNS,
)
SECTIONS = [
    Section("Modes", headline=lambda data: f"{data['first']}; {data['words']}", tables=[MODES]),
    Section("Warnings", tables=[Table("warnings", "Warnings about the result.", warned)]),
    Section("Meshes", tables=[LEVELS]),
    Section("Machine and versions", tables=[Table("machine", "", machine)]),
]


def write_converge(data: dict[str, Any], out: Path) -> Path:
    """Write the record, its tables, the scene files and the page on rank 0; collective."""
    if MPI.COMM_WORLD.rank == 0:
        for name, text in data["scenes"].items():
            write_whole(text.encode(), out / f"{name}.toml")
        write_record(data, out / RESULT)
        mortar = (
            f"Contact {name}: mortar instead of {method}, whose error remains on fine meshes."
            for name, method in data["mortar"].items()
        )
        title = f"{data['inputs']['scene']}: modes with error bars"
        write(title, SECTIONS, data, out, text=" ".join(mortar))
    MPI.COMM_WORLD.Barrier()
    return out / REPORT
