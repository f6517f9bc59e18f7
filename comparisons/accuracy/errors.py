"""Errors of lambda against run time."""

from functools import cache
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.errors import ConvergenceError, InputError
from comparisons.accuracy.cases import refinements, scene_of
from comparisons.accuracy.problems import PROBLEMS, exact
from comparisons.study.matching import match_spectrum
from comparisons.study.measure import measured
from comparisons.study.study import Case, Session
from scenes import run_modes

REACH = 0.25  # largest relative distance of a computed eigenvalue from the exact one it matches
_DIGITS = 4  # significant digits stored of run times, memory and errors


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Return the runs of a line, which ends at the first failure, and the reason for it."""
    runs, omissions = list[dict[str, Any]](), list[dict[str, Any]]()
    for refinement in refinements(case, session.options):
        try:
            runs.append(measure(case, refinement, session.options.repeats))
        except (ConvergenceError, InputError) as failure:
            omissions.append({"refinement": refinement, "reason": str(failure)})
            break
    return {"runs": runs, "omissions": omissions}


def measure(case: Case, refinement: int, repeats: int) -> dict[str, Any]:
    """Return processor time (s, medians), peak memory (MB) and errors of one mesh."""
    problem, taken, memory = PROBLEMS[case["problem"]], [], []
    _warm_up(case["problem"], case["backend"], case["degree"], case["rule"])
    scene = scene_of(problem, case, refinement)
    for _ in range(repeats):
        with measured() as cost:
            result = run_modes(scene)
        taken.append(result.timer.processor_seconds)
        memory.append(cost.memory)
    row: dict[str, Any] = {
        "dofs": result.system.size,
        "points": len(next(iter(result.interfaces.values())).points),
        "seconds": float(np.median([sum(stages.values()) for stages in taken])),
        **{stage: float(np.median([each[stage] for each in taken])) for stage in taken[0]},
        "memory": memory[0],
    }
    row |= errors(result.eigenvalues, exact(case["problem"], case["p"]), problem.band)
    return {"refinement": refinement} | {
        name: float(f"{v:.{_DIGITS}g}") if isinstance(v, float) else v for name, v in row.items()
    }


@cache
def _warm_up(problem: str, backend: str, degree: int, rule: str) -> None:
    """Run the coarsest mesh once in a process, which compiles forms and fills caches."""
    case = {"p": 1.0, "backend": backend, "degree": degree, "rule": rule}
    run_modes(scene_of(PROBLEMS[problem], case, 1))


def errors(computed: Complexes, exact: Complexes, band: tuple[float, float]) -> dict[str, Any]:
    """Return errors over the exact eigenvalues of a band (None if any is missing), and counts."""
    match = match_spectrum(computed, exact, band, reach=REACH)
    found: dict[str, Any] = {"modes": len(match.exact)}
    for name, error in (
        ("lambda", match.errors),
        ("frequency", match.frequency_errors),
        ("growth", match.growth_errors),
    ):
        values = {"worst": error.max(initial=0.0), "median": np.median(error) if len(error) else 0}
        for which, value in values.items():
            found[f"{name}_{which}"] = float(value) if np.isfinite(value) else None
    return found | {"missing": len(match.missing), "spurious": len(match.spurious)}
