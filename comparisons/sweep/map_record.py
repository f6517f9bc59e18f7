"""The record of a map: what it is and how sure it is, without its values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import process_time
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.reduced.following import Window
from cea.reduced.full_solves import confirm
from cea.reduced.greedy import Enrichment
from comparisons.kit.run_warnings import merged_warnings
from comparisons.sweep.mapped import Mapped
from comparisons.sweep.netcdf import INTERVALS, plain
from comparisons.sweep.rows import Row


@dataclass(frozen=True)
class Spent:
    """What a map took.

    Parameters
    ----------
    full_solves, basis, rows
        Processor seconds of this rank.
    values
        Values that the latter are of.
    stored
        Full solves that an interrupted sweep had stored.
    """

    full_solves: float
    basis: float
    rows: float
    values: int
    stored: int

    def plain(self) -> dict[str, float]:
        """Processor seconds as plain data."""
        return {
            "full_solves": self.full_solves,
            "basis": self.basis,
            "values": self.rows,
            "a_value": self.rows / self.values if self.values else 0.0,
        }


def record_of(
    scene: Mapped, basis: Enrichment, rows: Sequence[Row], spent: Spent
) -> dict[str, Any]:
    """Record of a map, its thresholds not yet confirmed.

    Parameters
    ----------
    scene
        What was mapped.
    basis
        What it rests on.
    rows
        Its rows.
    spent
        What it took.
    """
    bound = np.concatenate([row.bound for row in rows])
    of_basis = np.concatenate([row.worst for row in rows])
    return {
        "axes": [{"name": axis.name, "values": axis.values} for axis in scene.axes],
        "parameters": [list(each) for each in scene.names],
        "unknowns": scene.pencil.terms[0].matrix.getSize()[0],
        "max_frequency": scene.max_frequency,
        "basis": basis.model.size,
        "snapshots": [each.plain() for each in basis.snapshots],
        "stored_before": spent.stored,
        "failed": [{"point": dict(point), "reason": why} for point, why in basis.failed],
        "values": len(bound),
        "certified": int((bound <= basis.tolerance).sum()),
        "lost_to_rounding": lost_to_rounding(bound, of_basis, basis.tolerance),
        "worst": float(bound.max(initial=0.0)),
        **{
            kind: [
                {**{axis.name: value for axis, value in zip(scene.axes[1:], others, strict=True)}}
                | plain(each)
                for others, row in zip(scene.rows(), rows, strict=True)
                for each in getattr(row, kind)
            ]
            for kind in INTERVALS
        },
        "level": scene.growth_threshold or 0.0,
        "growing_at_first": any(bool((row.growth[0] > row.uncertainty[0]).any()) for row in rows),
        "resolution": max(row.resolution for row in rows),
        "above": _above(scene, rows),
        "processor_seconds": spent.plain(),
    }


def _above(scene: Mapped, rows: Sequence[Row]) -> dict[str, float] | None:
    """The first value at which a mode grows just above the window's end, in the first such row."""
    for row in rows:
        there = np.flatnonzero(np.isfinite(row.above_growth))
        if len(there):
            i = int(there[0])
            return {
                "value": scene.axes[0].values[i],
                "growth": float(row.above_growth[i]),
                "frequency": float(row.above_frequency[i]),
            }
    return None


def confirm_some(
    data: dict[str, Any],
    scene: Mapped,
    basis: Enrichment,
    rows: Sequence[Row],
    most: int,
    progress: Callable[[str], None],
) -> None:
    """Solve in full at some thresholds, far apart, and note by how much they differ."""
    places = [
        (threshold, others)
        for others, row in zip(scene.rows(), rows, strict=True)
        for threshold in row.thresholds
    ]
    window = Window(2 * np.pi * scene.max_frequency, basis.model.small.damped, data["level"])
    chosen = np.linspace(0, len(places) - 1, min(most, len(places))).round().astype(int)
    for number in np.unique(chosen).tolist():
        progress(f"threshold {number + 1} of {len(places)}, solved in full")
        threshold, others = places[number]
        at = partial(_along, scene, others)
        told = confirm(scene.driver, at, threshold, window)
        differs = None if told is None else told[0] - threshold.value
        data["thresholds"][number]["full_solve_differs"] = differs


def _along(scene: Mapped, others: tuple[float, ...], value: float) -> dict[str, float]:
    return scene.point((value, *others))


def warnings_of(data: dict[str, Any], tolerance: float) -> list[dict[str, Any]]:
    """What a map must be read with."""
    found: list[tuple[str, str]] = []
    left = data["values"] - data["certified"]
    if left:
        found.append(
            (
                "not-certified",
                f"{left} of {data['values']} values are not certified to {tolerance:g}: their "
                f"bounds say how far they may be off{of_rounding(data['lost_to_rounding'])}",
            )
        )
    if data["failed"]:
        found.append(("no-answer", f"{len(data['failed'])} full solves gave no answer"))
    if data["unresolved"]:
        found.append(
            (
                "unresolved",
                f"{len(data['unresolved'])} intervals are unresolved: thresholds may be missing "
                "there",
            )
        )
    if (above := data["above"]) is not None:
        name = data["axes"][0]["name"]
        found.append(
            (
                "above-window",
                f"a mode at {above['frequency']:.6g} Hz grows by {above['growth']:.5g} 1/s at "
                f"{name} = {above['value']:.5g}: above max_frequency = "
                f"{data['max_frequency']:g} Hz; raise it",
            )
        )
    told = [{"kind": kind, "message": message, "data": {}} for kind, message in found]
    return told + of_full_solves(data["snapshots"])


def lost_to_rounding(bound: Floats, of_basis: Floats, tolerance: float) -> int:
    """Number of bounds that rounding alone takes above the tolerance."""
    return int(((bound > tolerance) & (of_basis <= tolerance)).sum())


def of_rounding(number: int) -> str:
    """What is told of bounds that rounding takes above the tolerance."""
    if not number:
        return ""
    return (
        f"; {number} by rounding of the reduced matrices, as where a contact is stiff, against "
        "which no larger basis helps: full solves are not subject to it"
    )


def of_full_solves(snapshots: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Warnings of full solves, merged."""
    return merged_warnings([(each["point"], each["warnings"]) for each in snapshots], "full solves")


class Timed:
    """The driver of a map: its processor time is counted, its modes have warnings of the scene."""

    def __init__(self, scene: Mapped) -> None:
        self._scene, self.seconds = scene, 0.0

    def solve(self, max_frequency: float, changes: Any, /, **options: Any) -> Any:
        """All modes up to a frequency (Hz)."""
        before = process_time()
        try:
            modes = self._scene.driver.solve(max_frequency, changes, **options)
            return replace(modes, warnings=self._scene.warnings(modes, changes))
        finally:
            self.seconds += process_time() - before
