"""Tables of a study: every run, orders of convergence, Pareto fronts, uses, omissions."""

from typing import Any

from cea.timing import STAGES
from comparisons.accuracy.analysis import (
    grouped_omissions,
    incomplete,
    lines,
    method_of,
    pareto,
    seconds_of,
    uses,
)
from comparisons.accuracy.matrix import matrix_table
from comparisons.accuracy.study import RULES, Method
from comparisons.kit.numbers import counted, number, plain, shown
from comparisons.kit.tables import Column, Table

Data = dict[str, Any]

_FEW = 8
"""Methods that are listed one by one."""
_QUANTITIES = ("lambda", "frequency", "growth")


def every_run(data: Data) -> Table:
    """Every run with all that was measured."""
    columns = (
        *_case_columns(),
        Column("dofs", "dofs", number),
        Column("points", "contact points", number),
        *(
            Column(f"{quantity}_{which}", f"{quantity}, {which}", shown(2))
            for quantity in _QUANTITIES
            for which in ("worst", "median")
        ),
        Column("seconds", "run time", shown(3), "s"),
        *(Column(f"seconds_{stage}", stage, shown(2), "s") for stage in STAGES),
        Column("memory", "peak memory", shown(3), "MB"),
        Column("memory_process", "whole process", shown(3), "MB"),
        Column("modes", "modes", number),
        Column("missing", "missing", number),
        Column("spurious", "spurious", number),
    )
    rows = [
        (
            *_case(run),
            run["dofs"],
            run["points"],
            *(run[q][which] for q in _QUANTITIES for which in ("worst", "median")),
            seconds_of(run),
            *(run["stages"].get(stage) for stage in STAGES),
            run["memory"],
            run["memory_process"],
            run["modes"],
            len(run["missing"]),
            len(run["spurious"]),
        )
        for run in data["runs"]
    ]
    return Table("runs", "Every run.", columns, rows)


def orders(data: Data) -> Table:
    """Observed orders of convergence beside theory."""
    rows = [
        (
            line.problem,
            line.method.label,
            line.stiffness,
            len(line.runs),
            line.order,
            line.theory(data["problems"][line.problem]["highest_order"]),
            line.errors()[-1] if line.runs[-1]["lambda"]["worst"] is not None else None,
        )
        for line in lines(data["runs"])
        if line.order is not None
    ]
    return Table(
        "orders",
        "Order of the worst error of lambda in the mesh size, fitted to the finest meshes of each "
        "line. Theory: twice the degree where the solution is smooth and the traces are integrated "
        "exactly; a corner singularity caps it; point rules have no order of their own.",
        (
            Column("problem", "problem"),
            Column("method", "method"),
            Column("stiffness", "p", shown(3)),
            Column("meshes", "meshes", number),
            Column("order", "observed", shown(2)),
            Column("theory", "theory", shown(2)),
            Column("finest_error", "error on the finest", shown(2)),
        ),
        rows,
    )


def fronts(data: Data) -> Table:
    """Pareto fronts of worst error of lambda against run time."""
    rows = [
        (
            *_case(run),
            run["dofs"],
            seconds_of(run),
            run["lambda"]["worst"],
            run["growth"]["worst"],
            run["memory"],
        )
        for problem in data["problems"]
        for p in data["inputs"]["study"]["stiffnesses"]
        for run in pareto(r for r in data["runs"] if (r["problem"], r["stiffness"]) == (problem, p))
    ]
    return Table(
        "pareto",
        "Runs that no other beats in both run time and worst error of lambda.",
        (
            *_case_columns(),
            Column("dofs", "dofs", number),
            Column("seconds", "run time", shown(3), "s"),
            Column("lambda_worst", "worst error of lambda", shown(2)),
            Column("growth_worst", "worst error of growth", shown(2)),
            Column("memory", "peak memory", shown(3), "MB"),
        ),
        rows,
    )


def where_usable(data: Data) -> Table:
    """Growth errors of every rule beside a yardstick on the same mesh."""
    rows = [
        (
            use.problem,
            use.method.discretisation,
            RULES[use.method.rule].label,
            use.stiffness,
            use.refinement,
            use.error,
            RULES[use.yardstick].label,
            use.floor,
            "yes" if use.usable else "no",
        )
        for use in uses(data["runs"])
    ]
    return Table(
        "uses",
        "Worst error of the growth rate, relative to the largest of the listed modes, on the "
        "finest mesh that the yardstick was run on too.",
        (
            Column("problem", "problem"),
            Column("bodies", "bodies"),
            Column("rule", "contact rule"),
            Column("stiffness", "p", shown(3)),
            Column("refinement", "refinement", number),
            Column("growth_worst", "error of growth", shown(2)),
            Column("yardstick", "yardstick"),
            Column("yardstick_growth_worst", "its error", shown(2)),
            Column("usable", "usable"),
        ),
        rows,
    )


