"""Tables of the programs that assemble."""

from collections.abc import Iterator
from statistics import median
from typing import Any

from comparisons.bench.annulus import MATERIAL
from comparisons.kit.numbers import number, shown
from comparisons.kit.tables import Column, Data, Table

_MILLI = 1e-3
_MICRO = 1e-6
_MEGA = 1e6


def seconds(run: Data) -> float:
    """Processor seconds of both matrices, median of the rounds."""
    return median(map(sum, zip(run["stiffness"], run["mass"], strict=True)))


def ratio(run: Data) -> float:
    """Time of an element over that of the yardstick in the same round, median of the rounds."""
    return median(
        (k + m) / run["elements"] / each
        for k, m, each in zip(run["stiffness"], run["mass"], run["yardstick"], strict=True)
    )


def ran(data: Data) -> list[Data]:
    """Runs that came to an end."""
    return [run for run in data["runs"] if not run["failed"]]


def times_table(data: Data) -> Table:
    """A row for each program and discretisation."""
    return Table(
        "times",
        "Processor time of stiffness and mass on one thread, medians; an element over one of plain "
        "dolfinx Q2, assembled in the same round. Peak: largest memory while assembling over that "
        "before; finished: the matrices, 12 bytes an entry.",
        (
            Column("discretisation", "functions"),
            Column("program", "program"),
            Column("elements", "elements", number),
            Column("dofs", "dofs", number),
            Column("stiffness", "stiffness", shown(3), "ms/element"),
            Column("mass", "mass", shown(3), "ms/element"),
            Column("both", "both", shown(3), "ms/element"),
            Column("per_dof", "both", shown(3), "µs/dof"),
            Column("ratio", "of dolfinx Q2", shown(3)),
            Column("peak", "peak", shown(3), "MB"),
            Column("finished", "finished", shown(3), "MB"),
        ),
        [
            (
                run["discretisation"],
                run["program"],
                run["elements"],
                run["dofs"],
                median(run["stiffness"]) / run["elements"] / _MILLI,
                median(run["mass"]) / run["elements"] / _MILLI,
                seconds(run) / run["elements"] / _MILLI,
                seconds(run) / run["dofs"] / _MICRO,
                ratio(run),
                run["peak"] / _MEGA,
                run["finished"] / _MEGA,
            )
            for run in ran(data)
        ],
    )


def apart(check: Data, reference: Data) -> dict[str, float]:
    """How far what a program gives is from what another does, relative, worst of each kind."""
    return {
        name: max(abs(a / b - 1) for a, b in zip(check[name], reference[name], strict=True))
        for name in ("inertia", "eigenvalues")
    }


def checks_table(data: Data) -> Table:
    """A row for each program and discretisation: what the matrices give."""
    return Table(
        "checks",
        "What the matrices give on a coarse division: the largest force of a rigid motion and the "
        "asymmetry of K, relative to its largest entry; volume; inertia of rigid motions and the "
        "lowest elastic eigenvalues, relative to those of the first program.",
        (
            Column("discretisation", "functions"),
            Column("program", "program"),
            Column("rigid", "rigid motion", shown(2)),
            Column("asymmetry", "asymmetry", shown(2)),
            Column("volume", "volume", shown(9), "m³"),
            Column("inertia", "inertia apart", shown(2)),
            Column("eigenvalues", "eigenvalues apart", shown(2)),
        ),
        list(_checks(data)),
    )


def _checks(data: Data) -> Iterator[tuple[Any, ...]]:
    first: dict[str, Data] = {}
    for run in ran(data):
        check, reference = run["check"], first.setdefault(run["discretisation"], run)
        alone = reference is run
        distance = apart(check, reference["check"])
        yield (
            run["discretisation"],
            run["program"],
            check["rigid"],
            check["asymmetry"],
            check["inertia"][0] / MATERIAL.rho if MATERIAL.rho else None,
            None if alone else distance["inertia"],
            None if alone else distance["eigenvalues"],
        )


def left_out_table(data: Data) -> Table:
    """What was not run, with the reason."""
    return Table(
        "left_out",
        "What was not run.",
        (
            Column("discretisation", "functions"),
            Column("program", "program"),
            Column("reason", "reason"),
        ),
        [
            *(
                ("all", each["program"], f"package {each['needs']} is not installed")
                for each in data["left_out"]
            ),
            *(
                (run["discretisation"], run["program"], run["failed"])
                for run in data["runs"]
                if run["failed"]
            ),
        ],
    )


TABLES = (times_table, checks_table, left_out_table)
