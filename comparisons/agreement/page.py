"""The report of a comparison: result.json, CSV files, figures, and one page that holds them all."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cea.files import write_whole
from cea.petsc import MPI
from comparisons.agreement import figures, plots, tables, words
from comparisons.kit.page import REPORT, Image, render
from comparisons.kit.plots import save
from comparisons.kit.provenance import machine
from comparisons.kit.records import RESULT
from comparisons.kit.shapes import Shapes, by_importance
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


def write_report(data: dict[str, Any], results: Sequence[ModesResult], out: Path) -> Path:
    """Write everything a comparison shows, on rank 0; the others wait until it is written.

    Collective: pictures and shapes take part of their modes from every rank.

    Parameters
    ----------
    data
        What :func:`comparisons.agreement.study.compare` found.
    results
        Results of the runs of the disc and pad, in their order; none leaves shapes out.
    out
        Folder for ``result.json``, CSV files, PNG files and ``report.html``; files for ParaView
        of the modes drawn are in its folders ``paraview_<backend>``.

    Returns
    -------
    Path
        The page: one file that needs no other.
    """
    drawn = _drawn(data, results)
    pictures = _pictures(drawn, out)
    from_files = _pictures_from_files(drawn, out)
    shapes = _shapes(data, results)
    page = out / REPORT
    if MPI.COMM_WORLD.rank == 0:
        _write(data, _images(pictures), _images(from_files), shapes, page)
    MPI.COMM_WORLD.Barrier()
    return page


def _drawn(data: dict[str, Any], results: Sequence[ModesResult]) -> dict[str, ModesResult]:
    """Results whose most unstable mode is drawn, by backend: those with GPTS."""
    runs = data["disc_pad"]["runs"] if results else []
    return {
        run["backend"]: result
        for run, result in zip(runs, results, strict=True)
        if run["method"] == "gpts"
    }


def _shapes(data: dict[str, Any], results: Sequence[ModesResult]) -> Shapes:
    """Unstable and undecided modes of every run; runs of a backend share their bodies."""
    shapes, first = Shapes(), dict[str, str]()
    for i, result in enumerate(results):
        run = data["disc_pad"]["runs"][i]
        rows = result.table()
        chosen = [j for j in by_importance(result) if rows[j]["verdict"] != "stable"]
        key, title = str(i), plots.run_label(run)
        shapes.add(key, result, chosen, first.get(run["backend"]), title)
        first.setdefault(run["backend"], key)
    return shapes


def _write(
    data: dict[str, Any],
    pictures: list[Image],
    from_files: list[Image],
    shapes: Shapes,
    page: Path,
) -> None:
    """Write tables, figures, ``result.json`` and the page."""
    out = page.parent
    written = {table.name: table for table in (make(data) for make in TABLES)}
    for table in written.values():
        table.write_csv(out)
    for name, draw in figures.FIGURES.items():
        save(draw(data), out / f"{name}.png")
    write_record(
        data
        | {
            "tables": [f"{name}.csv" for name in written],
            "figures": [f"{name}.png" for name in figures.FIGURES],
            "pictures": [image.file for image in pictures],
            "pictures_from_files": [image.file for image in from_files],
        },
        out / RESULT,
    )
    text = render(
        TEMPLATE,
        plots=True,
        shapes=shapes if shapes.keys else None,
        data=data,
        tables=written,
        drawn=plots,
        pictures=pictures,
        from_files=from_files,
        words=words,
        first=_first(data, shapes),
        unstable_keys=_unstable_keys(data, shapes),
    )
    write_whole(text.encode(), page)


def _first(data: dict[str, Any], shapes: Shapes) -> str:
    """The mode that is shown when the page opens: the most unstable one with GPTS."""
    runs = data["disc_pad"]["runs"]
    ordered = sorted(shapes.modes, key=lambda key: runs[int(key)]["method"] != "gpts")
    return next((f"{key}/{number}" for key in ordered for number in shapes.modes[key]), "")


def _unstable_keys(data: dict[str, Any], shapes: Shapes) -> list[str]:
    """Modes that the rows of the table of unstable modes show, nothing where they have no shape."""
    keys = [
        f"{i}/{mode['mode']}"
        for i, run in enumerate(data["disc_pad"]["runs"])
        for mode in run["unstable"]
    ]
    return [key if key in shapes.keys else "" for key in keys]


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
