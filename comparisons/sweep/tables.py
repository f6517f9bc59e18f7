"""Presentation of a sweep: its first lines, its tables, the sections of its page."""

from typing import Any

import numpy as np
import pandas as pd

from cea.eigen.classify import GROWING, WORDS, counted_words
from comparisons.study.closing import warned
from comparisons.study.columns import Column
from comparisons.study.numbers import counted, plain, shown
from comparisons.study.result import Data
from comparisons.study.run_warnings import kinds_at
from comparisons.study.sections import Drawing, Plot, Section, Table
from comparisons.sweep.spectra import UNSTABLE
from comparisons.sweep.study import Swept

_ON_PAGE = 500
"""Largest number of rows of a table that the page shows; its file holds all."""
_WHAT = {
    "flutter": ("flutter begins", "flutter ends"),
    "divergence": ("divergence begins", "divergence ends"),
    "window": ("growing mode enters the window from above", "growing mode leaves the window"),
    "count": ("more modes grow", "fewer modes grow"),
}
"""Text for a threshold where the number of growing modes increases, and where it decreases."""


def headline(data: Data) -> str:
    """Return the main result of a sweep in one or two sentences."""
    if "fields" in data:
        told = f"{data['any']['grows']} of {data['values']} samples grow"
        undecided = data["any"]["undecided"]
        return told + (f", {undecided} are undecided." if undecided else ".")
    first, *others = data["axes"]
    along = f"{first['name']} = {first['ends'][0]:g} to {first['ends'][1]:g}"
    begun = [each for each in data["thresholds"] if each["change"] > 0]
    level = f"growth_threshold {data['growth_threshold'] or 0:g} 1/s"
    count, unresolved = len(data["thresholds"]), len(data["unresolved"])
    if others:
        told = f"{count} thresholds along {first['name']} ({level})."
    elif begun:
        one = min(begun, key=lambda each: each["value"])
        told = (
            f"Growth from {first['name']} = {one['value']:.4g} at {one['im'] / (2 * np.pi):.6g} Hz "
            f"(first of {count} thresholds for {along}; {level})."
        )
    else:
        grows = "Nothing begins to grow" if data["growing_at_first"] else "No flutter"
        sure = "" if unresolved or "why" in data else ", every interval resolved"
        told = f"{grows} for {along}{sure} ({level})."
    return told + (f" {unresolved} intervals unresolved." if unresolved else "")


def words(made: Swept) -> str:
    """Return the number of modes of each class at the point of the largest growth rate."""
    data, points, spectra = made.record, made.points, made.spectra
    if not spectra.there.any():
        return f"No modes below {data['max_frequency']:g} Hz at any value."
    point = int(np.unravel_index(np.nanargmax(spectra.growth), spectra.growth.shape)[0])
    there = spectra.there[point]
    growth, verdicts = spectra.growth[point][there], spectra.verdict[point][there]
    at = zip(points.names, points.values[point], strict=True)
    told = ", ".join(f"{name} = {value:.6g}" for name, value in at)
    counts = counted_words([WORDS[i] for i in verdicts], growth.tolist(), data["growth_threshold"])
    return f"Largest growth rate at {told}: {counted(len(growth), 'mode')}: {counts}."


def sections_of(made: Swept, drawn: Plot | Drawing) -> list[Section]:
    """Return the sections of the page of a sweep."""
    data, few = made.record, len(made.points.values) <= _ON_PAGE
    own = OWN | {name: Column(name, show=shown(6)) for name in made.points.names}
    tables = [Table("summary", "The sweep.", summary, own)]
    tables.append(Table("sweep", "All values.", values, own, shown=few))
    why, basis = "", []
    if "why" in data:
        why = f"Solved in full at each value: {data['why']}"
    else:
        caption = "Derivatives of the growth rate and frequency of the fastest growing mode."
        tables.append(Table("sensitivities", caption, sensitivities, own, shown=few))
        caption = "Full solves of the basis, and error of the reduced model before each of them."
        basis.append(Table("full_solves", caption, full_solves, own))
    title = "Thresholds" if made.points.axes else "Probability of growth"
    return [
        Section("What grows where", why, lambda _: f"{headline(data)} {words(made)}", [], [drawn]),
        Section("Warnings", tables=[Table("warnings", "", lambda made: warned(made.record))]),
        Section(title, tables=[answer_table(made)]),
        Section("Values", tables=tables),
        Section("Full solves", tables=basis),
    ]


def answer_table(made: Swept) -> Table:
    """Return the table of thresholds, or of probabilities for samples."""
    data, names = made.record, made.points.names
    if not made.points.axes:
        caption = f"Growing samples of {data['values']}; 95 per cent confidence intervals."
        return Table("probability", caption, probability, OWN)
    told = f"{data['resolution']:.1e}" if data["resolution"] else "no interval accepted by count"
    if "why" in data:
        told = "the step between values, each of which is solved in full"
    caption = f"Where the number of growing modes changes along {names[0]}. Resolution: {told}."
    others = {name: Column(name, show=shown(6)) for name in names[1:]}
    own = OWN | others | {names[0]: Column(names[0], show=shown(10))}
    return Table("thresholds", caption, thresholds, own)


