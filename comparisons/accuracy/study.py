"""Error of flutter eigenvalues against run time: every discretisation with every formulation."""

from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from comparisons.accuracy.cases import YARDSTICKS, Options, cases, evaluate
from comparisons.study.columns import wide
from comparisons.study.numbers import number, shown
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Process, Study, StudyResult
from scenes.spec.body import backend_name

TOLERABLE = 0.01
"""Error of growth relative to the largest growth rate, up to which a rule is usable."""
_TOO_COARSE = 0.1  # error of growth of the reference rule above which a mesh is left out
LINE = ["problem", "backend", "degree", "rule", "p"]  # labels of a line of a plot


def _drawn(which: str, result: StudyResult) -> pd.DataFrame:
    """Runs at the first stiffness of the options without missing modes."""
    first = result.frame().query("p == @result.record['inputs']['stiffnesses'][0]")
    return first.dropna(subset="lambda_worst").query(which)


def uses(result: StudyResult) -> pd.DataFrame:
    """Growth errors of every rule and of its reference, on the finest mesh with both.

    The reference rule is mortar, or segments where mortar failed. Lines without a reference at
    their degree are left out, and meshes on which the reference lost modes or is inaccurate.
    """
    frame = result.frame()
    mesh = ["problem", "backend", "degree", "p", "refinement"]
    floors = frame.loc[frame["rule"].isin(YARDSTICKS), [*mesh, "rule", "growth_worst"]]
    floors = floors.rename(columns={"rule": "yardstick", "growth_worst": "floor"})
    beside = frame.merge(floors, on=mesh).query("rule != yardstick")
    best = beside.sort_values("yardstick").drop_duplicates([*mesh, "rule"])  # mortar comes first
    best = best[best["floor"] <= _TOO_COARSE].sort_values("refinement")
    best = best.drop_duplicates(LINE, keep="last")
    best["usable"] = best["growth_worst"] <= np.maximum(TOLERABLE, 2 * best["floor"])
    shown = [*LINE, "refinement", "growth_worst", "yardstick", "floor", "usable"]
    return frame[LINE].drop_duplicates().merge(best[shown], on=LINE)


def judged(result: StudyResult) -> pd.DataFrame:
    """Worst error over all problems of every rule but the references, at degree 2."""
    frame = uses(result)
    frame = frame[(frame["degree"] == 2) & ~frame["rule"].isin(YARDSTICKS)]
    frame = frame.assign(lost=frame["growth_worst"].isna())
    cells = frame.groupby(["backend", "rule", "p"], sort=False).agg(
        usable=("usable", "all"),
        lost=("lost", "any"),
        growth_worst=("growth_worst", "max"),
        floor=("floor", "max"),
    )
    return cells.reset_index()


def matrix(result: StudyResult) -> pd.DataFrame:
    """Whether each rule is usable at each p, with its worst error; and that of references."""
    cells = judged(result)
    floors = cells.groupby(["backend", "p"], sort=False)["floor"].max().reset_index()
    floors = floors.assign(rule="yardstick", text=floors["floor"].map(shown(2)))
    cells["text"] = [
        f"{'✓' if row['usable'] else '✗'} "
        f"{'modes lost' if row['lost'] else number(row['growth_worst'], 2)}"
        for row in cells.to_dict("records")
    ]
    both = pd.concat([cells, floors])
    across = wide(both.sort_values("p", kind="stable"), ["backend", "rule"], "p", "text")
    return both[["backend", "rule"]].drop_duplicates().merge(across)


def in_short(result: StudyResult) -> str:
    """Name the contact rules that are usable at every stiffness."""
    every = judged(result).groupby(["backend", "rule"], sort=False)["usable"].all()
    rules = [f"{rule} ({backend_name(backend)})" for backend, rule in every[every].index]
    return f"Usable in every problem at every p tried: {'; '.join(rules) or 'none'}."


def lost(result: StudyResult) -> pd.DataFrame:
    """Runs with missing or spurious modes in the band."""
    found = result.frame().query("missing > 0 or spurious > 0")
    return found[[*LINE, "refinement", "modes", "missing", "spurious"]]


_TWO = shown(2)
COLUMNS = {
    "p": Column("p", show=shown(3)),
    "lambda_worst": Column("worst error of lambda", show=_TWO),
    "growth_worst": Column("worst error of growth", show=_TWO),
    "floor": Column("error of the reference rule", show=_TWO),
}
SECTIONS = [
    Section(
        "Where each formulation may be used",
        "A number is the worst error of the growth rate over all problems, relative to the largest "
        "growth rate in the band, on bodies of degree 2 and the finest mesh on which the reference "
        "rule was run too (mortar; segments where mortar failed). Meshes too coarse for the "
        f"reference are left out. ✓: at most {TOLERABLE:g}, or twice the error of the reference, "
        "in every problem. The error of the reference is due to the bodies' meshes. p is in units "
        "of each problem.",
        in_short,
        [
            Table("matrix", "Formulations by p.", matrix, COLUMNS, printed=True),
            Table("uses", "Every rule and its reference.", uses, COLUMNS, shown=False),
        ],
        of="runs",
    ),
    Section(
        "Error against cost",
        "Run time is processor time on one thread, median of the runs, from geometry to "
        "eigenpairs, without the first run of each problem and method in a process. Peak memory "
        "is the increase over the memory before the run. Errors of lambda are relative to "
        "abs(lambda), the worst over all modes of the band.",
        plots=[
            Plot(
                f"{part}_{x}",
                caption,
                partial(_drawn, which),
                x,
                "lambda_worst",
                series,
                ("problem",),
                "xy",
                COLUMNS,
            )
            for part, which, caption, series in (
                ("degrees", "rule == 'mortar'", "Every degree, mortar.", ("degree", "backend")),
                ("rules", "degree == 2", "Degree 2, every contact rule.", ("rule", "backend")),
            )
            for x in ("seconds", "dofs")
        ],
        tables=[Table("runs", "Every run.", "runs", COLUMNS, shown=False)],
        of="runs",
    ),
    Section(
        "Omissions",
        tables=[
            Table("omissions", "Meshes that failed, which end a line.", "omissions", COLUMNS),
            Table(
                "incomplete",
                "Runs with missing modes in the band (no error is defined, they are not drawn), or "
                "with spurious modes.",
                lost,
                COLUMNS,
            ),
        ],
        of="runs",
    ),
]
STUDY = Study(
    name="accuracy",
    title="Error of flutter eigenvalues against run time",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    sections=SECTIONS,
    quick={
        "problems": ("blocks",),
        "stiffnesses": (1.0,),
        "most_dofs_2d": 2_000,
        "levels": 1,
        "repeats": 1,
    },
    process=Process("comparisons.accuracy.study:STUDY", 500.0),
    shipped=Path(__file__).parent / "results",
)
