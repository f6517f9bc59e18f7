"""Random scenes and pencils run and judged by dense eigenvalues."""

import traceback
from dataclasses import dataclass, field

import numpy as np
from dense_reference import UnsureError, dense_eigenvalues
from judge import Fault, judge, judge_quadratic
from random_scenes import random_scene

import cea.petsc  # noqa: F401  (ahead of all that needs PETSc)
from cea.eigen.driver import solve_modes
from cea.eigen.pencil import release
from cea.errors import ConvergenceError, InputError
from scenes import run_modes
from scenes.spec.problems import SceneError


@dataclass
class Outcome:
    """What came of one seed: faults, why it was refused or could not be judged, what was found."""

    name: str
    faults: list[Fault] = field(default_factory=list)
    refused: str | None = None
    unsure: str | None = None
    verdict: str | None = None
    modes: int = 0
    undecided: int = 0
    complete: bool = True


def _outcome(name, run, faults_of):
    """Modes of a run, with their threshold, judged."""
    found = Outcome(name)
    try:
        modes, threshold = run()
    except (InputError, SceneError, ConvergenceError) as error:
        found.refused = f"{type(error).__name__}: {error}"
    except Exception:
        found.faults = [Fault("crash", traceback.format_exc())]
    else:
        found.verdict, found.modes = modes.verdict(threshold), len(modes)
        found.undecided = modes.verdicts(threshold).count("undecided")
        found.complete = modes.window.complete
        try:
            found.faults = faults_of(modes, threshold)
        except UnsureError as error:
            found.unsure = str(error)
    return found


def _by_dense(modes, threshold):
    matrices = modes.pencil.at(modes.values)
    try:
        top = 2 * np.pi * modes.window.max_frequency
        return judge(modes, dense_eigenvalues(matrices, top**2), threshold)
    finally:
        release(matrices)


def scene_outcome(seed):
    """A random scene."""

    def run():
        result = run_modes(random_scene(seed))
        return result.modes, result.analysis.growth_threshold

    return _outcome(f"scene {seed}", run, _by_dense)


def pencil_outcome(problem):
    """A random pencil; graded ones are judged by the one that was graded."""

    def run():
        top, low = problem.max_frequency, problem.min_growth
        return solve_modes(problem.pencil(), top, min_growth=low), None

    def faults_of(modes, threshold):
        if modes.pencil.damped:
            return judge_quadratic(modes, *problem.dense())
        return (
            judge(modes, problem.dense(), threshold)
            if problem.scales
            else _by_dense(modes, threshold)
        )

    return _outcome(problem.name, run, faults_of)


def judged(seeds, outcome_of):
    """Outcomes of seeds; faults in any of them, reported together, are a failure."""
    outcomes = [outcome_of(seed) for seed in seeds]
    wrong = [(each.name, fault) for each in outcomes for fault in each.faults[:1]]
    assert not wrong, "\n".join(f"{name}: {fault.kind}, {fault.text}" for name, fault in wrong)
    return outcomes
