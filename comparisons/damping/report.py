"""What the study of damping writes: result.json, a table, a figure."""

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from cea.petsc import MPI
from comparisons.damping.study import COMMAND, SHARES, dampings, exact_threshold
from comparisons.kit.numbers import number, shown
from comparisons.kit.plots import AXIS, BLUE, GREEN, MARKERS, VERMILION, save, styled
from comparisons.kit.records import RESULT, read_result
from comparisons.kit.tables import Column, Data, Table
from scenes.names import backend_name
from scenes.stored import write_record

_COLOURS = dict(zip(SHARES, (BLUE, GREEN, VERMILION), strict=True))
_SMOOTH = 60
"""Points of each exact curve."""


def write_damping(data: dict[str, Any], out: Path) -> Path:
    """Write data, table and figure on rank 0; the others wait until it is written. Collective.

    Parameters
    ----------
    data
        What :func:`comparisons.damping.study.run_damping` found.
    out
        Folder for ``result.json``, ``damping.csv`` and ``damping.png``.

    Returns
    -------
    Path
        The figure.
    """
    file = out / "damping.png"
    if MPI.COMM_WORLD.rank == 0:
        write_record(data, out / RESULT)
        thresholds_table(data).write_csv(out)
        save(draw_thresholds(data), file)
    MPI.COMM_WORLD.Barrier()
    return file


def read_damping(out: Path) -> dict[str, Any]:
    """Data that :func:`write_damping` wrote.

    Raises
    ------
    InputError
        When the folder holds none.
    """
    return read_result(out, COMMAND)


def shared_words(share: float) -> str:
    """How damping is shared out, in words."""
    return "both modes alike" if share == 1 else f"the second mode {share:g} times the first"


def thresholds_table(data: Data) -> Table:
    """Thresholds of every system: exact, and of each backend with its relative error."""
    backends = [name for name in MARKERS if name in data["rows"][0]]
    columns = [
        Column("damped", "damped"),
        Column("ratio", "damping ratio", number),
        Column("exact", "exact", shown(8)),
    ]
    for name in backends:
        columns.append(Column(name, backend_name(name), shown(8)))
        columns.append(Column(f"error_{name}", "error", shown(1)))
    rows = [
        (
            shared_words(row["share"]),
            row["ratio"],
            row["exact"],
            *(x for name in backends for x in (row[name], abs(row[name] / row["exact"] - 1))),
        )
        for row in data["rows"]
    ]
    undamped = number(data["undamped"])
    caption = f"Friction at which flutter begins; undamped {undamped}"
    return Table("damping", caption, tuple(columns), rows)


@styled
def draw_thresholds(data: Data) -> Figure:
    """Draw thresholds against the mean damping ratio: lines exact, markers elastic bodies."""
    figure = Figure(figsize=(5.2, 3.6), layout="constrained")
    axes = figure.add_subplot()
    shares = list(dict.fromkeys(row["share"] for row in data["rows"]))
    for share in shares:
        rows = [row for row in data["rows"] if row["share"] == share]
        colour = _COLOURS.get(share, AXIS)
        ratios, exact = _exact_curve(share, [row["ratio"] for row in rows])
        axes.plot(ratios, exact, color=colour, linewidth=1.2, label=shared_words(share))
        for backend, marker in MARKERS.items():
            if backend in rows[0]:
                axes.plot(
                    [row["ratio"] for row in rows],
                    [row[backend] for row in rows],
                    marker,
                    color=colour,
                    markerfacecolor="none" if backend == "fe" else colour,
                    markersize=6 if backend == "fe" else 3,
                )
    axes.axhline(data["undamped"], color=AXIS, linewidth=0.8, linestyle=":", label="undamped")
    axes.set(xscale="log", xlabel="mean damping ratio", ylabel="friction at which flutter begins")
    axes.set_title("Lines: exact, two degrees of freedom. Squares: Lagrange, dots: NURBS")
    axes.legend(title="damped")
    return figure


def _exact_curve(share: float, ratios: list[float]) -> tuple[list[float], list[float]]:
    """Thresholds of the lumped system over the range of some damping ratios."""
    low, high = min(ratios), max(ratios)
    steps = [low * (high / low) ** (i / (_SMOOTH - 1)) for i in range(_SMOOTH)]
    return steps, [exact_threshold(*dampings(share, ratio)) for ratio in steps]
