"""Tables of a map: thresholds, what it rests on, values."""

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from comparisons.kit.numbers import shown
from comparisons.kit.tables import Column, Data, Table
from comparisons.sweep.rows import UNSTABLE, Row

_MODES = 200_000
"""Modes of a map up to which they are written as a table too."""


def headline(data: Data) -> str:
    """What a map says first, in one sentence or two."""
    first, *others = data["axes"]
    name, values = first["name"], first["values"]
    begun = [each for each in data["thresholds"] if each["change"] > 0]
    level = f"growth_threshold {data['level']:g} 1/s"
    unresolved = len(data["unresolved"])
    if others:
        told = f"{len(data['thresholds'])} thresholds along {name} ({level})."
    elif begun:
        one = min(begun, key=lambda each: each["value"])
        told = (
            f"Growth from {name} = {one['value']:.4g} at {one['im'] / (2 * np.pi):.6g} Hz (first "
            f"of {len(data['thresholds'])} thresholds for {name} = {min(values):g} to "
            f"{max(values):g}; {level})."
        )
    else:
        grows = "Nothing begins to grow" if data["growing_at_first"] else "No flutter"
        sure = "" if unresolved else ", every interval resolved"
        told = f"{grows} for {name} = {min(values):g} to {max(values):g}{sure} ({level})."
    if unresolved:
        told += f" {unresolved} intervals unresolved."
    return told


_WHAT = {
    "flutter": ("flutter begins", "flutter ends"),
    "divergence": ("divergence begins", "divergence ends"),
    "window": (
        "growing mode enters the window from above",
        "growing mode leaves the window",
    ),
    "count": ("more modes grow", "fewer modes grow"),
}
"""What happens where growing modes become more, and where they become fewer."""


def thresholds_table(data: Data) -> Table:
    """A row for each threshold, and one for each interval that is unresolved."""
    first, *others = [axis["name"] for axis in data["axes"]]
    found = [
        (
            *(each[name] for name in others),
            each["value"],
            each["error"],
            each["im"] / (2 * np.pi),
            _WHAT[each["kind"]][each["change"] < 0],
            each.get("full_solve_differs"),
        )
        for each in data["thresholds"]
    ]
    found += [
        (
            *(each[name] for name in others),
            (each["low"] + each["high"]) / 2,
            (each["high"] - each["low"]) / 2,
            None if each["im"] is None else each["im"] / (2 * np.pi),
            f"unresolved; growing eigenvalues {each['before']} before, {each['after']} after",
            None,
        )
        for each in data["unresolved"]
    ]
    resolution = f"{data['resolution']:.1e}" if data["resolution"] else "no interval by count alone"
    return Table(
        "thresholds",
        f"Where the number of growing modes changes along {first}. Resolution: {resolution}.",
        (
            *(Column(name, name, shown(4)) for name in others),
            Column("value", first, shown(10)),
            Column("error", "bound on its error", shown(2)),
            Column("frequency", "frequency", shown(7), "Hz"),
            Column("flutter", "what"),
            Column("full", "full solve differs by", shown(2, sign=True)),
        ),
        found,
    )


def snapshots_table(data: Data) -> Table:
    """A row for each full solve."""
    names = [group[0] for group in data["parameters"]]
    return Table(
        "full_solves",
        "Full solves that the map rests on, and how far the reduced model was off there before.",
        (
            *(Column(name, name, shown(5)) for name in names),
            Column("tested", "error over its bound", shown(2)),
            Column("complete", "window complete"),
        ),
        [
            (
                *(each["point"][name] for name in names),
                each["tested"],
                "yes" if each["complete"] else "not shown",
            )
            for each in data["snapshots"]
        ],
    )


def summary_table(data: Data) -> Table:
    """What the map took, and how sure it is."""
    seconds = data["processor_seconds"]
    rows: list[tuple[Any, ...]] = [
        ("unknowns", data["unknowns"]),
        ("vectors of the basis", data["basis"]),
        ("full solves", len(data["snapshots"])),
        ("values", data["values"]),
        ("values certified", data["certified"]),
        ("worst bound, relative", data["worst"]),
        ("full solves, processor s", seconds["full_solves"]),
        ("basis, processor s", seconds["basis"]),
        ("values, processor s", seconds["values"]),
        ("a value, processor s", seconds["a_value"]),
    ]
    columns = (Column("what", "what"), Column("value", "value", shown(4)))
    return Table("summary", "The map.", columns, rows)


def values_table(data: Data, rows: Sequence[Row]) -> Table:
    """A row for each value: how many modes are unstable, the fastest, the bound."""
    return Table(
        "sweep",
        "Values of the map.",
        (
            *(Column(axis["name"], axis["name"], shown(6)) for axis in data["axes"]),
            Column("modes", "modes", shown(3)),
            Column("unstable", "unstable", shown(3)),
            Column("growth", "fastest growth", shown(5, sign=True), "1/s"),
            Column("frequency", "its frequency", shown(6), "Hz"),
            Column("worst", "worst bound", shown(2)),
        ),
        [
            (*at, *_fastest(row.growth[i], row.frequency[i], row.verdict[i]), float(row.bound[i]))
            for at, row, i in places(data, rows)
        ],
    )


def modes_table(data: Data, rows: Sequence[Row]) -> Table | None:
    """A row for each mode at each value; None where that would be too many."""
    if sum(row.growth.size for row in rows) > _MODES:
        return None
    names = ("branch", "frequency", "growth", "uncertainty", "mean_error", "verdict")
    return Table(
        "modes",
        "Every mode; modes of one branch share its number.",
        (
            *(Column(axis["name"], axis["name"], shown(6)) for axis in data["axes"]),
            *(Column(name, name.replace("_", " "), shown(7)) for name in names),
        ),
        [
            (*at, *(getattr(row, name)[i, mode].item() for name in names))
            for at, row, i in places(data, rows)
            for mode in np.flatnonzero(row.branch[i] >= 0)
        ],
    )


def _fastest(growth: Any, frequency: Any, verdict: Any) -> tuple[Any, ...]:
    there = np.isfinite(growth)
    if not there.any():
        return 0, 0, None, None
    top = int(np.nanargmax(growth))
    return int(there.sum()), int((verdict == UNSTABLE).sum()), float(growth[top]), frequency[top]


def places(data: Data, rows: Sequence[Row]) -> list[tuple[tuple[float, ...], Row, int]]:
    """Values of the axes with the row and the place in it."""
    first, *others = [axis["values"] for axis in data["axes"]]
    return [
        ((value, *rest), row, i)
        for rest, row in zip(product(*others), rows, strict=True)
        for i, value in enumerate(first)
    ]
