"""Tables of modes with their bars, of orders, of every mesh, of tolerances."""

from math import floor, isfinite, log10
from typing import Any

from cea.eigen.classify import threshold_text
from comparisons.converge.request import half_unit
from comparisons.kit.interactive import sign
from comparisons.kit.numbers import MISSING, decimals, number, shown
from comparisons.kit.tables import VERDICTS, Column, Data, Table
from scenes.names import backend_name

SINGULAR_RATE = 0.65
"""Observed order over that of theory below which a mode converges as a singular one."""


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
    rows = []
    for i, mode in enumerate(data["modes"], 1):
        agree = mode["agree"]
        rows.append(
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
                MISSING if agree is None else VERDICTS[agree],
            )
        )
    return Table(
        "modes",
        "Modes with error bars. Unstable: growth above its bar and above the "
        f"{threshold_text(data.get('growth_threshold'))}; it grows slowly above its bar alone; "
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
            Column("agree", "backends agree"),
        ),
        rows,
    )


def orders_table(data: Data) -> Table:
    """Observed order over that of theory, mode by mode, and what both backends say."""
    rows: list[tuple[Any, ...]] = []
    for i, mode in enumerate(data["modes"], 1):
        for backend, of in mode["of"].items():
            rate = of["rate"]
            rows.append(
                (
                    i,
                    backend_name(backend),
                    with_bar(of["frequency"], of["frequency_bar"]),
                    with_bar(of["growth"], of["growth_bar"]),
                    rate,
                    "not seen"
                    if rate is None
                    else "singular"
                    if rate < SINGULAR_RATE
                    else "smooth",
                )
            )
    return Table(
        "orders",
        "Observed order of each mode on each backend, over the order of theory; below "
        f"{SINGULAR_RATE} a mode is called singular. Where none is seen the bar is the largest of "
        "the last differences.",
        (
            Column("mode", "mode", number),
            Column("backend", "backend"),
            Column("frequency", "frequency ± bar (Hz)"),
            Column("growth", "growth rate ± bar (1/s)"),
            Column("rate", "order / theory", shown(2)),
            Column("kind", "converges"),
        ),
        rows,
    )


def levels_table(data: Data) -> Table:
    """Every mesh with its error and time."""
    rows = [
        (
            backend_name(level["backend"]),
            "corrected" if level["corrected"] else "run",
            degree_text(level),
            level["density"],
            layers_text(level),
            elements_text(level["elements"]),
            level["dofs"],
            level["seconds"],
            level["worst"],
            level["median"],
            level["missing"],
            "yes" if i in front_of(data) else "",
        )
        for i, level in enumerate(data["levels"])
    ]
    return Table(
        "levels",
        "Every mesh; corrected ones are no runs but the mesh before in a richer space. Errors are "
        "distances of lambda from the final values, relative; of the mesh that gave these they are "
        "not known by this, their bars are.",
        (
            Column("backend", "backend"),
            Column("kind", "kind"),
            Column("degree", "degree"),
            Column("density", "density", shown(3)),
            Column("layers", "layers"),
            Column("elements", "elements"),
            Column("dofs", "dofs", number),
            Column("seconds", "time", shown(3), "s"),
            Column("worst", "worst error", shown(2)),
            Column("median", "median error", shown(2)),
            Column("missing", "modes missing", number),
            Column("pareto", "on the front"),
        ),
        rows,
    )


def degree_text(mesh: Data) -> str:
    """Degree of a mesh, of each body where they differ."""
    return _of_bodies(mesh["degree"], mesh.get("degrees", {}))


def layers_text(mesh: Data) -> str:
    """Layers of a mesh towards edges, of each body where they differ."""
    return _of_bodies(mesh["layers"], mesh.get("layers_of", {}))


def _of_bodies(whole: int, own: Data) -> str:
    if len(set(own.values())) < 2:
        return str(whole)
    return ", ".join(f"{name} {value}" for name, value in own.items())


def owed_table(data: Data) -> Table:
    """What each body and direction was measured to owe to the errors of a mesh."""
    rows = [
        (
            backend_name(backend),
            part["body"],
            "edges" if part["edges"] else ", ".join(part["directions"]),
            part["median"],
            part["worst"],
        )
        for backend, of in data["backends"].items()
        for part in of["owed"]
    ]
    return Table(
        "owed",
        "What each body and direction owes to the relative errors of lambda on the first mesh, "
        "measured in spaces richer there alone; the next meshes are made by it.",
        (
            Column("backend", "backend"),
            Column("body", "body"),
            Column("direction", "direction"),
            Column("median", "median error", shown(2)),
            Column("worst", "worst error", shown(2)),
        ),
        rows,
    )


def elements_text(elements: Data) -> str:
    """Elements of all bodies in words."""
    parts = []
    for name, counts in elements.items():
        along = " × ".join(map(str, counts)) if isinstance(counts, list) else f"size {counts:.3g} m"
        parts.append(f"{name} {along}")
    return "; ".join(parts)


def floor_of(data: Data) -> float:
    """Largest relative bar of the final values: errors below it are not told apart."""
    bars = [
        mode["frequency_bar"] / mode["frequency"]
        for mode in data["modes"]
        if mode["frequency_bar"] is not None and mode["frequency"] > 0 and not mode["rigid"]
    ]
    return max(bars, default=0.0)


def error_of(data: Data, level: Data) -> float | None:
    """Worst relative error of a mesh, no less than the final values are known to."""
    if level["worst"] is None:
        return None
    return max(float(level["worst"]), floor_of(data))


def front_of(data: Data) -> list[int]:
    """Meshes that no other beats in both error and time."""
    errors = [error_of(data, level) for level in data["levels"]]
    times = [level["seconds"] for level in data["levels"]]
    front = []
    for i, (error, seconds) in enumerate(zip(errors, times, strict=True)):
        if error is None:
            continue
        beaten = any(
            e is not None and j != i and (e, t) != (error, seconds) and e <= error and t <= seconds
            for j, (e, t) in enumerate(zip(errors, times, strict=True))
        )
        if not beaten:
            front.append(i)
    return front


def sweeps_table(data: Data) -> Table:
    """The cheapest mesh tried for each number of digits."""
    rows = []
    for digits in range(1, data["inputs"]["digits"] + 1):
        enough = [
            level
            for level in data["levels"]
            if not level["corrected"]
            and level["bound"] is not None
            and level["bound"] <= half_unit(digits)
        ]
        best = min(enough, key=lambda level: float(level["seconds"]), default=None)
        if best is not None:
            rows.append(
                (
                    digits,
                    backend_name(best["backend"]),
                    degree_text(best),
                    elements_text(best["elements"]),
                    best["dofs"],
                    best["seconds"],
                )
            )
    return Table(
        "sweeps",
        "The cheapest mesh of those tried that holds so many digits of lambda in every mode.",
        (
            Column("digits", "digits", number),
            Column("backend", "backend"),
            Column("degree", "degree"),
            Column("elements", "elements"),
            Column("dofs", "dofs", number),
            Column("seconds", "time", decimals(2), "s"),
        ),
        rows,
    )


TABLES = (modes_table, orders_table, levels_table, owed_table, sweeps_table)
"""What makes the tables of a record."""
