"""Computed figures kept as JSON and CSV: drawing anew computes nothing while inputs are equal."""

import json
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from mpi4py import MPI

from comparisons.compare import Progress
from comparisons.figures.figure import Data, PaperFigure, numbers_table
from comparisons.report.tabular import Table
from comparisons.result import machine, versions, write_json
from comparisons.scene import Backend


@dataclass(frozen=True)
class MadeFigure:
    """A figure that was made.

    Parameters
    ----------
    numbers
        Numbers of the paper beside ours.
    note
        What a reader must know to compare them.
    data_file
        What was computed, JSON.
    pictures
        What was drawn.
    reused
        Whether stored data were drawn rather than computed.
    """

    numbers: Table
    note: str
    data_file: Path
    pictures: list[Path]
    reused: bool


def make_figure(
    figure: PaperFigure,
    backend: Backend,
    out: Path,
    progress: Progress,
    *,
    recompute: bool = False,
) -> MadeFigure:
    """Compute a figure, or take its stored data when their inputs are equal, and draw it.

    Parameters
    ----------
    figure
        The figure.
    backend
        Backend of every body.
    out
        Folder for ``figure_<name>_<backend>`` with endings .json, .csv and .png; rank 0 writes.
    progress
        Where progress is shown.
    recompute
        Whether stored data are left aside.
    """
    comm = MPI.COMM_WORLD
    stem = f"figure_{figure.name}_{backend}"
    file = out / f"{stem}.json"
    mark = fingerprint(figure.inputs(backend))
    stored = None
    if comm.rank == 0 and not recompute:
        stored = _stored(file, mark)
    data: Data | None = comm.bcast(stored)
    reused = data is not None
    if data is None:
        data = {
            "figure": figure.name,
            "title": figure.title,
            "backend": backend,
            "fingerprint": mark,
            "inputs": figure.inputs(backend),
            "versions": versions(),
            "machine": machine(),
        } | figure.compute(backend, progress)
        if comm.rank == 0:
            write_json(data, file)
    numbers = numbers_table(figure.numbers(data), stem, f"{figure.title}, {backend}")
    pictures: list[Path] = []
    if comm.rank == 0:
        progress.stage("drawing")
        for table in (numbers, *figure.tables(data, stem)):
            table.write_csv(out)
        pictures = figure.draw(data, out / stem)
    return MadeFigure(numbers, figure.note(data), file, pictures, reused)


def fingerprint(inputs: Data) -> str:
    """Digest of plain data, whatever the order of their fields."""
    text = json.dumps(inputs, sort_keys=True, allow_nan=False)
    return sha256(text.encode()).hexdigest()


def _stored(file: Path, mark: str) -> Data | None:
    """Stored data, None where there are none or other inputs made them."""
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except (FileNotFoundError, json.JSONDecodeError):
        return None
    return data if isinstance(data, dict) and data.get("fingerprint") == mark else None
