"""Errors of lambda against run time, and growth in problems that cannot flutter."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from math import tau
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.eigen.matching import assign
from cea.errors import ConvergenceError, InputError
from comparisons.accuracy.cases import methods, refinements, scene_of
from comparisons.accuracy.problems import PROBLEMS, exact
from comparisons.study.matching import match_spectrum
from comparisons.study.measure import measured
from comparisons.study.study import Case, Session
from exact_cea.reference import exact_eigenvalues
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


_MIRRORED = {
    "bodies.lower.geometry": {"shape": "rectangle", "size": [2, 0.5], "origin": [0, -0.5]},
    "bodies.lower.material": {"E": 0.1, "nu": 0.25, "rho": 0.35},
}
_ALIKE = {"upper": (4, 1), "lower": (4, 1)}
NO_FLUTTER = {
    "layers that mirror each other": replace(PROBLEMS["blocks"], bodies=_ALIKE, mu=0.9),
    "drum, m = 0": replace(PROBLEMS["drum"], mu=0.9),
}
"""Problems that cannot flutter: growth there is an error of the contact rule.

In layers that mirror each other even modes load the contact and odd modes slide, and friction
couples them in one direction only. On axisymmetric modes of the drum friction does no work.
"""
_SAME_MODE = 0.05  # largest relative distance of a mode from its exact eigenvalue
_REFINEMENT = 3  # refinement of the meshes of these problems


def no_flutter_cases() -> Iterator[Case]:
    """Every problem that cannot flutter, with every contact rule on elements of degree 2."""
    for name in NO_FLUTTER:
        for method in methods():
            if method["degree"] == 2:
                yield {"problem": name, "p": 1.0, **method}


def evaluate_no_flutter(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Return the largest growth over abs(lambda) and its error; count modes above their error."""
    problem = NO_FLUTTER[case["problem"]]
    mirrored = problem.name == "blocks"
    result = run_modes(scene_of(problem, case, _REFINEMENT, _MIRRORED if mirrored else None))
    modes = result.modes
    chosen: Any = slice(None)
    if not mirrored:  # those next to exact eigenvalues of m = 0
        top = tau * result.analysis.max_frequency
        known = {"p": case["p"] * problem.unit, "mu": problem.mu}
        axisymmetric = exact_eigenvalues("drum", m=0, max_frequency=top, **known)
        distance = np.abs(modes.eigenvalues[:, None] - axisymmetric) / np.abs(axisymmetric)
        chosen = assign(distance, _SAME_MODE)[0]
    size = np.abs(modes.eigenvalues[chosen])
    rates, explained = np.abs(modes.growth_rates[chosen]), modes.growth_uncertainties[chosen]
    worst = int(np.argmax(rates / size))
    row = {
        "modes": len(size),
        "growth": float(rates[worst] / size[worst]),
        "explained": float(explained[worst] / size[worst]),
        "unexplained": int(np.sum(rates > explained)),
    }
    return {"no_flutter": [row]}
