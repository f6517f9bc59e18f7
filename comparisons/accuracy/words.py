"""What a study found, in sentences made of its data."""

from itertools import groupby
from typing import Any

from comparisons.accuracy.analysis import (
    TOLERABLE,
    Run,
    grouped_omissions,
    incomplete,
    method_of,
    pareto,
    seconds_of,
)
from comparisons.accuracy.matrix import cells
from comparisons.accuracy.study import Method
from comparisons.kit.numbers import counted, listed, number

Data = dict[str, Any]


def how_measured(data: Data) -> str:
    """What was timed and what was not."""
    study = data["inputs"]["study"]
    return (
        f"Run time is the median of {study['repeats']} runs, each from geometry to eigenpairs "
        "(meshing, search, assembly, factorisation, Krylov, post-processing), on one thread "
        "(OMP_NUM_THREADS=1) in a process of its own. It is processor time: on an idle machine "
        "that is the time by the clock, and other work does not lengthen it. The first "
        "run of each problem, discretisation and contact rule in a process, on the coarsest "
        "mesh, warms it up and is not timed: imports, compiled forms and caches are charged to "
        "nobody. Peak memory is that of the first timed run above what the process held before. "
        f"The study took {number(data['seconds'] / 60, 3)} minutes with one-minute load "
        f"{number(data['machine']['load'], 2)} at its end on {data['machine']['cpus']} processors. "
        "lambda is the eigenvalue, its errors relative to "
        "abs(lambda) over all listed modes of the band; frequency is the error of Im lambda "
        "relative to abs(lambda), growth that of Re lambda relative to the largest growth rate of "
        "the listed modes. p counts in units of each problem."
    )


def front(data: Data, problem: str) -> list[str]:
    """The ends of the Pareto front of a problem, a sentence for each stiffness."""
    sentences = []
    for p in data["inputs"]["study"]["stiffnesses"]:
        runs = [r for r in data["runs"] if (r["problem"], r["stiffness"]) == (problem, p)]
        best = pareto(runs)
        if best:
            fair = next((run for run in best if run["lambda"]["worst"] <= TOLERABLE), None)
            told = [f"most accurate is {_reached(best[-1])}"]
            if fair is not None and fair is not best[-1]:
                told.insert(0, f"fastest within {TOLERABLE:g} is {_reached(fair)}")
            sentences.append(f"p = {p:g}, {len(runs)} runs: {'; '.join(told)}.")
    return sentences


def _reached(run: Run) -> str:
    return (
        f"{method_of(run).label} with {number(run['lambda']['worst'], 2)} in "
        f"{number(seconds_of(run), 2)} s ({counted(run['dofs'], 'dof')})"
    )


def in_short(data: Data) -> str:
    """Contact rules by the stiffnesses at which they may be used, in a paragraph."""
    by_range: dict[tuple[float, ...], list[str]] = {}
    tried: list[float] = []
    for row in cells(data):
        tried = [cell.stiffness for cell in row]
        usable = tuple(cell.stiffness for cell in row if cell.usable)
        by_range.setdefault(usable, []).append(row[0].method.label)
    ordered = sorted(by_range.items(), key=lambda item: -len(item[0]))
    return " ".join(f"Usable {_where(usable, tried)}: {'; '.join(r)}." for usable, r in ordered)


def _where(usable: tuple[float, ...], tried: list[float]) -> str:
    if len(usable) == len(tried):
        return "at every p tried"
    return f"at p = {listed(f'{p:g}' for p in usable)}" if usable else "at no p tried"


def reasons(data: Data) -> list[str]:
    """Why cases gave no numbers, a sentence for each reason."""
    by_reason: dict[str, dict[str, int]] = {}
    for (problem, reason), cases in grouped_omissions(data["omissions"]).items():
        by_reason.setdefault(reason, {})[problem] = len(cases)
    return [
        f"{counted(sum(counts.values()), 'case')} ({listed(counts)}): {reason}."
        for reason, counts in by_reason.items()
    ]


def lost(data: Data) -> str:
    """How many runs missed modes, or found some that are none."""
    runs = incomplete(data["runs"])
    return (
        f"{counted(len(runs), 'run')} of {number(len(data['runs']))} missed listed modes, or found "
        "modes in the band that stand for none; they have no error and are not drawn."
    )


def verdict_rule() -> str:
    """What the verdicts mean."""
    return (
        "A number is the worst error of the growth rate over all problems, relative to the largest "
        "growth rate of the listed modes, on bodies of degree 2 and the finest mesh that a "
        "yardstick was run on too (mortar; where that failed, segments, then GPTS); meshes too "
        "coarse for the yardstick are left out. ✓ is usable, ✗ is not; usable means: in every "
        f"problem, at most {TOLERABLE:g} or twice the error of the yardstick, which is that of the "
        "bodies' meshes."
    )


def finest(data: Data) -> list[str]:
    """For each problem and method on its finest meshes, the error that none exceeds."""
    runs = sorted(data.get("finest", []), key=_finest_key)
    return [_digits(*key, list(group)) for key, group in groupby(runs, _finest_key)]


def _finest_key(run: Data) -> tuple[str, str]:
    return run["problem"], Method(run["backend"], run["degree"], run["formulation"]).label


def _digits(problem: str, method: str, runs: list[Data]) -> str:
    p = listed(dict.fromkeys(f"{run['p']:g}" for run in runs))
    compared = counted(sum(run["compared"] for run in runs), "eigenvalue")
    text = f"**{problem}, {method}** (p = {p}): {compared}"
    errors = [run["worst"] for run in runs if run["worst"] is not None]
    if len(errors) < len(runs):
        return f"{text}, some not found in {counted(len(runs) - len(errors), 'run')}."
    met = all(run["worst"] <= run["bound"] for run in runs)
    bound = number(runs[0]["bound"], 1)
    verdict = f"within the {bound} asked for" if met else f"not within the {bound} asked for"
    return f"{text}, worst error {number(max(errors), 2)}, {verdict}."


def without_flutter(data: Data) -> list[str]:
    """What grew in problems that cannot flutter."""
    runs = data.get("no_flutter", [])
    grown = [run for run in runs if run["unexplained"]]
    problems = listed(dict.fromkeys(run["problem"] for run in runs))
    sentences = [
        f"In {len(runs) - len(grown)} of {counted(len(runs), 'run')} ({problems}; every contact "
        "rule at degree 2, both backends) no mode grows by more than its residual times its "
        "condition number explains."
    ]
    return sentences + [
        f"Exception: {method_of(run).label} ({run['problem']}) lets "
        f"{counted(run['unexplained'], 'mode')} of {run['modes']} grow or decay, by up to "
        f"{number(run['growth'], 2)} of abs(lambda)."
        for run in grown
    ]
