"""Random scenes and pencils run and judged by dense eigenvalues.

None is missing where that was claimed, none made up or misjudged. Eigenvalues closer to each other
than their errors are one group, and groups are compared by their numbers: members of a multiple or
nearly defective eigenvalue have no names.
"""

import traceback
from dataclasses import dataclass, field

import numpy as np
from dense_reference import UnsureError, dense_eigenvalues, lambda_error, lambda_of
from random_scenes import random_scene
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

import cea.petsc  # noqa: F401  (ahead of all that needs PETSc)
from cea.eigen.driver import solve_modes
from cea.eigen.pencil import release
from cea.errors import ConvergenceError, InputError
from scenes import run_modes
from scenes.spec.problems import SceneError

_SAFETY = 10.0
"""Factor on errors, which are estimates of first order."""


def judge(modes, dense, threshold=None):
    """Faults of modes of an undamped pencil, given all eigenvalues kappa there are.

    Modes are unstable above a threshold of growth (1/s), by default relative to lambda.
    """
    window, found = modes.window, modes.eigenvalues
    top, own = 2 * np.pi * window.max_frequency, _SAFETY * modes.growth_uncertainties
    error = _SAFETY * dense.error
    z = np.append(-(found**2), dense.kappa)
    reach = np.append(2 * np.abs(found) * own + own**2, error)
    reach = reach + 1e-8 * np.maximum(np.abs(z), 1e-3 * top**2)
    margin = lambda_error(dense.kappa, error)
    truth = _Truth(lambda_of(dense.kappa), margin, -np.inf, threshold)
    if dense.symmetric:  # kappa are real: what rounding makes of zero is no growth
        truth.grows &= dense.kappa.real < -error
        truth.may_grow = truth.grows
    calls = np.array(modes.verdicts(threshold), dtype=object)
    verdict = modes.verdict(threshold)
    return _faults(window, verdict, calls, truth, _groups(z, reach, len(found)))


def judge_quadratic(modes, values, errors):
    """Faults of modes of a damped pencil, given all eigenvalues lambda there are."""
    window, found = modes.window, modes.eigenvalues
    top, twins = 2 * np.pi * window.max_frequency, found.imag > 0
    own, calls = modes.growth_uncertainties, np.array(modes.verdicts(), dtype=object)
    z = np.concatenate([found, found[twins].conj(), values])
    reach = _SAFETY * np.concatenate([own, own[twins], errors])
    reach = reach + 1e-9 * np.maximum(np.abs(z), 1e-2 * top)
    calls = np.append(calls, calls[twins])
    truth = _Truth(values, _SAFETY * errors, window.min_growth, None)
    return _faults(window, modes.verdict(), calls, truth, _groups(z, reach, len(calls)))


class _Truth:
    """Eigenvalues lambda, their margins, and which grow faster than a threshold."""

    def __init__(self, values, margin, min_growth, threshold):
        self.values, self.margin, self.min_growth = values, margin, min_growth
        limit = 1e-4 * np.abs(values) if threshold is None else threshold
        self.grows, self.may_grow = values.real > limit + margin, values.real > limit - margin


def _groups(z, reach, n):
    """Numbers of found values, the first n, and of dense ones within each other's errors."""
    near = np.abs(z[:, None] - z) <= reach[:, None] + reach
    count, label = connected_components(csr_array(near), directed=False)
    order = np.argsort(label, kind="stable")
    for members in np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1]):
        yield members[members < n], members[members >= n] - n


def _faults(window, verdict, calls, truth, groups):
    values, margin = truth.values, truth.margin
    top, frequency, growth = 2 * np.pi * window.max_frequency, np.abs(values.imag), values.real
    surely = (frequency < top - margin) & (growth > truth.min_growth + margin)
    surely &= np.abs(growth) < window.max_growth - margin
    if window.odd:  # it says itself that one of those without frequency is missing
        surely &= frequency > margin
    possibly = (frequency < top + margin) & (growth > truth.min_growth - margin)
    faults = []
    for ours, theirs in groups:
        place = f"{values[theirs][0]:.8g}" if len(theirs) else "a place where there is none"
        called = calls[ours]
        count = int(surely[theirs].sum())
        if len(ours) < count:
            faults.append(f"missing: {count} at {place}, {len(ours)} found")
        count = int(possibly[theirs].sum())
        if (called != "undecided").sum() > count:
            faults.append(f"spurious: {count} at {place}, {len(ours)} found")
        if len(theirs) and (called == "stable").sum() > (~truth.grows & possibly)[theirs].sum():
            faults.append(f"wrong-verdict: {place} is called stable and grows")
        if len(theirs) and (called == "unstable").sum() > truth.may_grow[theirs].sum():
            faults.append(f"wrong-verdict: {place} is called unstable and does not grow")
    if verdict == "stable" and (truth.grows & (frequency < top - margin)).any():
        faults.append("wrong-verdict: the window is called stable and a mode grows")
    if verdict == "unstable" and not (truth.may_grow & (frequency < top + margin)).any():
        faults.append("wrong-verdict: the window is called unstable and nothing grows")
    return faults


@dataclass
class Outcome:
    """What came of one seed: faults, why it was refused or could not be judged, what was found."""

    name: str
    faults: list[str] = field(default_factory=list)
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
        found.faults = [f"crash: {traceback.format_exc()}"]
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
    return outcome_of_scene(f"scene {seed}", random_scene(seed))


def outcome_of_scene(name, scene):
    """Any small scene without damping."""

    def run():
        result = run_modes(scene)
        return result.modes, result.analysis.growth_threshold

    return _outcome(name, run, _by_dense)


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
    assert not wrong, "\n".join(f"{name}: {fault}" for name, fault in wrong)
    return outcomes
