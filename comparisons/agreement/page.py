"""The report of a comparison: result.json, CSV files, figures, and one page that holds them all."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cea.files import write_whole
from cea.petsc import MPI
from comparisons.agreement import figures, tables, words
from comparisons.kit.page import Image, render
from comparisons.kit.plots import save
from comparisons.kit.provenance import machine
from comparisons.kit.records import RESULT
from scenes.results import ModesResult
from scenes.stored import write_record

TABLES = (
    tables.patch_test,
    tables.patch_stresses,
    tables.unstable_modes,
    tables.eigenvalues,
    tables.agreement,
    tables.windows,
    tables.disc_alone,
    tables.backend_differences,
    tables.disc_frequencies,
    tables.stage_times,
    tables.time_saved,
    tables.skipped,
    tables.parameters,
    machine,
)
"""Every table, those that only feed a figure too."""

TEMPLATE = Path(__file__).with_name("page.html")

_PICTURES = 1
"""Modes drawn of each result."""


def write_report(data: dict[str, Any], results: Mapping[str, ModesResult], out: Path) -> Path:
    """Write everything a comparison shows, on rank 0; the others wait until it is written.

    Collective: the pictures take part of their modes from every rank.

    Parameters
    ----------
    data
        What :func:`comparisons.agreement.study.compare` found.
    results
        Results whose most unstable mode is drawn.
    out
        Folder for ``result.json``, CSV files, PNG files and ``report.html``; files for ParaView
        of the modes drawn are in its folders ``paraview_<name of the result>``.

    Returns
    -------
    Path
        The page: one file that needs no other.
    """
    pictures = _pictures(results, out)
    from_files = _pictures_from_files(results, out)
    page = out / "report.html"
    if MPI.COMM_WORLD.rank == 0:
        _write(data, _images(pictures), _images(from_files), page)
    MPI.COMM_WORLD.Barrier()
    return page


def _write(
    data: dict[str, Any], pictures: list[Image], from_files: list[Image], page: Path
) -> None:
    """Write tables, figures, ``result.json`` and the page."""
    out = page.parent
    written = {table.name: table for table in (make(data) for make in TABLES)}
    for table in written.values():
        table.write_csv(out)
    images = {}
    for name, draw in figures.FIGURES.items():
        save(draw(data), out / f"{name}.png")
        images[name] = Image.of(out / f"{name}.png")
    write_record(
        data
        | {
            "tables": [f"{name}.csv" for name in written],
            "figures": [image.file for image in images.values()],
            "pictures": [image.file for image in pictures],
            "pictures_from_files": [image.file for image in from_files],
        },
        out / RESULT,
    )
    text = render(
        TEMPLATE,
        data=data,
        tables=written,
        images=images,
        pictures=pictures,
        from_files=from_files,
        words=words,
    )
    write_whole(text.encode(), page)


def _images(files: list[Path]) -> list[Image]:
    return [Image.of(file) for file in files]


def _pictures(results: Mapping[str, ModesResult], out: Path) -> list[Path]:
    if not results:
        return []
    from scenes.pictures import draw_modes

    return [file for result in results.values() for file in draw_modes(result, _PICTURES, out)]


def _pictures_from_files(results: Mapping[str, ModesResult], out: Path) -> list[Path]:
    """Write the modes drawn for ParaView, and draw what these files hold."""
    if not results:
        return []
    from comparisons.agreement.file_pictures import draw_files
    from scenes.paraview import write_paraview

    drawn = []
    for name, result in results.items():
        modes, contacts = write_paraview(result, _PICTURES, out / f"paraview_{name}")
        drawn.append(out / f"paraview_{name}.png")
        if MPI.COMM_WORLD.rank == 0:
            draw_files(modes, contacts, drawn[-1])
    return drawn
