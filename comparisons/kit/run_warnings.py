"""Warnings of many runs in few lines: one for each kind and what it is about."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

_LISTED = 4
"""Numbers up to which all are named."""

Run = tuple[Mapping[str, Any], Iterable[Mapping[str, Any]]]
"""What sets a run apart, by name, and its warnings as plain data."""


def merged_warnings(runs: Sequence[Run], what: str) -> list[dict[str, Any]]:
    """Warnings of runs as a record has them, with the runs that gave them.

    Warnings of one kind are one where they are about the same: the contact, the body and whatever
    else their data name in words.

    Parameters
    ----------
    runs
        All runs, those without warnings too.
    what
        The runs in words: "values of mu".

    Returns
    -------
    list
        ``kind``, ``message`` and ``data``, whose ``places`` are the runs with ``point``, what sets
        the run apart, and its own ``message`` and ``data``.
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
    """What the first says, and where that is so, or the like."""
    first = places[0]
    if total == 1:
        return str(first["message"])
    every = f"all {total} {what}" if len(places) == total else f"{len(places)} of {total} {what}"
    where = f"at {every}{_between(places) if len(places) < total else ''}"
    if any(place["message"] != first["message"] for place in places):
        own = ", ".join(f"{name} = {_shown(value)}" for name, value in first["point"].items())
        where = f"so at {own}, and the like {where}"
    return f"{first['message']} ({where})"


def _between(places: Sequence[Mapping[str, Any]]) -> str:
    """The numbers of places that one number sets apart, or their range."""
    points = [list(place["point"].values()) for place in places]
    if any(len(point) != 1 or not isinstance(point[0], float) for point in points):
        return ""
    numbers = sorted(point[0] for point in points)
    if len(numbers) > _LISTED:
        return f", from {_shown(numbers[0])} to {_shown(numbers[-1])}"
    return f": {', '.join(map(_shown, numbers))}"


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
