"""Tables of what was run, and on what: parameters of the scenes, things left out, versions."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from comparisons.kit.numbers import plain
from comparisons.kit.tables import Column, Data, Table

Run = tuple[str, str, Data]
"""A run: the part it belongs to, its label, its data (:func:`scenes.results.describe`)."""

_UNITS = {
    "E": "N/m²",
    "rho": "kg/m³",
    "P": "N/m",
    "p": "N/m³",
    "pressure": "N/m²",
    "max_frequency": "Hz",
    "growth_threshold": "1/s",
    "stiffness": "N/m³",
    "start": "°",
    "end": "°",
    "theta": "°",
    "angle": "°",
} | dict.fromkeys(
    (
        *("size", "origin", "inner_radius", "outer_radius", "bottom", "top", "reach"),
        *("translation", "r", "x", "y", "z"),
    ),
    "m",
)


def skipped(runs: Iterable[Run]) -> Table:
    """What the runs of each part did not need, with the reason."""
    of, counts = dict[str, int](), dict[tuple[str, str, str], int]()
    for section, _, run in runs:
        of[section] = of.get(section, 0) + 1
        for what, reason in run["skipped"].items():
            key = (section, what, reason)
            counts[key] = counts.get(key, 0) + 1
    return Table(
        "skipped",
        "What was left out because a scene does not need it.",
        (
            Column("section", "part"),
            Column("left_out", "left out"),
            Column("reason", "reason"),
            Column("runs", "runs"),
        ),
        [(*key, f"{count} of {of[key[0]]}") for key, count in counts.items()],
    )


def parameters(runs: Iterable[Run]) -> Table:
    """Parameters of the scenes as run; several values where runs differ."""
    values: dict[tuple[str, str], list[str]] = {}
    for section, _, run in runs:
        for field, value in _flat(run["scene"]):
            if field != "description":
                seen = values.setdefault((section, field), [])
                if (text := _with_unit(field, value)) not in seen:
                    seen.append(text)
    return Table(
        "parameters",
        "Parameters of the scenes as run; values that differ between runs are set apart by bars.",
        (Column("section", "part"), Column("field", "field"), Column("value", "value")),
        [(*key, " | ".join(texts)) for key, texts in values.items()],
    )


def machine(data: Data) -> Table:
    """Machine, versions, and the commit of the program."""
    rows = [
        *((name, str(value)) for name, value in data["machine"].items()),
        *((name, value) for name, value in data["versions"].items()),
        ("commit", data["commit"]),
    ]
    return Table("machine", "", (Column("name", "name"), Column("value", "value")), rows)


def _flat(value: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Fields that are set, by their path."""
    dot = f"{place}." if place else ""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from _flat(part, f"{dot}{name}")
    elif isinstance(value, list | tuple) and any(isinstance(part, Mapping) for part in value):
        for i, part in enumerate(value):
            yield from _flat(part, f"{dot}{i}")
    elif value is not None and value != "" and value != () and value != []:
        yield place, value


def _with_unit(field: str, value: Any) -> str:
    unit = _UNITS.get(field.rpartition(".")[2], "")
    space = "" if unit in ("", "°") else " "
    return value if isinstance(value, str) else f"{plain(value)}{space}{unit}"
