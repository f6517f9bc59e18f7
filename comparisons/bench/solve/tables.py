"""Tables of the methods."""

from statistics import median

from comparisons.kit.numbers import number, shown
from comparisons.kit.tables import Column, Data, Table

_MEGA = 1e6


def ran(data: Data) -> list[Data]:
    """Methods that came to an end."""
    return [method for method in data["methods"] if not method["failed"]]


def in_factorisations(method: Data) -> float:
    """Processor time in numeric factorisations of the same process, median of the repeats."""
    return median(a / b for a, b in zip(method["processor"], method["lu"], strict=True))


def methods_table(data: Data) -> Table:
    """A row for each method."""
    return Table(
        "methods",
        "Processor time of all ranks, medians, also in numeric factorisations (LU) at the common "
        "shift; what PETSc counted; largest memory of all ranks, and that before the method began; "
        "backward error; error of the eigenvalues (lambda^2, relative) against the tightest "
        "answer.",
        (
            Column("method", "method"),
            Column("clock", "clock", shown(3), "s"),
            Column("processor", "processor", shown(3), "s"),
            Column("factorisations_worth", "time", shown(3), "LU"),
            Column("factorisations", "factorised", number),
            Column("solves", "solves", number),
            Column("blocks", "of blocks", number),
            Column("peak", "peak", shown(3), "MB"),
            Column("before", "before", shown(3), "MB"),
            Column("eigenvalues", "eigenvalues", number),
            Column("unstable", "unstable", number),
            Column("backward", "backward error", shown(2)),
            Column("median", "error, median", shown(2)),
            Column("worst", "worst", shown(2)),
            Column("missing", "missing", number),
        ),
        [
            (
                method["name"],
                median(method["clock"]),
                median(method["processor"]),
                in_factorisations(method),
                method["counts"]["factorisations"] or None,
                method["counts"]["solves"] or None,
                method["counts"]["blocks"] or None,
                method["peak"] / _MEGA,
                method["before"] / _MEGA,
                len(method["eigenvalues"]),
                method["unstable"],
                max(method["backward_errors"]),
                median(method["errors"]),
                max(method["errors"]),
                method["missing"],
            )
            for method in ran(data)
        ],
    )


def stages_table(data: Data) -> Table:
    """A row for each stage of the methods that tell theirs."""
    return Table(
        "stages",
        "Processor time by stage, of the last run.",
        (
            Column("method", "method"),
            Column("stage", "stage"),
            Column("processor", "processor", shown(3), "s"),
            Column("factorisations_worth", "time", shown(3), "LU"),
        ),
        [
            (method["name"], stage, value, value / method["lu"][-1])
            for method in ran(data)
            for stage, value in method["stages"].items()
        ],
    )


def left_out_table(data: Data) -> Table:
    """What was not run, or did not end."""
    return Table(
        "left_out",
        "What was not run, or came to no end.",
        (Column("method", "method"), Column("reason", "reason")),
        [
            *((each["name"], each["reason"]) for each in data["left_out"]),
            *((each["name"], each["failed"]) for each in data["methods"] if each["failed"]),
        ],
    )


TABLES = (methods_table, stages_table, left_out_table)
