"""Tables of modes with their bars and of every mesh."""

from math import floor, isfinite, log10

from cea.eigen.classify import threshold_text
from comparisons.kit.interactive import sign
from comparisons.kit.numbers import MISSING, number, shown
from comparisons.kit.tables import VERDICTS, Column, Data, Table
from scenes.spec.names import backend_name


def with_bar(value: float, bar: float | None) -> str:
    """A number with its error bar, to the digits that the bar leaves."""
    if bar is None or not isfinite(bar):
        return f"{value:.6g} ± ?"
    if bar == 0:
        return f"{value:.6g}"
    places = max(0, 1 - floor(log10(bar)))
    shown_bar = f"{bar:.1g}" if bar < 1 else f"{bar:.0f}"
    return f"{value:.{min(places, 12)}f} ± {shown_bar}"


def modes_table(data: Data) -> Table:
    """Every mode with value, bars and verdict."""
    rows = [
        (
            i,
            with_bar(mode["frequency"], mode["frequency_bar"]),
            with_bar(mode["growth"], mode["growth_bar"]),
            sign(mode["verdict"]),
            mode["frequency"],
            mode["frequency_bar"],
            mode["growth"],
            mode["growth_bar"],
            backend_name(mode["backend"]),
            mode["estimates"],
            MISSING if mode["agree"] is None else VERDICTS[mode["agree"]],
        )
        for i, mode in enumerate(data["modes"], 1)
    ]
    return Table(
        "modes",
        "Modes with error bars. Unstable: growth above its bar and above the "
        f"{threshold_text(data['growth_threshold'])}; it grows slowly above its bar alone; "
        "undecided where its bar holds zero.",
        (
            Column("mode", "mode", number),
            Column("frequency_with_bar", "frequency ± bar (Hz)"),
            Column("growth_with_bar", "growth rate ± bar (1/s)"),
            Column("verdict", "verdict"),
            Column("frequency", "frequency", shown(8), "Hz"),
            Column("frequency_bar", "bar", shown(2), "Hz"),
            Column("growth", "growth rate", shown(6), "1/s"),
            Column("growth_bar", "bar", shown(2), "1/s"),
            Column("backend", "value of"),
            Column("estimates", "estimates", number),
            Column("agree", "bars of both meet"),
        ),
        rows,
    )


def levels_table(data: Data) -> Table:
    """Every mesh with its error and time."""
    rows = [
        (
            backend_name(level["backend"]),
            level["degree"] if level["file_degree"] is None else level["file_degree"],
            level["layers"],
            elements_text(level["elements"]),
            level["dofs"],
            level["seconds"],
            VERDICTS[level["corrected"]],
            level["worst"],
        )
        for level in data["levels"]
    ]
    return Table(
        "levels",
        "Every mesh. Errors are the largest distances of lambda from the final values, relative; "
        "those of the meshes that gave the final values are their bars.",
        (
            Column("backend", "backend"),
            Column("degree", "degree", number),
            Column("layers", "layers", number),
            Column("elements", "elements"),
            Column("dofs", "dofs", number),
            Column("seconds", "time", shown(3), "s"),
            Column("corrected", "corrected"),
            Column("worst", "worst error", shown(2)),
        ),
        rows,
    )


def elements_text(elements: Data) -> str:
    """Elements of all bodies in words."""
    parts = []
    for name, counts in elements.items():
        along = " × ".join(map(str, counts)) if isinstance(counts, list) else number(counts)
        parts.append(f"{name} {along}{' m' * isinstance(counts, float)}")
    return "; ".join(parts)


TABLES = (modes_table, levels_table)
"""What makes the tables of a record."""
