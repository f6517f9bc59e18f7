"""Merged warnings of many runs: one for each kind and subject."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

_LISTED = 4  # number of runs up to which all are named
Run = tuple[Mapping[str, Any], Iterable[Mapping[str, Any]]]
"""Parameters of a run by name, and its warnings as plain data."""


def merged_warnings(runs: Sequence[Run], what: str) -> list[dict[str, Any]]:
    """Warnings of all runs in the form of a record, with the runs that gave them.

    Warnings of one kind are merged if all texts in their data, such as the names of the contact and
    the body, are equal. ``places`` in ``data`` lists the runs with ``point`` (their parameters),
    ``message`` and ``data``; ``what`` names the runs: "values of mu".
    """
    given: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for point, warnings in runs:
        for warning in warnings:
            about = (item for item in warning["data"].items() if isinstance(item[1], str))
            place = {"point": dict(point), "message": warning["message"], "data": warning["data"]}
            given.setdefault((warning["kind"], *sorted(about)), []).append(place)
    return [
        {
            "kind": key[0],
            "message": _message(places, len(runs), what),
            "data": {"places": places},
        }
        for key, places in given.items()
    ]


def kinds_at(warnings: Iterable[Mapping[str, Any]], point: Mapping[str, Any]) -> list[str]:
    """Kinds of merged warnings that the run at a point gave."""
    return [
        warning["kind"]
        for warning in warnings
        if any(place["point"] == point for place in warning["data"].get("places", ()))
    ]


def _message(places: Sequence[Mapping[str, Any]], total: int, what: str) -> str:
    """Message of the first warning, and the runs that gave it or a similar one."""
    message, points = places[0]["message"], [place["point"] for place in places]
    if total == 1:
        return str(message)
    where = f"at all {total} {what}"
    if len(places) < total:
        few = f": {'; '.join(map(named, points))}" if len(points) <= _LISTED else ""
        where = f"at {len(places)} of {total} {what}{few}"
    if any(place["message"] != message for place in places):
        where = f"at {named(points[0])}, similar {where}"
    return f"{message} ({where})"


def named(point: Mapping[str, Any]) -> str:
    """Names and values of a point as text."""
    values = ((n, f"{v:.6g}" if isinstance(v, float) else v) for n, v in point.items())
    return ", ".join(f"{name} = {value}" for name, value in values)
