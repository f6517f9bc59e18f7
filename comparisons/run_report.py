"""The report of one run, `cea run --report`: its record and the shapes of its modes on a page."""

from math import hypot, tau
from pathlib import Path

import pandas as pd

from cea.petsc import MPI
from comparisons.study.closing import PARAMETERS, machine, parameters, warned
from comparisons.study.numbers import growth, number, shown
from comparisons.study.page import REPORT, write
from comparisons.study.plots import VERDICT_MARKS, sign
from comparisons.study.result import Data
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.shapes import Shapes, by_importance
from scenes import Result
from scenes.results.record import read_record

_KEY = "run"
"""Name of the modes on the page."""


def write_run_report(result: Result, record: Path) -> Path:
    """Write the page of a run beside its ``result.json``; collective, rank 0 writes.

    It shows every mode on the diagram, and the shapes of as many as there is room for, unstable
    ones first.
    """
    shapes = Shapes()
    if result.spectrum is not None and result.coupled is not None:
        shapes.add(_KEY, result, by_importance(result))
    if result.comm.rank == 0:
        data = read_record(record)
        title, text = data["scene"]["name"], data["scene"].get("description") or ""
        write(title, SECTIONS, data, record.parent, shapes=shapes, text=text, files=False)
    MPI.COMM_WORLD.Barrier()
    return record.with_name(REPORT)


_ERRORS = ["uncertainty", "residual", "condition"]
_MODE = ["mode", "verdict", "frequency", "growth", "damping_ratio", *_ERRORS, "shape"]


def modes(data: Data) -> pd.DataFrame:
    """Every mode with its verdict and errors."""
    rows = []
    for i, value in enumerate(data.get("eigenvalues", ()), 1):
        errors = [value[name] for name in _ERRORS]
        frequency, growth = value["im"] / tau, value["re"]
        ratio = damping_ratio(value)
        rows.append((i, value["verdict"], frequency, growth, ratio, *errors, f"{_KEY}/{i}"))
    return pd.DataFrame(rows, columns=_MODE)


def by_verdict(data: Data) -> pd.DataFrame:
    """The same, those that grow first."""
    order = [*VERDICT_MARKS].index
    return modes(data).sort_values("verdict", key=lambda v: v.map(order), kind="stable")


def damping_ratio(value: Data) -> float | None:
    """Minus the growth rate over abs(lambda); None of a mode that stands still."""
    size = hypot(value["re"], value["im"])
    return 0.0 - value["re"] / size if size else None


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
    """Contact points as they were found on the other side."""
    return pd.DataFrame(
        [
            {
                "contact": name,
                "points": found["points"],
                "missed": found["status"].get("missed", 0),
                "area": found["area"],
                "largest_gap": found["largest_distance"],
            }
            for name, found in data.get("contacts", {}).items()
        ]
    )


def _named(values: Data, *columns: str) -> pd.DataFrame:
    return pd.DataFrame(list(values.items()), columns=list(columns))


def summary(data: Data) -> str | None:
    """How many modes grow, and why they are all."""
    if "eigenvalues" not in data:
        return None
    mark = sign(data["verdict"]).removesuffix(data["verdict"])
    return f"{mark}{data['summary']}. Window: {data['window']['evidence']}."


def steady(data: Data) -> str | None:
    """What steady sliding found."""
    from scenes.results.data import steady_lines

    return " ".join(steady_lines(data["steady_sliding"])) if "steady_sliding" in data else None


def size(data: Data) -> str:
    """Unknowns and run time."""
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
SECTIONS = [
    Section("Warnings", tables=[Table("warnings", "To be read with the result.", warned)]),
    Section(
        "Modes",
        "A click on a point of the diagram, or on a number in the table, shows the mode; drag it "
        "to turn it, and move the phase or press play to see it vibrate.",
        summary,
        [
            Table(
                "modes",
                "Every mode of the window. Damping ratio: minus the growth rate over abs(λ). "
                "Algebraic error: what residual and rounding, times the condition, can make of the "
                "growth rate; errors of the mesh are told by cea converge.",
                lambda data: modes(data).assign(verdict=modes(data)["verdict"].map(sign)),
                COLUMNS,
            )
        ],
        [
            Plot(
                "stability",
                "What lies above zero grows. Marks tell verdicts apart as colours do.",
                by_verdict,
                "frequency",
                "growth",
                ("verdict",),
                own=COLUMNS,
                style="markers",
            )
        ],
        modes=True,
    ),
    Section("Steady sliding", headline=steady),
    Section(
        "Stresses",
        plots=[
            Plot(
                "stress",
                "Normal stress along a line over the contact, both sides.",
                stresses,
                "arc",
                "stress",
                ("side",),
                ("contact",),
                own=COLUMNS,
            )
        ],
    ),
    Section(
        "Contacts",
        tables=[Table("contacts", "Points as found on the other side.", contacts, COLUMNS)],
    ),
    Section(
        "Run time",
        headline=size,
        tables=[Table("stages", "", lambda data: _named(data["timings"], "stage", "seconds"))],
    ),
    Section(
        "Left out",
        tables=[
            Table(
                "skipped",
                "Not needed by the scene.",
                lambda data: _named(data["skipped"], "left_out", "reason"),
            )
        ],
    ),
    Section(
        "Machine, versions, scene as run",
        tables=[
            Table("machine", "", machine),
            Table("parameters", PARAMETERS, lambda data: parameters([data])),
        ],
    ),
]
