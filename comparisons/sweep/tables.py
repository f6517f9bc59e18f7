"""What a sweep says: its first lines, and its tables."""

from typing import Any

import numpy as np

from cea.eigen.classify import WORDS, counted_words, threshold_text
from comparisons.kit.numbers import counted, shown
from comparisons.kit.run_warnings import kinds_at
from comparisons.kit.tables import Column, Data, Table
from comparisons.sweep.points import Points
from comparisons.sweep.probabilities import growing
from comparisons.sweep.spectra import UNSTABLE, Spectra

_MODES = 200_000
"""Modes up to which they are written as a table too."""
_WHAT = {
    "flutter": ("flutter begins", "flutter ends"),
    "divergence": ("divergence begins", "divergence ends"),
    "window": ("growing mode enters the window from above", "growing mode leaves the window"),
    "count": ("more modes grow", "fewer modes grow"),
}
"""What happens where growing modes become more, and where they become fewer."""


def headline(data: Data) -> str:
    """What a sweep says first, in one sentence or two."""
    if "fields" in data:
        told = f"{data['any']['grows']} of {data['values']} samples grow"
        undecided = data["any"]["undecided"]
        return told + (f", {undecided} are undecided." if undecided else ".")
    first, *others = data["axes"]
    name, (low, high) = first["name"], first["ends"]
    begun = [each for each in data["thresholds"] if each["change"] > 0]
    level = f"growth_threshold {data['growth_threshold'] or 0:g} 1/s"
    unresolved = len(data["unresolved"])
    if others:
        told = f"{len(data['thresholds'])} thresholds along {name} ({level})."
    elif begun:
        one = min(begun, key=lambda each: each["value"])
        told = (
            f"Growth from {name} = {one['value']:.4g} at {one['im'] / (2 * np.pi):.6g} Hz (first "
            f"of {len(data['thresholds'])} thresholds for {name} = {low:g} to {high:g}; {level})."
        )
    else:
        grows = "Nothing begins to grow" if data["growing_at_first"] else "No flutter"
        sure = "" if unresolved or "why" in data else ", every interval resolved"
        told = f"{grows} for {name} = {low:g} to {high:g}{sure} ({level})."
    return told + (f" {unresolved} intervals unresolved." if unresolved else "")


def words_where_most_grows(data: Data, points: Points, spectra: Spectra) -> str:
    """How many modes have which word at the point where a mode grows fastest."""
    if not spectra.there.any():
        lowest = data.get("lowest")
        near = "" if lowest is None else f"; the lowest is near {lowest:.5g} Hz"
        return f"No modes below {data['max_frequency']:g} Hz at any value{near}."
    point = int(np.unravel_index(np.nanargmax(spectra.growth), spectra.growth.shape)[0])
    there = spectra.there[point]
    growth, words = spectra.growth[point][there], spectra.verdict[point][there]
    at = zip(points.names, points.values[point], strict=True)
    told = ", ".join(f"{name} = {value:.6g}" for name, value in at)
    counts = counted_words([WORDS[i] for i in words], growth.tolist(), data["growth_threshold"])
    return f"Most grows at {told}: {counted(len(growth), 'mode')}: {counts}."


def tables_of(data: Data, points: Points, spectra: Spectra) -> list[Table]:
    """All tables of a sweep, in their order on its page."""
    made = [summary_table(data), values_table(data, points, spectra)]
    if points.counts:
        made[:0] = [thresholds_table(data)]
    else:
        made[:0] = [probability_table(data), fields_table(data)]
    if "why" not in data:
        made += [solves_table(data), sensitivities_table(points, spectra)]
    if spectra.growth.size <= _MODES:
        made.append(modes_table(points, spectra))
    return made


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
    if "why" in data:
        resolution = "the step between values, each of which is solved in full"
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


