"""The page of stability: result.json, CSV files, heat maps, and one page that holds them all."""

from pathlib import Path
from typing import Any

from comparisons.kit.page import Image, write_page
from comparisons.kit.plots import save
from comparisons.kit.provenance import machine
from comparisons.kit.records import read_result
from comparisons.kit.tables import Data, Table
from comparisons.stability import words
from comparisons.stability.figures import digits_map
from comparisons.stability.study import COMMAND
from comparisons.stability.tables import cases_table, not_met_table, runs_table, subjects

TEMPLATE = Path(__file__).with_name("page.html")


def read_stability(out: Path) -> dict[str, Any]:
    """Data that :func:`write_stability` wrote.

    Raises
    ------
    InputError
        When the folder holds none.
    """
    return read_result(out, COMMAND)


def write_stability(data: dict[str, Any], out: Path) -> Path:
    """Write data, tables, heat maps and the page.

    Parameters
    ----------
    data
        What :func:`comparisons.stability.study.run_stability` found.
    out
        Folder for ``result.json``, CSV files, PNG files and ``report.html``.

    Returns
    -------
    Path
        The page: one file that needs no other.
    """
    images = {}
    for subject in subjects(data):
        file = out / f"digits_{subject.replace(' ', '_')}.png"
        save(digits_map(subject, data), file)
        images[subject] = Image.of(file)
    return write_page(TEMPLATE, data, tables_of(data), out, images=images, words=words)


def tables_of(data: Data) -> list[Table]:
    """Every table of the page."""
    return [cases_table(data), not_met_table(data), runs_table(data), machine(data)]
