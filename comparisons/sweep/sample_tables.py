"""Tables of samples: how probable growth is, what was drawn, what it rests on."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from comparisons.kit.numbers import shown
from comparisons.kit.tables import Column, Data, Table
from comparisons.sweep.distributions import Drawn
from comparisons.sweep.sampled import Sampled

_LISTED = 100_000
"""Samples up to which they are written as a table too."""


def probability_table(data: Data) -> Table:
    """A row for all modes together, and for each mode that may grow."""
    together = {"mode": "any", "frequency": None, "seen": data["samples"]} | data["any"]
    return Table(
        "probability",
        f"Samples that grow, of {data['samples']}; intervals of 95 per cent.",
        (
            Column("mode", "mode"),
            Column("frequency", "median frequency", shown(6), "Hz"),
            Column("seen", "in the window", shown(7)),
            Column("grows", "grows", shown(7)),
            Column("undecided", "undecided", shown(7)),
            Column("probability", "probability", shown(4)),
            Column("standard_error", "standard error", shown(2)),
            Column("low", "from", shown(4)),
            Column("high", "to", shown(4)),
            Column("growth_low", "growth, 5 %", shown(4), "1/s"),
            Column("growth_median", "median", shown(4), "1/s"),
            Column("growth_high", "95 %", shown(4), "1/s"),
            Column("fastest", "fastest", shown(4), "1/s"),
        ),
        [
            (
                *(_label(each["mode"]), each["frequency"], each["seen"]),
                *(each[name] for name in ("grows", "undecided", "probability", "standard_error")),
                *(each[name] for name in ("low", "high")),
                *(each["growth"][name] for name in ("low", "median", "high")),
                each["fastest"],
            )
            for each in (together, *data["modes"])
        ],
    )


def _label(mode: int | str | None) -> str:
    return "not followed" if mode is None else str(mode)


def fields_table(data: Data) -> Table:
    """A row for each field that is spread."""
    asked = data["inputs"]["distributions"]
    return Table(
        "fields",
        f"Fields that are spread, seed {data['inputs']['seed']}.",
        (
            Column("field", "field"),
            Column("distribution", "distribution"),
            Column("first", "mean, median or least", shown(6)),
            Column("second", "deviation or greatest", shown(6)),
            Column("least", "least drawn", shown(6)),
            Column("greatest", "greatest drawn", shown(6)),
        ),
        [
            (each["name"], each["kind"], each["first"], each["second"], *field["ends"])
            for each, field in zip(asked, data["fields"], strict=True)
        ],
    )


def samples_summary(data: Data) -> Table:
    """What the samples took, and how sure they are."""
    seconds = data["processor_seconds"]
    rows: list[tuple[Any, ...]] = [
        ("unknowns", data["unknowns"]),
        ("vectors of the basis", data["basis"]),
        ("full solves", len(data["snapshots"])),
        ("samples", data["samples"]),
        ("samples certified", data["certified"]),
        ("worst bound, relative", data["worst"]),
        ("full solves, processor s", seconds["full_solves"]),
        ("basis, processor s", seconds["basis"]),
        ("samples, processor s", seconds["samples"]),
        ("a sample, processor s", seconds["a_sample"]),
    ]
    columns = (Column("what", "what"), Column("value", "value", shown(4)))
    return Table("summary", "The samples.", columns, rows)


def solves_table(data: Data) -> Table:
    """A row for each full solve."""
    names = [field["parameters"][0] for field in data["fields"]]
    return Table(
        "full_solves",
        "Full solves that the samples rest on, and how far the reduced model was off there before.",
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


def samples_table(data: Data, drawn: Sequence[Drawn], found: Sampled) -> Table | None:
    """A row for each sample; None where that would be too many."""
    if len(found.worst) > _LISTED:
        return None
    fastest = np.where(found.grows, found.growth, -np.inf)
    top = fastest.argmax(axis=1) if fastest.shape[1] else np.zeros(len(fastest), dtype=int)
    rows: list[tuple[Any, ...]] = []
    for i in range(len(found.worst)):
        grows = bool(found.grows[i].any())
        rows.append(
            (
                *(each.values[i] for each in drawn),
                int(found.grows[i].sum()),
                float(found.growth[i, top[i]]) if grows else None,
                float(found.frequency[i, top[i]]) if grows else None,
                float(found.bound[i]),
            )
        )
    return Table(
        "samples",
        "Every sample: modes that grow, with those they coalesced with, and the fastest.",
        (
            *(Column(each.name, each.name, shown(6)) for each in drawn),
            Column("grow", "modes that grow", shown(3)),
            Column("growth", "fastest growth", shown(5), "1/s"),
            Column("frequency", "its frequency", shown(6), "Hz"),
            Column("worst", "worst bound", shown(2)),
        ),
        rows,
    )
