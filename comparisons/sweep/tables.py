"""Tables of a sweep: what is unstable where, and every mode."""

from typing import Any

import numpy as np

from cea.eigen.classify import GROWING, threshold_text
from comparisons.kit.numbers import shown
from comparisons.kit.run_warnings import kinds_at
from comparisons.kit.tables import Column, Data, Table
from comparisons.sweep.study import curves_of


def values_table(data: Data) -> Table:
    """A row for each value: how many modes grow, the fastest, what it warns of."""
    rows: list[tuple[Any, ...]] = []
    for point in data["points"]:
        modes = point["modes"]
        fastest = max(modes, key=lambda mode: mode["re"], default=None)
        rows.append(
            (
                point["value"],
                len(modes) if not point["failed"] else None,
                *(sum(mode["verdict"] == word for mode in modes) for word in GROWING),
                fastest["re"] if fastest else None,
                fastest["im"] / (2 * np.pi) if fastest else None,
                ", ".join(kinds_at(data["warnings"], {data["field"]: point["value"]})),
                point["failed"] or point["verdict"],
            )
        )
    return Table(
        "sweep",
        f"Modes along {data['field']}; {threshold_text(data.get('growth_threshold'))}.",
        (
            Column("value", data["field"], shown(6)),
            Column("modes", "modes", shown(3)),
            Column("unstable", "unstable", shown(3)),
            Column("grows_slowly", "grow slowly", shown(3)),
            Column("growth", "fastest growth", shown(4, sign=True), "1/s"),
            Column("frequency", "its frequency", shown(5), "Hz"),
            Column("warnings", "warnings"),
            Column("verdict", "verdict"),
        ),
        rows,
    )


def unstable_table(data: Data) -> Table:
    """A row for each curve that is unstable somewhere."""
    rows = []
    for curve in curves_of(data).values():
        grows = curve["unstable"]
        if grows.any():
            fastest = int(np.argmax(curve["growth"]))
            where = curve["value"][grows]
            rows.append(
                (
                    float(curve["frequency"][fastest]),
                    float(where.min()),
                    float(where.max()),
                    int(grows.sum()),
                    float(curve["growth"][fastest]),
                    float(curve["value"][fastest]),
                )
            )
    return Table(
        "unstable",
        f"Modes that are unstable somewhere along {data['field']}.",
        (
            Column("frequency", "frequency", shown(5), "Hz"),
            Column("first", "unstable from", shown(5)),
            Column("last", "to", shown(5)),
            Column("count", "at values", shown(3)),
            Column("growth", "fastest growth", shown(4, sign=True), "1/s"),
            Column("at", "at", shown(5)),
        ),
        sorted(rows),
    )


def modes_table(data: Data) -> Table:
    """A row for each mode at each value."""
    rows = [
        (
            point["value"],
            mode["curve"],
            mode["im"] / (2 * np.pi),
            mode["re"],
            mode["uncertainty"],
            mode["verdict"],
        )
        for point in data["points"]
        for mode in point["modes"]
    ]
    return Table(
        "modes",
        "Every mode; modes of one curve share its number.",
        (
            Column("value", data["field"], shown(6)),
            Column("curve", "curve", shown(3)),
            Column("frequency", "frequency", shown(6), "Hz"),
            Column("growth", "growth rate", shown(5, sign=True), "1/s"),
            Column("uncertainty", "algebraic error", shown(2), "1/s"),
            Column("verdict", "verdict"),
        ),
        rows,
    )
