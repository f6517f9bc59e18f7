"""Computed figures kept as JSON and CSV: drawing anew computes nothing while inputs are equal.

Data are looked for in the folder that is written to, then among those that come with the project.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from time import perf_counter

from cea.errors import InputError
from cea.petsc import MPI
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Table
from comparisons.paper.common.figure import Data, PaperFigure, numbers_table
from scenes.results.record import read_record, record, write_record
from scenes.spec.body import Backend

STORED = Path(__file__).parents[1] / "results"
"""Data that come with the project."""

COMMAND = "figure"
"""Command that a record is marked with."""


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
        What was computed, compressed JSON.
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


@dataclass(frozen=True)
class KeptData:
    """Data of a figure.

    Parameters
    ----------
    file
        Where they are stored, compressed JSON.
    data
        What was computed.
    reused
        Whether they were stored before.
    """

    file: Path
    data: Data
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
        Folder for ``figure_<name>_<backend>`` with endings .json.gz, .csv and .png; rank 0 writes.
    progress
        Where progress is shown.
    recompute
        Whether stored data are left aside.
    """
    kept = figure_data(figure, backend, out, progress, recompute=recompute)
    stem, data = stem_of(figure, backend), kept.data
    numbers = numbers_table(figure.numbers(data), stem, f"{figure.title}, {backend}")
    pictures: list[Path] = []
    if MPI.COMM_WORLD.rank == 0:
        progress.stage("drawing")
        for table in (numbers, *figure.tables(data, stem)):
            table.write_csv(out)
        pictures = figure.draw(data, out / stem)
    return MadeFigure(numbers, figure.note(data), kept.file, pictures, kept.reused)


def stem_of(figure: PaperFigure, backend: Backend) -> str:
    """Beginning of the names of the files of a figure."""
    return f"figure_{figure.name}_{backend}"


def figure_data(
    figure: PaperFigure,
    backend: Backend,
    out: Path,
    progress: Progress,
    *,
    recompute: bool = False,
) -> KeptData:
    """Data of a figure, stored ones where their inputs are equal; nothing is drawn.

    Parameters are those of :func:`make_figure`; what is computed is written by rank 0.
    """
    comm = MPI.COMM_WORLD
    file = out / f"{stem_of(figure, backend)}.json.gz"
    mark = fingerprint(figure.inputs(backend))
    found: tuple[Path, Data] | None = None
    if comm.rank == 0 and not recompute:
        found = _found((file, STORED / file.name), mark)
    found = comm.bcast(found)
    if found is not None:
        return KeptData(found[0], found[1], reused=True)
    data = _computed(figure, backend, mark, progress)
    if comm.rank == 0:
        write_record(data, file)
    return KeptData(file, data, reused=False)


def _computed(figure: PaperFigure, backend: Backend, mark: str, progress: Progress) -> Data:
    """Record of a figure that was computed."""
    start = perf_counter()
    described = {
        "figure": figure.name,
        "title": figure.title,
        "backend": backend,
        "fingerprint": mark,
    }
    data = described | figure.compute(backend, progress)
    seconds = perf_counter() - start
    return record(COMMAND, data, inputs=figure.inputs(backend), seconds=seconds)


def fingerprint(inputs: Data) -> str:
    """Digest of plain data, whatever the order of their fields."""
    text = json.dumps(inputs, sort_keys=True, allow_nan=False)
    return sha256(text.encode()).hexdigest()


def _found(files: Iterable[Path], mark: str) -> tuple[Path, Data] | None:
    """The first file with data that equal inputs made, and the data."""
    for file in files:
        try:
            data = read_record(file)
        except InputError:
            continue  # there is none, or it is broken
        if data.get("fingerprint") == mark:
            return file, data
    return None
