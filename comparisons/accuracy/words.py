"""What a study found, in sentences made of its data."""

from collections.abc import Iterator
from itertools import groupby
from typing import Any

from comparisons.accuracy.analysis import TOLERABLE, Use, method_of, pareto, seconds_of, uses
from comparisons.accuracy.study import RULES, Method
from comparisons.kit.numbers import counted, listed, number, shown

Data = dict[str, Any]

_JUDGED = (
    "node",
    "node_tributary",
    "greville",
    "greville_area",
    "botella",
    "botella_area",
    "grid",
    "gpts",
    "gpts_lumped",
    "full_pass",
)


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
    """The Pareto front of a problem, a sentence for each stiffness."""
    sentences = []
    for p in data["inputs"]["study"]["stiffnesses"]:
        runs = [r for r in data["runs"] if (r["problem"], r["stiffness"]) == (problem, p)]
        best = pareto(runs)
        if best:
            steps = "; ".join(
                f"{method_of(run).label} reaches {number(run['lambda']['worst'], 2)} in "
                f"{number(seconds_of(run), 2)} s ({counted(run['dofs'], 'dof')})"
                for run in best
            )
            sentences.append(f"p = {p:g}, {len(best)} of {len(runs)} runs: {steps}.")
    return sentences


def where_each_may_be_used(data: Data) -> list[str]:
    """For each contact rule at degree 2, its error of growth at every stiffness, and a verdict."""
    found = [use for use in uses(data["runs"]) if use.method.degree == 2]
    return [
        sentence
        for rule in _JUDGED
        for backend in RULES[rule].backends
        for sentence in _verdict(
            [use for use in found if (use.method.rule, use.method.backend) == (rule, backend)]
        )
    ]


def in_short(data: Data) -> str:
    """Contact rules by the stiffnesses at which they may be used, in a paragraph."""
    found = [use for use in uses(data["runs"]) if use.method.degree == 2]
    tried = sorted({use.stiffness for use in found})
    by_range: dict[tuple[float, ...], list[str]] = {}
    for rule in _JUDGED:
        for backend in RULES[rule].backends:
            own = [use for use in found if (use.method.rule, use.method.backend) == (rule, backend)]
            if own:
                usable = tuple(p for p in tried if _usable_at(own, p))
                by_range.setdefault(usable, []).append(own[0].method.label)
    ordered = sorted(by_range.items(), key=lambda item: -len(item[0]))
    return " ".join(f"Usable {_where(usable, tried)}: {'; '.join(r)}." for usable, r in ordered)


def _usable_at(found: list[Use], p: float) -> bool:
    at = [use for use in found if use.stiffness == p]
    return bool(at) and all(use.usable for use in at)


def _where(usable: tuple[float, ...], tried: list[float]) -> str:
    if len(usable) == len(tried):
        return "at every p tried"
    return f"at p = {listed(f'{p:g}' for p in usable)}" if usable else "at no p tried"


def _verdict(found: list[Use]) -> Iterator[str]:
    if not found:
        return
    by_stiffness = [
        (p, list(group))
        for p, group in groupby(sorted(found, key=lambda u: u.stiffness), lambda u: u.stiffness)
    ]
    parts = "; ".join(f"p = {p:g}: {_range(group)}" for p, group in by_stiffness)
    usable = [f"{p:g}" for p, group in by_stiffness if all(use.usable for use in group)]
    verdict = f"usable at p = {listed(usable)}" if usable else "not usable at any p tried"
    problems = listed(dict.fromkeys(use.problem for use in found))
    yield f"**{found[0].method.label}** ({problems}): {verdict}. {parts}."


def _range(group: list[Use]) -> str:
    """Growth errors over the problems, beside those of the yardsticks."""
    errors = [use.error for use in group if use.error is not None]
    floors = [use.floor for use in group]
    lost = counted(len(group) - len(errors), "problem") if len(errors) < len(group) else ""
    text = f"{_span(errors)} (yardstick {_span(floors)})"
    return f"{text}, modes lost in {lost}" if lost else text


def _span(values: list[float]) -> str:
    show = shown(2)
    if not values:
        return "none"
    low, high = show(min(values)), show(max(values))
    return low if low == high else f"{low} to {high}"


def verdict_rule() -> str:
    """What the verdicts mean."""
    return (
        "Worst error of the growth rate, relative to the largest growth rate of the listed modes, "
        "on bodies of degree 2 and the finest mesh that a yardstick was run on too (mortar; where "
        "that failed, segments, then GPTS); meshes too coarse for the yardstick are left out. "
        "Usable means: in every problem, at most "
        f"{TOLERABLE:g} or twice the error of the yardstick, which is that of the bodies' meshes."
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
