"""Tables of the study of stability."""

from collections import Counter
from collections.abc import Iterable
from math import log10
from typing import Any, get_args

from comparisons.kit.numbers import decimals, number, shown
from comparisons.kit.tables import VERDICTS, Column, Data, Table
from comparisons.stability.parts.case import Verdict
from scenes.names import backend_name

KINDS: tuple[str, ...] = get_args(Verdict)
"""Every verdict, the best first."""

_MOST_DIGITS = 16.0


def digits(run: Data) -> float | None:
    """Correct digits of the worst mode of a run; 0 where one is missing, None without an answer."""
    if run["error"] is None:
        return None
    return max(0.0, min(_MOST_DIGITS, -log10(max(run["error"], 10**-_MOST_DIGITS))))


def verdicts_table(data: Data) -> Table:
    """A row for each case: how many runs gave which verdict."""
    return Table(
        "verdicts",
        "Verdicts on the runs of each case, and how many are not as expected.",
        (Column("case", "case"), *_COUNTS),
        [(name, *_counts(_of(data, name))) for name in data["cases"]],
    )


def cases_table(data: Data) -> Table:
    """A row for each case: how many runs gave which verdict, and the worst of its answers."""
    rows = []
    for name, case in data["cases"].items():
        own = _of(data, name)
        rows.append(
            (
                case["subject"],
                case["title"],
                name,
                *_counts(own),
                _least(digits(run) for run in own if run["verdict"] == "accurate"),
                *(_largest(run[key] for run in own) for key in ("residual", "condition")),
                _largest(run["seconds"] for run in own),
            )
        )
    return Table(
        "cases",
        "Verdicts on the runs of each case, and how many are not as expected; of accurate runs the "
        "fewest correct digits; the worst residual and condition, the longest run.",
        (
            Column("section", "subject"),
            Column("title", "case"),
            Column("case", "name"),
            *_COUNTS,
            Column("digits", "digits", decimals(1)),
            Column("residual", "residual", shown(1)),
            Column("condition", "condition", shown(2)),
            Column("seconds", "longest", decimals(2), "s"),
        ),
        sorted(rows, key=lambda row: list(subjects(data)).index(row[0])),
    )


def subjects(data: Data) -> list[str]:
    """Subjects of the cases that were run."""
    return list(dict.fromkeys(case["subject"] for case in data["cases"].values()))


_COUNTS = (
    Column("runs", "runs", number),
    *(Column(kind, kind, number) for kind in KINDS),
    Column("not_met", "not as expected", number),
)


def _of(data: Data, case: str) -> list[Data]:
    return [run for run in data["runs"] if run["case"] == case]


def _counts(runs: list[Data]) -> tuple[int, ...]:
    counts = Counter(run["verdict"] for run in runs)
    return len(runs), *(counts[kind] for kind in KINDS), sum(not run["met"] for run in runs)


def runs_table(data: Data) -> Table:
    """Every run."""
    return Table(
        "runs",
        "Every run: its worst relative error of λ (∞ where modes are missing or spurious), worst "
        "residual and condition, its time, what it says, and the verdict.",
        (
            Column("section", "case"),
            *_COLUMNS,
        ),
        [_row(data, run) for run in data["runs"]],
    )


def not_met_table(data: Data) -> Table:
    """Runs with another verdict, or other warnings, than the catalogue says beforehand."""
    return Table(
        "not_met",
        "Runs that came out otherwise than the catalogue says beforehand.",
        (Column("section", "case"), *_COLUMNS),
        [_row(data, run) for run in data["runs"] if not run["met"]],
    )


_COLUMNS = (
    Column("row", "run"),
    Column("backend", "backend", backend_name),
    Column("formulation", "formulation"),
    Column("verdict", "verdict"),
    Column("expected", "expected"),
    Column("met", "as expected", VERDICTS.__getitem__),
    Column("reference", "reference"),
    Column("error", "error", shown(2)),
    Column("tolerance", "tolerance", shown(1)),
    Column("missing", "missing", number),
    Column("spurious", "spurious", number),
    Column("residual", "residual", shown(1)),
    Column("condition", "condition", shown(2)),
    Column("modes", "modes", number),
    Column("dofs", "dofs", number),
    Column("seconds", "time", decimals(3), "s"),
    Column("says", "it says"),
    Column("reason", "why"),
)


def _row(data: Data, run: Data) -> tuple[Any, ...]:
    told = {**run, "expected": ", ".join(run["expected"]), "says": ", ".join(run["says"])}
    return data["cases"][run["case"]]["title"], *(told[column.name] for column in _COLUMNS)


def _least(values: Iterable[float | None]) -> float | None:
    return min((value for value in values if value is not None), default=None)


def _largest(values: Iterable[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)
