"""The page of the study: where rules may be used, errors against cost, orders, Pareto fronts."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from cea.timing import STAGES
from comparisons.accuracy.cases import INTEGRATING, YARDSTICKS
from comparisons.accuracy.problems import PROBLEMS
from comparisons.study.columns import Column, wide
from comparisons.study.numbers import counted, number, shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from scenes.spec.body import backend_name

TOLERABLE = 0.01
"""Error of growth, relative to the largest growth rate, up to which a rule is called usable."""
_TOO_COARSE = 0.1
"""Error of growth of a yardstick from which on a mesh says nothing of contact rules."""
_ROUNDING = 1e-9
"""Errors below this say nothing of the order: exact lists and Krylov iteration end here."""
_FITTED = 3
"""Finest meshes that an order is fitted to."""
_METHOD = ["problem", "backend", "degree", "rule"]
LINE = [*_METHOD, "p"]
"""Labels of a line of a plot."""


def runs(result: StudyResult) -> pd.DataFrame:
    """Every run."""
    frame = result.frame()
    return frame if frame.empty else frame.drop(columns="part")


def _drawn(result: StudyResult) -> pd.DataFrame:
    """Runs at the first stiffness that lost no modes."""
    frame = runs(result)
    if frame.empty:
        return frame
    return frame[(frame["p"] == result.record["inputs"]["stiffnesses"][0])].dropna(
        subset="lambda_worst"
    )


def every_degree(result: StudyResult) -> pd.DataFrame:
    """Every degree with mortar."""
    frame = _drawn(result)
    return frame if frame.empty else frame[frame["rule"] == "mortar"]


def every_rule(result: StudyResult) -> pd.DataFrame:
    """Every contact rule at degree 2."""
    frame = _drawn(result)
    return frame if frame.empty else frame[frame["degree"] == 2]


def observed_order(refinements: Any, errors: Any) -> float | None:
    """Exponent q of ``error ~ refinement^-q`` by least squares; None of fewer than two."""
    n, error = np.asarray(refinements, float), np.asarray(errors, float)
    return -float(np.polyfit(np.log(n), np.log(error), 1)[0]) if len(n) > 1 else None


def orders(result: StudyResult) -> pd.DataFrame:
    """Observed orders of the finest meshes whose error is above rounding, beside theory.

    Theory knows the order of a smooth solution integrated exactly, capped by a singularity.
    """
    frame, rows = runs(result), []
    for values, own in frame.groupby(LINE, sort=False) if len(frame) else ():
        line = dict(zip(LINE, values, strict=True))
        fitted = own[own["lambda_worst"] > _ROUNDING][-_FITTED:]
        order = observed_order(fitted["refinement"], fitted["lambda_worst"])
        if order is not None:
            smooth = 2.0 * line["degree"] if line["rule"] in INTEGRATING else None
            cap = PROBLEMS[line["problem"]].highest_order
            theory = min(smooth, cap) if smooth and cap else smooth
            last = own["lambda_worst"].iloc[-1]
            rows.append(line | {"order": order, "theory": theory, "lambda_worst": last})
    return pd.DataFrame(rows)


def pareto(result: StudyResult) -> pd.DataFrame:
    """Runs that none beats in both run time and worst error of lambda."""
    frame = runs(result)
    if frame.empty:
        return frame
    by_time = frame.dropna(subset="lambda_worst").sort_values(["seconds", "lambda_worst"])
    before = by_time.groupby(["problem", "p"])["lambda_worst"].transform(
        lambda error: error.cummin().shift(fill_value=np.inf)
    )
    front = by_time[by_time["lambda_worst"] < before]
    kept = ["dofs", "seconds", "lambda_worst", "growth_worst", "memory"]
    place = {name: i for i, name in enumerate(PROBLEMS)}
    ordered = front.sort_values(["problem", "p", "seconds"], key=lambda c: c.replace(place))
    return ordered[["problem", "p", *_METHOD[1:], "refinement", *kept]]


def uses(result: StudyResult) -> pd.DataFrame:
    """Growth errors of every rule beside a yardstick, on the finest mesh that both were run on.

    Lines without a yardstick at their degree are left out, and meshes on which the yardstick itself
    lost modes or is far off.
    """
    frame = runs(result)
    if frame.empty:
        return frame
    mesh = ["problem", "backend", "degree", "p", "refinement"]
    best = pd.DataFrame()
    for rule in reversed(YARDSTICKS):  # a better one takes the place of a worse one
        own = frame.loc[frame["rule"] == rule, [*mesh, "growth_worst"]]
        own = own.rename(columns={"growth_worst": "floor"}).assign(yardstick=rule)
        beside = frame.loc[frame["rule"] != rule, [*mesh, "rule", "growth_worst"]].merge(own)
        best = pd.concat([best, beside]).drop_duplicates([*mesh, "rule"], keep="last")
    best = best[best["floor"] <= _TOO_COARSE].sort_values("refinement")
    best = best.drop_duplicates(LINE, keep="last")
    best["usable"] = best["growth_worst"] <= np.maximum(TOLERABLE, 2 * best["floor"])
    found = frame[LINE].drop_duplicates().merge(best, on=LINE)
    return found[[*LINE, "refinement", "growth_worst", "yardstick", "floor", "usable"]]


def judged(result: StudyResult) -> pd.DataFrame:
    """Rules that users choose among, at degree 2: over all problems usable, or how far off."""
    frame = uses(result)
    if frame.empty:
        return frame
    frame = frame[(frame["degree"] == 2) & ~frame["rule"].isin(INTEGRATING)]
    frame = frame.assign(lost=frame["growth_worst"].isna())
    cells = frame.groupby(["backend", "rule", "p"], sort=False).agg(
        usable=("usable", "all"),
        lost=("lost", "any"),
        growth_worst=("growth_worst", "max"),
        floor=("floor", "max"),
    )
    return cells.reset_index()


def matrix(result: StudyResult) -> pd.DataFrame:
    """For every rule and p whether it may be used, and its worst error; what yardsticks reach."""
    cells = judged(result)
    if cells.empty:
        return cells
    floors = cells.groupby(["backend", "p"], sort=False)["floor"].max().reset_index()
    floors = floors.assign(rule="yardstick", text=floors["floor"].map(shown(2)))
    cells["text"] = [
        f"{'✓' if usable else '✗'} {'modes lost' if lost else number(error, 2)}"
        for usable, lost, error in zip(
            cells["usable"], cells["lost"], cells["growth_worst"], strict=True
        )
    ]
    every = pd.concat([cells, floors]).sort_values("p", kind="stable")
    order = pd.concat([cells, floors])[["backend", "rule"]].drop_duplicates()
    return order.merge(wide(every, ["backend", "rule"], "p", "text"))


def against_stiffness(result: StudyResult) -> pd.DataFrame:
    """Growth errors of rules at degree 2, by rising p."""
    frame = uses(result)
    if frame.empty:
        return frame
    return frame[(frame["degree"] == 2) & (frame["growth_worst"] > 0)].sort_values("p")


def in_short(result: StudyResult) -> str:
    """Contact rules that may be used at every stiffness."""
    cells = judged(result)
    if cells.empty:
        return "No formulation could be judged: no yardstick was run beside one."
    every = cells.groupby(["backend", "rule"], sort=False)["usable"].all()
    rules = [f"{rule} ({backend_name(backend)})" for backend, rule in every[every].index]
    return f"Usable in every problem at every p tried: {'; '.join(rules) or 'none'}."


def unexplained(result: StudyResult) -> str | None:
    """How often something grew that must not."""
    frame = result.frame("no_flutter")
    if frame.empty:
        return None
    grown = frame[frame["unexplained"] > 0]
    told = "".join(
        f" {row['rule']} ({backend_name(row['backend'])}; {row['problem']}) lets "
        f"{counted(row['unexplained'], 'mode')} of {row['modes']} grow or decay, by up to "
        f"{number(row['growth'], 2)} of abs(λ)."
        for row in grown.to_dict("records")
    )
    return (
        f"In {len(frame) - len(grown)} of {counted(len(frame), 'run')} no mode grows by more than "
        f"its residual times its condition number explains.{told}"
    )


def digits(result: StudyResult) -> str | None:
    """The error that no finest mesh exceeds, by backend."""
    frame = result.frame("finest")
    if frame.empty:
        return None
    lost = frame["lambda_worst"].isna().sum()
    met = (frame["lambda_worst"] <= frame["bound"]).sum()
    return f"{met} of {counted(len(frame), 'run')} within the error asked for, {lost} lost modes."


def lost(result: StudyResult) -> pd.DataFrame:
    """Runs that missed listed modes, or found modes in the band that stand for none."""
    frame = runs(result)
    if frame.empty:
        return frame
    found = frame[(frame["missing"] > 0) | (frame["spurious"] > 0)]
    return found[[*LINE, "refinement", "modes", "missing", "spurious"]]


def _without_part(table: str) -> Callable[[StudyResult], pd.DataFrame]:
    return lambda result: result.frame(table).drop(columns="part", errors="ignore")


def _plot(name: str, caption: str, frame: Any, x: str, series: tuple[str, ...]) -> Plot:
    return Plot(name, caption, frame, x, "lambda_worst", series, "problem", "xy", COLUMNS)


_TWO, _COUNT = shown(2), number
COLUMNS = {
    "problem": Column("problem"),
    "rule": Column("contact rule"),
    "degree": Column("degree", show=_COUNT),
    "p": Column("p", show=shown(3)),
    "refinement": Column("refinement", show=_COUNT),
    **{
        f"{name}_{which}": Column(f"{which} error of {name}", show=_TWO)
        for name in ("lambda", "frequency", "growth")
        for which in ("worst", "median")
    },
    **{stage: Column(stage, "s", _TWO) for stage in STAGES},
    "memory_process": Column("whole process", "MB", shown(3)),
    "modes": Column("modes", show=_COUNT),
    "order": Column("observed order", show=_TWO),
    "theory": Column("theory", show=_TWO),
    "floor": Column("error of the yardstick", show=_TWO),
    "growth": Column("largest growth", show=_TWO),
    "explained": Column("explained", show=_TWO),
    "bound": Column("asked for", show=_TWO),
    "compared": Column("listed", show=_COUNT),
}
SECTIONS = [
    Section(
        "Where each formulation may be used",
        "A number is the worst error of the growth rate over all problems, relative to the largest "
        "growth rate of the listed modes, on bodies of degree 2 and the finest mesh that a "
        "yardstick was run on too (mortar; where that failed, segments, then GPTS); meshes too "
        f"coarse for it are left out. ✓: in every problem at most {TOLERABLE:g} or twice the error "
        "of the yardstick, which is that of the bodies' meshes. p counts in units of each problem.",
        in_short,
        tables=[
            Table("matrix", "Formulations by p.", matrix, COLUMNS, printed=True),
            Table("uses", "Every rule beside its yardstick.", uses, COLUMNS, shown=False),
        ],
        plots=[
            Plot(
                "growth",
                "Worst error of growth against p, bodies of degree 2.",
                *(against_stiffness, "p", "growth_worst", ("rule", "backend"), "problem", "xy"),
                own=COLUMNS,
            )
        ],
    ),
    Section(
        "Error against cost",
        "Run time is processor time on one thread, median of the runs, from geometry to "
        "eigenpairs; the first run of each problem and method in a process is not timed. Peak "
        "memory is above what the process held before. Errors of lambda are relative to "
        "abs(lambda), over all listed modes of the band.",
        plots=[
            _plot(f"{part}_{x}", caption, frame, x, series)
            for part, frame, caption, series in (
                ("degrees", every_degree, "Every degree, mortar.", ("degree", "backend")),
                ("rules", every_rule, "Degree 2, every contact rule.", ("rule", "backend")),
            )
            for x in ("seconds", "dofs")
        ],
        tables=[
            Table(
                "pareto",
                "Runs that no other beats in both run time and worst error of lambda.",
                *(pareto, COLUMNS),
                group="problem",
            ),
            Table(
                "orders",
                "Order of the worst error of lambda in the mesh size. Theory: twice the degree "
                "where the solution is smooth and the traces are integrated exactly; a corner "
                "singularity caps it; point rules have no order of their own.",
                *(orders, COLUMNS),
                group="problem",
            ),
            Table("runs", "Every run.", runs, COLUMNS, shown=False),
        ],
    ),
    Section(
        "Where nothing may grow",
        "Problems that cannot flutter: largest growth relative to abs(lambda), and what residual "
        "times condition explains of it.",
        unexplained,
        tables=[Table("no_flutter", "", _without_part("no_flutter"), COLUMNS)],
    ),
    Section(
        "Finest meshes",
        "Worst relative error of every listed eigenvalue.",
        digits,
        tables=[Table("finest", "", _without_part("finest"), COLUMNS)],
    ),
    Section(
        "Omissions",
        tables=[
            Table("omissions", "Meshes at which a line ends.", _without_part("omissions"), COLUMNS),
            Table(
                "incomplete",
                "Runs that missed listed modes (they have no error and are not drawn), or found "
                "modes in the band that stand for none.",
                *(lost, COLUMNS),
            ),
        ],
    ),
]
