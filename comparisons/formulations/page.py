"""The page of formulations: result.json, CSV files, figures, and one page that holds them all."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from cea.petsc import MPI
from comparisons.formulations import pairing_tables, words
from comparisons.formulations.figures import draw_locking, draw_pairings, draw_patch_test_errors
from comparisons.formulations.study import COMMAND
from comparisons.formulations.tables import (
    locking_table,
    momentum_table,
    paper_numbers,
    passes_table,
    patch_tests_table,
    times,
)
from comparisons.kit.page import REPORT, Image, write_page
from comparisons.kit.provenance import machine
from comparisons.kit.records import read_result
from comparisons.kit.tables import Data, Table

TEMPLATE = Path(__file__).with_name("page.html")

_FIGURES: dict[str, tuple[str, Callable[[Data, Path], Path]]] = {
    "patch_errors": ("patch_tests", draw_patch_test_errors),
    "locking": ("locking", draw_locking),
    "pairings": ("pairings", draw_pairings),
}
"""Figures by the stem of their file: the part of the data they show, and how it is drawn."""


def read_formulations(out: Path) -> dict[str, Any]:
    """Data that :func:`write_formulations` wrote.

    Raises
    ------
    InputError
        When the folder holds none.
    """
    return read_result(out, COMMAND)


def write_formulations(data: dict[str, Any], out: Path) -> Path:
    """Write data, tables, figures and the page, on rank 0; the others wait until it is written.

    Collective.

    Parameters
    ----------
    data
        What :func:`comparisons.formulations.study.run_formulations` found.
    out
        Folder for ``result.json``, CSV files, PNG files and ``report.html``.

    Returns
    -------
    Path
        The page: one file that needs no other.
    """
    MPI.COMM_WORLD.Barrier()  # ranks may still read what is written here
    if MPI.COMM_WORLD.rank == 0:
        images = {
            name: Image.of(draw(data[part], out / f"{name}.png"))
            for name, (part, draw) in _FIGURES.items()
        }
        write_page(TEMPLATE, data, tables_of(data), out, images=images, words=words)
    MPI.COMM_WORLD.Barrier()
    return out / REPORT


def tables_of(data: Data) -> list[Table]:
    """Every table of the page."""
    return [
        *(passes_table(data["patch_tests"], name) for name in words.interfaces(data)),
        patch_tests_table(data["patch_tests"]),
        momentum_table(data["patch_tests"]),
        locking_table(data["locking"]),
        paper_numbers(data),
        pairing_tables.pairing_runs(data),
        pairing_tables.pairing_differences(data),
        times(data),
        machine(data),
    ]
