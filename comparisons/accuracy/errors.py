"""Errors of lambda against run time: a line of a plot, from the coarsest mesh to the finest."""

from functools import cache
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.eigen.matching import match_spectrum
from cea.errors import ConvergenceError, InputError
from comparisons.accuracy.cases import Method, method_of, refinements, scene_of
from comparisons.accuracy.exact_lists import exact
from comparisons.accuracy.problems import PROBLEMS
from comparisons.study.measure import measured
from comparisons.study.session import Session
from comparisons.study.study import Case
from scenes import run_modes

REACH = 0.25
"""Relative distance at which a computed eigenvalue no longer stands for an exact one."""
SECONDS = 100.0
"""Most that the runs of one mesh may be expected to take."""
_DIGITS = 4
"""Significant digits of run times, memory and errors."""


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Rows of a line, and what was left out of it with the reason."""
    runs, omissions = list[dict[str, Any]](), list[dict[str, Any]]()
    for refinement in refinements(case, session.options):
        reason = _reason_to_stop(case, refinement, runs, session.options.repeats)
        if not reason:
            try:
                runs.append(measure(case, refinement, session.options.repeats))
                continue
            except (ConvergenceError, InputError) as failure:
                reason = str(failure)
        omissions.append({"refinement": refinement, "reason": reason})
        break  # finer meshes would fail or take longer still
    return {"runs": runs, "omissions": omissions}


def _reason_to_stop(case: Case, refinement: int, runs: list[dict[str, Any]], repeats: int) -> str:
    """Why a mesh is not run: its time grows at least like its elements; "" where it is run."""
    if not runs:
        return ""
    more = (refinement / runs[-1]["refinement"]) ** PROBLEMS[case["problem"]].dim
    expected = repeats * runs[-1]["seconds"] * more
    return f"more than {SECONDS:g} s expected for its runs" if expected > SECONDS else ""


def measure(case: Case, refinement: int, repeats: int) -> dict[str, Any]:
    """Seconds of processor time (medians), peak memory (MB) and errors of one mesh of a line."""
    problem, method = PROBLEMS[case["problem"]], method_of(case)
    _warm_up(case["problem"], method)
    scene, taken, memory = scene_of(problem, method, refinement, case["p"]), [], []
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
def _warm_up(problem: str, method: Method) -> None:
    """Run the coarsest mesh once in a process: it loads or compiles forms and fills caches."""
    run_modes(scene_of(PROBLEMS[problem], method, 1, 1.0))


def errors(computed: Complexes, exact: Complexes, band: tuple[float, float]) -> dict[str, Any]:
    """Errors over the exact eigenvalues of a band, None where modes are missing, and counts."""
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
