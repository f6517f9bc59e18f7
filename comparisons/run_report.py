"""The report of one run, `cea run --report`: its record and the shapes of its modes on a page."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from cea.petsc import MPI
from comparisons.study.closing import PARAMETERS, machine, parameters, warned
from comparisons.study.numbers import growth, number, shown
from comparisons.study.page import REPORT, write
from comparisons.study.plots import VERDICT_MARKS, sign
from comparisons.study.result import Data
from comparisons.study.sections import Column, Plot, Section, Table, diagram
from comparisons.study.shapes import Shapes, by_importance
from scenes import Result
from scenes.results.record import read_record

_KEY, _MODES = "run", "rows of modes"
"""Key of the mode shapes on the page, and of the rows of modes added to the record."""


def write_run_report(result: Result, record: Path) -> Path:
    """Write the page of a run beside its record, with as many shapes as fit; collective."""
    shapes, rows = Shapes(), [] if result.spectrum is None else result.table()
    if rows and result.coupled is not None:
        shapes.add(_KEY, result, by_importance(result))
    if result.comm.rank == 0:
        data = read_record(record) | {_MODES: rows}
        title, text = data["scene"]["name"], data["scene"].get("description") or ""
        write(title, SECTIONS, data, record.parent, shapes=shapes, text=text, files=False)
    MPI.COMM_WORLD.Barrier()
    return record.with_name(REPORT)


_MODE = ["mode", "verdict", "frequency", "growth", "damping_ratio", "uncertainty", "residual"]


def modes(data: Data) -> pd.DataFrame:
    """All modes with verdicts and errors."""
    rows = [
        row | {"growth": row["growth_rate"], "shape": f"{_KEY}/{row['mode']}"}
        for row in data[_MODES]
    ]
    return pd.DataFrame(rows, columns=[*_MODE, "condition", "shape"])


def by_verdict(data: Data) -> pd.DataFrame:
    """All modes in the order of their verdicts, growing ones first."""
    order = [*VERDICT_MARKS].index
    return modes(data).sort_values("verdict", key=lambda v: v.map(order), kind="stable")


def stresses(data: Data) -> pd.DataFrame:
    """Normal stress along a line over each side of each contact of a static analysis."""
    return pd.DataFrame(
        [
            {"contact": name, "side": f"side {side}", "arc": arc, "stress": stress}
            for name, sides in data.get("stresses", {}).items()
            for side, sampled in sides.items()
            for arc, stress in zip(sampled["arc"], sampled["sigma_n_along"], strict=True)
        ]
    )


def contacts(data: Data) -> pd.DataFrame:
    """Numbers of found and missed points, area and largest gap of each contact."""
    rows = [
        (
            name,
            found["points"],
            found["status"].get("missed", 0),
            found["area"],
            found["largest_distance"],
        )
        for name, found in data.get("contacts", {}).items()
    ]
    return pd.DataFrame(rows, columns=["contact", "points", "missed", "area", "largest_gap"])


def _named(field: str, *columns: str) -> Callable[[Data], pd.DataFrame]:
    """Return a function that makes a frame of the names and values of a field."""
    return lambda data: pd.DataFrame(list(data[field].items()), columns=list(columns))


def summary(data: Data) -> str | None:
    """Number of growing modes, and the evidence that none is missing."""
    if "eigenvalues" not in data:
        return None
    mark = sign(data["verdict"]).removesuffix(data["verdict"])
    return f"{mark}{data['summary']}. Window: {data['window']['evidence']}."


def steady(data: Data) -> str | None:
    """Results of steady sliding in words; None without it."""
    from scenes.results.data import steady_lines

    return " ".join(steady_lines(data["steady_sliding"])) if "steady_sliding" in data else None


def size(data: Data) -> str:
    """Number of unknowns and run time in words."""
    return f"{number(data['dofs']['free'])} dofs took {number(data['seconds'], 3)} s."


COLUMNS = {
    "damping_ratio": Column("damping ratio", show=shown(3, sign=True)),
    "uncertainty": Column("algebraic error", "1/s", shown(2)),
    "growth": Column("growth rate", "1/s", growth),
    "arc": Column("along the surface", "m"),
    "stress": Column("σₙ", "N/m²"),
    "area": Column("area of side a", "m²", shown(4)),
    "largest_gap": Column("largest gap", "m", shown(2)),
}
_SHOWN = Table(
    "modes",
    "Every mode of the window. Damping ratio: minus the growth rate over abs(λ). Algebraic error: "
    "error of the growth rate from residual and rounding, times the condition number; cea converge "
    "estimates discretisation errors.",
    lambda data: modes(data).assign(verdict=modes(data)["verdict"].map(sign)),
    COLUMNS,
)
_DIAGRAM = diagram(
    "stability",
    "Modes above zero grow. Markers and colours both show the verdict.",
    by_verdict,
    ("verdict",),
    own=COLUMNS,
)
_STRESS = "Normal stress along a line over the contact, both sides."
_STRESSES = Plot("stress", _STRESS, stresses, "arc", "stress", ("side",), ("contact",), "", COLUMNS)
_CONTACTS = Table("contacts", "Contact points projected on the other side.", contacts, COLUMNS)
_STAGES = Table("stages", "", _named("timings", "stage", "seconds"))
_SKIPPED = Table("skipped", "Not needed by the scene.", _named("skipped", "left_out", "reason"))
_PARAMETERS = Table("parameters", PARAMETERS, lambda data: parameters([data]))
_VIEWER = (
    "A click on a point of the diagram, or on a number in the table, shows the mode; drag it to "
    "turn it, and move the phase or press play to see it vibrate."
)
SECTIONS = [
    Section("Warnings", tables=[Table("warnings", "Warnings that qualify the result.", warned)]),
    Section("Modes", _VIEWER, summary, [_SHOWN], [_DIAGRAM], modes=True),
    Section("Steady sliding", headline=steady),
    Section("Stresses", plots=[_STRESSES]),
    Section("Contacts", tables=[_CONTACTS]),
    Section("Run time", headline=size, tables=[_STAGES]),
    Section("Left out", tables=[_SKIPPED]),
    Section("Machine, versions, scene as run", tables=[Table("machine", "", machine), _PARAMETERS]),
]
