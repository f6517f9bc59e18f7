"""The page of one run: one file, made of its record and of the shapes of its modes."""

from pathlib import Path
from typing import Any

from cea.files import write_whole
from cea.petsc import MPI
from comparisons.kit.interactive import sign
from comparisons.kit.page import REPORT, render
from comparisons.kit.provenance import machine
from comparisons.kit.shapes import Shapes, by_importance
from comparisons.kit.tables import Table
from comparisons.run_report import plots, tables, words
from scenes import Result
from scenes.results.record import read_record
from scenes.results.result import steady_lines

TEMPLATE = Path(__file__).with_name("page.html")
_KEY = "run"
"""Name of the modes on the page."""


def write_run_report(result: Result, record: Path) -> Path:
    """Write the page of a run beside its record; collective, rank 0 writes.

    Parameters
    ----------
    result
        The run.
    record
        Its ``result.json``, as :func:`scenes.save_result` wrote it.

    Returns
    -------
    Path
        ``report.html``: one file that needs no other. It shows every mode on the diagram, and
        the shapes of as many as the page has room for, unstable ones first.
    """
    page = record.with_name(REPORT)
    shapes = Shapes()
    if result.spectrum is not None and result.coupled is not None:
        shapes.add(_KEY, result, by_importance(result))
    elif result.coupled is not None:
        shapes.add_bodies(_KEY, result)
    if result.comm.rank == 0:
        write_whole(_page(read_record(record), shapes).encode(), page)
    MPI.COMM_WORLD.Barrier()
    return page


def _page(data: dict[str, Any], shapes: Shapes) -> str:
    has_modes = "eigenvalues" in data
    made = {table.name: table for table in _tables(data, has_modes)}
    count = len(data.get("eigenvalues", ()))
    keys = [f"{_KEY}/{i}" for i in range(1, count + 1)]
    first = next(iter(shapes.modes.get(_KEY, {})), "")
    return render(
        TEMPLATE,
        plots=True,
        shapes=shapes if shapes.scenes else None,
        data=data,
        has_modes=has_modes,
        tables=made,
        words=words,
        sign=sign,
        key=_KEY,
        first=f"{_KEY}/{first}",
        mode_keys=[key if key in shapes.keys else "" for key in keys],
        stability=plots.stability(data, _KEY) if has_modes else None,
        stresses=plots.side_stresses(data) if "stresses" in data else [],
        stages=plots.stages(data),
        steady=steady_lines(data["steady_sliding"]) if "steady_sliding" in data else [],
    )


def _tables(data: dict[str, Any], has_modes: bool) -> list[Table]:
    made = [tables.skipped(data), tables.parameters(data), machine(data)]
    if has_modes:
        made.append(tables.modes(data))
    if "contacts" in data:
        made += [tables.bodies(data), tables.contacts(data)]
    return made