def thresholds(made: Swept) -> pd.DataFrame:
    """Return a row for each threshold and each unresolved interval."""
    first, *others = made.points.names
    rows = []
    for each in (*made.record["thresholds"], *made.record["unresolved"]):
        if "kind" in each:
            value, bound, what = each["value"], each["error"], _WHAT[each["kind"]]
            told = what[each["change"] < 0]
        else:
            value, bound = (each["high"] + each["low"]) / 2, (each["high"] - each["low"]) / 2
            told = f"unresolved; growing eigenvalues {each['before']} before, {each['after']} after"
        frequency = None if each["im"] is None else each["im"] / (2 * np.pi)
        place = [*(each[name] for name in others), value]
        rows.append([*place, bound, frequency, told, each.get("full_solve_differs")])
    return pd.DataFrame(rows, columns=[*others, first, "bound", "frequency", "what", "full"])


def full_solves(made: Swept) -> pd.DataFrame:
    """Return a row for each full solve."""
    solves = made.record["snapshots"]
    firsts = [group[0] for group in made.record["parameters"]]
    return pd.DataFrame(
        [
            {name: each["point"][name] for name in firsts}
            | {"error over its bound": each["tested"], "window complete": each["complete"]}
            for each in solves
        ]
    )


def summary(made: Swept) -> pd.DataFrame:
    """Return the size of the reduced model, the number of certified values, and the worst bound."""
    data = made.record
    told = {"values": data["values"]}
    if "why" in data:
        told |= {"values solved in full": data["certified"]}
    else:
        told |= {
            "unknowns": data["unknowns"],
            "vectors of the basis": max(data["vectors"]),
            "full solves": len(data["snapshots"]),
            "values certified": data["certified"],
            "worst bound, relative": float(f"{data['worst']:.3g}"),
        }
    told |= {"complete up to a growth of, 1/s": data["complete_to"]}
    return pd.DataFrame(
        {"what": list(told), "value": ["–" if v is None else plain(v) for v in told.values()]}
    )


def _places(made: Swept, chosen: Any = slice(None)) -> pd.DataFrame:
    """Return the fields at chosen points."""
    return pd.DataFrame(made.points.values[chosen], columns=[*made.points.names])


def values(made: Swept) -> pd.DataFrame:
    """Return a row for each point: number of growing modes, the fastest, bound, warnings."""
    data, spectra, frame = made.record, made.spectra, _places(made)
    reasons = {tuple(each["point"].values()): each["reason"] for each in data["failed"]}
    top = np.arange(len(frame)), np.where(spectra.there, spectra.growth, -np.inf).argmax(axis=1)
    points = frame.to_dict("records")
    return frame.assign(
        modes=spectra.there.sum(axis=1),
        **{
            word.replace(" ", "_"): (spectra.verdict == WORDS.index(word)).sum(axis=1)
            for word in GROWING
        },
        growth=spectra.growth[top],
        frequency=spectra.frequency[top],
        bound=np.nan if "why" in data else spectra.bound,
        warnings=[", ".join(kinds_at(data.get("warnings", ()), at)) for at in points],
        no_answer=[reasons.get(tuple(at.values()), "") for at in points],
    )


def sensitivities(made: Swept) -> pd.DataFrame:
    """Return a row for the fastest growing mode of each point with an unstable mode."""
    spectra = made.spectra
    rows = np.flatnonzero(np.isfinite(spectra.largest))
    unstable = np.where(spectra.verdict[rows] == UNSTABLE, spectra.growth[rows], -np.inf)
    top = rows, unstable.argmax(axis=1)
    frame = _places(made, rows).assign(frequency=spectra.frequency[top], growth=spectra.growth[top])
    for i, name in enumerate(made.points.names):
        frame[f"d growth / d {name}"] = spectra.growth_slope[top][:, i]
        frame[f"d frequency / d {name}"] = spectra.frequency_slope[top][:, i]
    return frame


def probability(made: Swept) -> pd.DataFrame:
    """Return a row for all modes together, and one for each mode that may grow."""
    data = made.record
    together = {"mode": "any", "frequency": None, "seen": data["values"]} | data["any"]
    return pd.DataFrame(
        [
            {"mode": str(each["mode"])}
            | {name: value for name, value in each.items() if name not in ("mode", "growth")}
            | {f"growth_{name}": value for name, value in each["growth"].items()}
            for each in (together, *data["modes"])
        ]
    )


OWN = {
    "mode": Column("mode"),
    "growth": Column("fastest growth", "1/s", shown(5, sign=True)),
    "bound": Column("bound", show=shown(2)),
    "full": Column("full solve differs by", show=shown(2, sign=True)),
    "frequency": Column("frequency", "Hz", shown(7)),
    "what": Column("what"),
    "seen": Column("in the window", show=shown(7)),
    "low": Column("from", show=shown(4)),
    "high": Column("to", show=shown(4)),
    "fastest": Column("fastest", "1/s", shown(4)),
    "growth_low": Column("growth, 5 %", "1/s", shown(4)),
    "growth_median": Column("median", "1/s", shown(4)),
    "growth_high": Column("95 %", "1/s", shown(4)),
}
"""Titles, units and formats of the columns of sweeps."""
