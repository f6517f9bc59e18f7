"""Tables of runs on more ranks, with more unknowns, of higher degrees."""

from statistics import median

import numpy as np

from cea.timing import STAGES
from comparisons.bench.scaling.model import (
    MODES,
    RANKS,
    UNKNOWNS,
    by_kind,
    exponents,
    needs,
    solved,
    stage,
    total,
)
from comparisons.bench.scaling.study import told
from comparisons.kit.numbers import number, shown
from comparisons.kit.tables import Column, Data, Table

_MEGA = 1e6
_KINDS = ("size", "strong", "weak", "degree")


def ran(data: Data) -> list[Data]:
    """Runs that came to an end."""
    return [run for run in data["runs"] if not run["failed"]]


def runs_table(data: Data) -> Table:
    """A row for each run."""
    return Table(
        "runs",
        "Whole runs of disc_pad, stages in processor time of all ranks; medians. Peak: largest "
        "memory of all ranks, the program itself too.",
        (
            Column("kind", "row"),
            Column("backend", "functions"),
            Column("degree", "degree", number),
            Column("ranks", "ranks", number),
            Column("unknowns", "unknowns", number),
            Column("clock", "clock", shown(3), "s"),
            Column("processor", "processor", shown(3), "s"),
            *(Column(name.replace("-", "_"), name, shown(3), "s") for name in STAGES),
            Column("peak", "peak", shown(3), "MB"),
            Column("modes", "modes", number),
        ),
        [
            (
                run["kind"],
                {"fe": "Lagrange", "iga": "NURBS"}[run["backend"]],
                run["degree"],
                run["ranks"],
                run["answers"][0]["unknowns"],
                median(answer["whole"] for answer in run["answers"]),
                total(run),
                *(stage(run, name) for name in STAGES),
                run["answers"][0]["peak"] / _MEGA,
                len(run["answers"][0]["eigenvalues"]),
            )
            for kind in _KINDS
            for run in ran(data)
            if run["kind"] == kind
        ],
    )


def ranks_table(data: Data) -> Table:
    """A row for each row of ranks and stage: how much sooner the last rank is done."""
    rows = []
    for kind in ("strong", "weak"):
        runs = sorted((r for r in ran(data) if r["kind"] == kind), key=lambda run: run["ranks"])
        for run in runs[1:]:
            first = runs[0]
            rows += [
                (
                    kind,
                    run["ranks"],
                    name,
                    stage(first, name, "busiest"),
                    stage(run, name, "busiest"),
                    stage(first, name, "busiest") / stage(run, name, "busiest"),
                )
                for name in STAGES
                if stage(run, name, "busiest") > 0
            ]
            whole = [median(a["longest"] for a in each["answers"]) for each in (first, run)]
            rows.append((kind, run["ranks"], "whole", *whole, whole[0] / whole[1]))
    return Table(
        "ranks",
        "Processor time of the rank that works longest, on the fewest ranks and on more; what it "
        "waits for others is work too. Strong: the same mesh on all; the ratio is the ranks at "
        "best. Weak: as many unknowns on each rank; the ratio is 1 at best.",
        (
            Column("kind", "row"),
            Column("ranks", "ranks", number),
            Column("stage", "stage"),
            Column("fewest", "on the fewest", shown(3), "s"),
            Column("more", "on these", shown(3), "s"),
            Column("ratio", "ratio", shown(3)),
        ),
        rows,
    )


def growth_table(data: Data) -> Table:
    """A row for each stage: the powers of the unknowns by which it grew."""
    runs = [run for run in by_kind(data, "size") if not run["failed"]]
    return Table(
        "growth",
        "Powers of the unknowns by which processor time grew from one size to the next: median, "
        "and the last.",
        (
            Column("stage", "stage"),
            Column("median", "median", shown(3)),
            Column("last", "last", shown(3)),
        ),
        [(name, median(found), found[-1]) for name in STAGES if (found := exponents(runs, name))],
    )


def inverses_table(data: Data) -> Table:
    """A row for each inverse and size."""
    exact = {
        inverse["unknowns"]: inverse["kappa"]
        for inverse in data["inverses"]
        if inverse["way"] == "mumps" and solved(inverse)
    }
    rows = []
    for inverse in data["inverses"]:
        values, right = inverse.get("kappa"), exact.get(inverse["unknowns"])
        apart = None
        if values and right and inverse["way"] != "mumps":
            apart = float(np.abs(np.array(values) - right).max() / np.abs(right).max())
        rows.append(
            (
                {"mumps": "MUMPS", "gamg": "GMRES, multigrid"}[inverse["way"]],
                "zero" if not inverse["shift"] else "in the window",
                inverse["unknowns"],
                inverse.get("setup"),
                inverse.get("solve"),
                inverse.get("steps"),
                inverse.get("solves"),
                inverse.get("whole"),
                inverse["memory"] / _MEGA if "memory" in inverse else None,
                apart,
                inverse["failed"] or ("found" if values else "systems solved"),
            )
        )
    return Table(
        "inverses",
        "Shift-and-invert by factors and by GMRES with algebraic multigrid of the symmetric part; "
        "processor time. Memory: beside that of the matrices. Apart: from the eigenvalues by "
        "factors, relative to the largest of them.",
        (
            Column("way", "inverse"),
            Column("shift", "shift"),
            Column("unknowns", "unknowns", number),
            Column("setup", "setup", shown(3), "s"),
            Column("solve", "a solve", shown(3), "s"),
            Column("steps", "steps", number),
            Column("solves", "solves", number),
            Column("whole", "eigenvalues", shown(3), "s"),
            Column("memory", "memory", shown(3), "MB"),
            Column("apart", "apart", shown(2)),
            Column("told", "verdict"),
        ),
        rows,
    )


def needs_table(data: Data) -> Table:
    """A row for each part: what it would need on more ranks."""
    return Table(
        "needs",
        f"A model, no measurement: what {number(UNKNOWNS)} unknowns, {MODES} modes would need of "
        f"each of {RANKS} ranks, were all work spread evenly.",
        (
            Column("part", "part"),
            Column("exponent", "grows like n to", shown(3)),
            Column("unknowns", "measured at", number),
            Column("hours", "time", shown(2), "h"),
            Column("gigabytes", "memory", shown(2), "GB"),
        ),
        [(n.part, n.exponent, n.unknowns, n.hours, n.gigabytes) for n in needs(data)],
    )


def left_out_table(data: Data) -> Table:
    """Runs that came to no end, and what was not tried."""
    return Table(
        "left_out",
        "What came to no end, or was not tried.",
        (Column("what", "what"), Column("reason", "reason")),
        [
            *((told(run), run["failed"]) for run in data["runs"] if run["failed"]),
            ("BDDC", "needs matrices that are not assembled across elements"),
            ("HPDDM, hypre", "not in the build of PETSc that this program uses"),
        ],
    )


TABLES = (
    runs_table,
    ranks_table,
    growth_table,
    inverses_table,
    needs_table,
    left_out_table,
)