def omitted(data: Data) -> Table:
    """What gave no numbers, by problem and reason."""
    rows = [
        (problem, len(cases), _methods(cases), reason)
        for (problem, reason), cases in grouped_omissions(data["omissions"]).items()
    ]
    return Table(
        "omissions",
        "Cases that gave no numbers.",
        (
            Column("problem", "problem"),
            Column("cases", "cases", number),
            Column("methods", "methods"),
            Column("reason", "reason"),
        ),
        rows,
    )


def incomplete_runs(data: Data) -> Table:
    """Runs whose eigenvalues do not all have partners."""
    rows = [
        (*_case(run), run["modes"], len(run["missing"]), len(run["spurious"]))
        for run in incomplete(data["runs"])
    ]
    return Table(
        "incomplete",
        "Runs that missed listed modes (they have no error and are not drawn), or found modes in "
        "the band that stand for none.",
        (
            *_case_columns(),
            Column("modes", "listed", number),
            Column("missing", "missing", number),
            Column("spurious", "spurious", number),
        ),
        rows,
    )


def finest_meshes(data: Data) -> Table:
    """Errors on the finest meshes, one row for each stiffness and friction."""
    rows = [
        (
            run["problem"],
            Method(run["backend"], run["degree"], run["formulation"]).label,
            "; ".join(f"{name} {plain(n)}" for name, n in run["elements"].items()),
            run["p"],
            run["mu"],
            run["dofs"],
            run["compared"],
            run["modes"],
            run["worst"],
            run["bound"],
            run["residual"],
            run["condition"],
            run["seconds"],
        )
        for run in data.get("finest", [])
    ]
    return Table(
        "finest",
        "Worst relative error of every listed eigenvalue on the finest meshes.",
        (
            Column("problem", "problem"),
            Column("method", "method"),
            Column("elements", "elements"),
            Column("p", "p", shown(3), "N/m³"),
            Column("mu", "mu", shown(2)),
            Column("dofs", "dofs", number),
            Column("compared", "listed", number),
            Column("modes", "modes found", number),
            Column("lambda_worst", "worst error of lambda", shown(2)),
            Column("bound", "asked for", shown(2)),
            Column("residual", "largest residual", shown(2)),
            Column("condition", "largest condition", shown(2)),
            Column("seconds", "run time", shown(3), "s"),
        ),
        rows,
    )


def without_flutter(data: Data) -> Table:
    """Growth in problems that cannot flutter."""
    rows = [
        (
            run["problem"],
            method_of(run).label,
            run["modes"],
            run["growth"],
            run["rounding"],
            run["unexplained"],
        )
        for run in data.get("no_flutter", [])
    ]
    return Table(
        "no_flutter",
        "Largest growth relative to abs(lambda) in problems that cannot flutter, and what residual "
        "times condition explains of it.",
        (
            Column("problem", "problem"),
            Column("method", "method"),
            Column("modes", "modes", number),
            Column("growth", "largest growth", shown(2)),
            Column("rounding", "explained", shown(2)),
            Column("unexplained", "modes unexplained", number),
        ),
        rows,
    )


TABLES = (
    matrix_table,
    every_run,
    orders,
    fronts,
    where_usable,
    omitted,
    incomplete_runs,
    finest_meshes,
    without_flutter,
)
"""Every table; each is a CSV file."""


def _methods(cases: list[Any]) -> str:
    """Their methods, or how many they are."""
    labels = list(dict.fromkeys(method_of(case).label for case in cases))
    return "; ".join(labels) if len(labels) <= _FEW else counted(len(labels), "method")


def _case_columns() -> tuple[Column, ...]:
    return (
        Column("problem", "problem"),
        Column("method", "method"),
        Column("stiffness", "p", shown(3)),
        Column("refinement", "refinement", number),
    )


def _case(run: Any) -> tuple[Any, ...]:
    return run["problem"], method_of(run).label, run["stiffness"], run["refinement"]