def solves_table(data: Data) -> Table:
    """A row for each full solve."""
    names = [group[0] for group in data["parameters"]]
    return Table(
        "full_solves",
        "Full solves that bases rest on, and how far the reduced model was off there before.",
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
    """What the sweep rests on, and how sure it is."""
    rows: list[tuple[Any, ...]] = [("values", data["values"])]
    if "why" in data:
        rows.append(("values solved in full", data["certified"]))
    else:
        rows += [
            ("unknowns", data["unknowns"]),
            ("bases", len(data["vectors"])),
            ("vectors of the largest basis", max(data["vectors"])),
            ("full solves", len(data["snapshots"])),
            ("values certified", data["certified"]),
            ("worst bound, relative", data["worst"]),
        ]
    rows.append(("complete up to a growth of, 1/s", data["complete_to"]))
    columns = (Column("what", "what"), Column("value", "value", shown(4)))
    return Table("summary", "The sweep.", columns, rows)


def values_table(data: Data, points: Points, spectra: Spectra) -> Table:
    """A row for each point: how many modes have which word, the fastest, the bound."""
    rows: list[tuple[Any, ...]] = []
    reasons = [(each["point"], each["reason"]) for each in data["failed"]]
    for i, values in enumerate(points.values.tolist()):
        there, at = spectra.there[i], dict(zip(points.names, values, strict=True))
        fastest: list[float | None] = [None, None]
        if there.any():
            top = int(np.nanargmax(spectra.growth[i]))
            fastest = [float(spectra.growth[i, top]), float(spectra.frequency[i, top])]
        rows.append(
            (
                *values,
                int(there.sum()),
                *(int((spectra.verdict[i] == WORDS.index(w)).sum()) for w in _GROWING),
                *fastest,
                float(spectra.bound[i]) if "why" not in data else None,
                ", ".join(kinds_at(data.get("warnings", ()), at)),
                next((why for point, why in reasons if point == at), ""),
            )
        )
    return Table(
        "sweep",
        f"All values; {threshold_text(data['growth_threshold'])}.",
        (
            *(Column(name, name, shown(6)) for name in points.names),
            Column("modes", "modes", shown(3)),
            Column("unstable", "unstable", shown(3)),
            Column("grows_slowly", "grow slowly", shown(3)),
            Column("growth", "fastest growth", shown(5, sign=True), "1/s"),
            Column("frequency", "its frequency", shown(6), "Hz"),
            Column("worst", "worst bound", shown(2)),
            Column("warnings", "warnings"),
            Column("failed", "no answer"),
        ),
        rows,
    )


_GROWING = ("unstable", "grows slowly")


def modes_table(points: Points, spectra: Spectra) -> Table:
    """A row for each mode at each point."""
    names = ("frequency", "growth", "uncertainty", "mean_error")
    return Table(
        "modes",
        "Every mode.",
        (
            *(Column(name, name, shown(6)) for name in points.names),
            *(Column(name, name.replace("_", " "), shown(7)) for name in names),
            Column("verdict", "verdict"),
        ),
        [
            (
                *points.values[i].tolist(),
                *(float(getattr(spectra, name)[i, mode]) for name in names),
                WORDS[spectra.verdict[i, mode]],
            )
            for i, mode in np.argwhere(spectra.there)
        ],
    )


def sensitivities_table(points: Points, spectra: Spectra) -> Table:
    """A row for the fastest growing mode of each point, where one grows."""
    names, made = points.names, list[tuple[Any, ...]]()
    for i in np.flatnonzero(np.isfinite(spectra.largest)):
        unstable = spectra.verdict[i] == UNSTABLE
        top = int(np.argmax(np.where(unstable, spectra.growth[i], -np.inf)))
        slopes, at = spectra.growth_slope[i, top], points.values[i]
        shifts = spectra.frequency_slope[i, top]
        rate, frequency = float(spectra.growth[i, top]), float(spectra.frequency[i, top])
        numbers = [*slopes.tolist(), *(slopes * at).tolist(), *shifts.tolist()]
        made.append((*at.tolist(), frequency, rate, *numbers))
    return Table(
        "sensitivities",
        "What moves the growth rate of the fastest mode: its derivatives; times the value of the "
        "field, what a change by its whole would make; derivatives of the frequency.",
        (
            *(Column(name, name, shown(6)) for name in names),
            Column("frequency", "frequency", shown(6), "Hz"),
            Column("growth", "growth", shown(5, sign=True), "1/s"),
            *(Column(f"slope {n}", f"d growth / d {n}", shown(4, sign=True)) for n in names),
            *(Column(f"whole {n}", f"times {n}", shown(4, sign=True), "1/s") for n in names),
            *(Column(f"shift {n}", f"d frequency / d {n}", shown(4, sign=True)) for n in names),
        ),
        made,
    )


def probability_table(data: Data) -> Table:
    """A row for all modes together, and for each mode that may grow."""
    together = {"mode": "any", "frequency": None, "seen": data["values"]} | data["any"]
    numbers = ("seen", "grows", "undecided", "probability", "standard_error", "low", "high")
    return Table(
        "probability",
        f"Samples that grow, of {data['values']}; intervals of 95 per cent.",
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
                str(each["mode"]),
                each["frequency"],
                *(each[name] for name in numbers),
                *(each["growth"][name] for name in ("low", "median", "high")),
                each["fastest"],
            )
            for each in (together, *data["modes"])
        ],
    )


def fields_table(data: Data) -> Table:
    """A row for each field that is spread."""
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
            Column("cut", "share cut off", shown(3)),
        ),
        [
            (each["name"], each["kind"], each["first"], each["second"], *f["ends"], f["cut"])
            for each, f in zip(data["inputs"]["fields"], data["fields"], strict=True)
        ],
    )


def growing_samples(data: Data, spectra: Spectra) -> Any:
    """Largest growth rate of each sample that surely grows (1/s); NaN of others."""
    damped = bool(data.get("damped"))
    grows, _ = growing(spectra, data["growth_threshold"], damped=damped)
    largest = np.where(grows, spectra.growth, -np.inf).max(axis=1, initial=-np.inf)
    return np.where(np.isfinite(largest), largest, np.nan)
