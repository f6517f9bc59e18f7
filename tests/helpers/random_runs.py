"""Random scenes and matrices run and judged by dense eigenvalues."""

import traceback
from dataclasses import dataclass, field

import numpy as np
from dense_reference import UnsureError, dense_eigenvalues, dense_quadratic
from judge import Fault, judge, judge_quadratic
from random_graded import random_graded, random_graded_damped
from random_matrices import random_pencil
from random_quadratic import random_low_rank, random_quadratic
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


def matrix_outcome(seed):
    """A random pencil."""
    return _outcome(
        f"matrices {seed}", lambda: (solve_modes(*random_pencil(seed)), None), _by_dense
    )


def quadratic_outcome(seed, problem_of=random_quadratic):
    """A random damped pencil."""
    problem = problem_of(seed)
    end = 2 * np.pi * problem.max_frequency
    truth = dense_quadratic(problem.mass, problem.whole_damping, problem.stiffness, end)

    def run():
        pencil, low = problem.pencil(), problem.min_growth
        return solve_modes(pencil, problem.max_frequency, min_growth=low), None

    return _outcome(f"damped {seed}", run, lambda modes, _: judge_quadratic(modes, *truth))


def low_rank_outcome(seed):
    """A random pencil with damping of low rank."""
    return quadratic_outcome(seed, random_low_rank)


def graded_outcome(seed):
    """A random graded pencil, judged by the one that was graded."""
    problem = random_graded(seed)
    return _outcome(
        f"graded {seed}: {problem.name}",
        lambda: (solve_modes(problem.pencil(), problem.max_frequency), None),
        lambda modes, threshold: judge(modes, problem.dense(), threshold),
    )


def graded_damped_outcome(seed):
    """The same with damping or rotation."""
    problem = random_graded_damped(seed)
    return _outcome(
        f"graded {seed}: {problem.name}",
        lambda: (solve_modes(problem.pencil(), problem.max_frequency), None),
        lambda modes, _: judge_quadratic(modes, *problem.dense_quadratic()),
    )


def judged(seeds, outcome_of):
    """Outcomes of seeds; faults in any of them, reported together, are a failure."""
    outcomes = [outcome_of(seed) for seed in seeds]
    wrong = [(each.name, fault) for each in outcomes for fault in each.faults[:1]]
    assert not wrong, "\n".join(f"{name}: {fault.kind}, {fault.text}" for name, fault in wrong)
    return outcomes
