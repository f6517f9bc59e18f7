"""The record of a sweep: thresholds, certificates and warnings, without the modes."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from typing import Any

import numpy as np

from cea.arrays import Ints
from cea.reduced.crossings import Threshold
from cea.reduced.thresholds import Found, Unresolved
from comparisons.study.run_warnings import Run, merged_warnings, named
from comparisons.sweep.points import Points
from comparisons.sweep.scene import SweptScene
from comparisons.sweep.spectra import UNSTABLE, Spectra

FoundAlong = tuple[dict[str, float], Found]
"""Values of the other fields on a line of the first field, and thresholds along the line."""


def common_record(
    scene: SweptScene,
    spectra: Spectra,
    lines: Sequence[FoundAlong],
    failed: Sequence[Mapping[str, Any]],
    growths: Sequence[float | None],
) -> dict[str, Any]:
    """Return the entries of every record: fields, thresholds, failed solves.

    ``growths`` are growth rates (1/s) up to which full solves are complete; None is infinite.
    """
    points = scene.points
    fields = [
        {"name": name, "ends": list(ends), "factor_on": scene.factors_on(scene.names[i])}
        | ({"values": points.axes[i].tolist()} if points.axes else {"cut": points.cut[i]})
        for i, (name, ends) in enumerate(zip(points.names, points.ends, strict=True))
    ]
    return {
        "axes" if points.axes else "fields": fields,
        "values": len(points.values),
        "max_frequency": scene.window.max_frequency,
        "growth_threshold": scene.window.growth_threshold,
        "growing_at_first": bool((spectra.growth[0] > spectra.uncertainty[0]).any()),
        "failed": failed,
        "complete_to": min((each for each in growths if each is not None), default=None),
        "thresholds": [at | _plain(each) for at, line in lines for each in line.thresholds],
        "unresolved": [at | _plain(each) for at, line in lines for each in line.unresolved],
        "resolution": max((line.resolution for _, line in lines), default=0.0),
    }


def between_points(points: Points, spectra: Spectra, line: Ints) -> FoundAlong:
    """Return thresholds between full solves, by differences of the number of unstable modes."""
    found, unstable = Found(), (spectra.verdict == UNSTABLE).sum(axis=1)
    answered = line[np.isfinite(spectra.worst[line])]
    for low, high in pairwise(answered[np.argsort(points.values[answered, 0])].tolist()):
        change = 2 * int(unstable[high] - unstable[low])
        if change:
            more = high if change > 0 else low
            rates = np.where(spectra.verdict[more] == UNSTABLE, spectra.growth[more], np.inf)
            mode, ends = int(rates.argmin()), points.values[[low, high], 0]
            root = complex(rates[mode], 2 * np.pi * spectra.frequency[more, mode])
            middle, half = float(ends.mean()), float(np.ptp(ends) / 2)
            found.thresholds.append(Threshold(middle, half, root, 0.0, change, "count"))
    return dict(zip(points.names[1:], points.values[line[0], 1:].tolist(), strict=True)), found


def _plain(found: Threshold | Unresolved) -> dict[str, Any]:
    """Return a threshold or an unresolved interval as plain data; lambda as re and im (1/s)."""
    told = asdict(found)
    root = told.pop("eigenvalue")
    both = (None, None) if root is None else (float(root.real), float(root.imag))
    return told | dict(zip(("re", "im"), both, strict=True))


def warnings_of(
    data: Mapping[str, Any],
    points: Points,
    spectra: Spectra,
    tolerance: float,
    solves: Sequence[Run],
) -> list[dict[str, Any]]:
    """Return the warnings of a sweep and of its full solves."""
    told: list[tuple[str, str]] = []
    what = "full solves"
    if "why" in data:
        what = f"values of {', '.join(axis['name'] for axis in data['axes'])}"
    elif left := data["values"] - data["certified"]:
        message = (
            f"{left} of {data['values']} values are not certified to {tolerance:g}: see their "
            "error bounds, or allow more full solves"
        )
        message += "; --full solves in full what rounding limits" if "axes" in data else ""
        told.append(("not-certified", message))
    if data["failed"]:
        told.append(("no-answer", f"{len(data['failed'])} full solves failed"))
    if number := len(data["unresolved"]):
        told.append(("unresolved", f"{number} intervals are unresolved: thresholds may be missing"))
    above = np.flatnonzero(np.isfinite(spectra.above_growth))
    if len(above):
        first = above[0]
        at = named(dict(zip(points.names, points.values[first], strict=True)))
        message = (
            f"a mode at {spectra.above_frequency[first]:.6g} Hz has the growth rate "
            f"{spectra.above_growth[first]:.5g} 1/s at {at}, above max_frequency = "
            f"{data['max_frequency']:g} Hz; raise max_frequency"
        )
        told.append(("above-window", message))
    for each in data.get("fields", ()):
        if each["cut"]:
            share = f"{100 * each['cut']:.3g} % of the distribution of {each['name']}"
            told.append(("cut-off", f"{share} are not allowed as its values: it is truncated"))
    if undecided := data.get("any", {}).get("undecided"):
        message = f"{undecided} samples are undecided: confidence intervals cover both cases"
        told.append(("undecided", message))
    if unknown := data.get("not_followed"):
        message = (
            f"in {unknown} samples a mode that may grow has no match in the middle sample; single "
            "modes have no rows if these are a tenth or more"
        )
        told.append(("not-followed", message))
    own = [{"kind": kind, "message": message, "data": {}} for kind, message in told]
    return own + merged_warnings(solves, what)
