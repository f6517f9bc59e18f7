"""Random scenes and matrices run and judged by dense eigenvalues.

``python tests/helpers/random_runs.py 0 1000`` runs the scenes of these seeds, with ``matrices``
behind it the matrices, with ``quadratic`` the damped and rotating ones, with ``low-rank`` those
with modal damping, with ``graded`` and ``graded-damped`` those whose rows and columns are scaled
far apart, judged by what they were before. It prints what is wrong, seed by seed, and how many
results were refused or left open, and why.
"""

import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from dense_reference import UnsureError, dense_eigenvalues
from judge import Fault, Found, found_by, judge, left_out
from quadratic_judge import dense_quadratic, judge_quadratic
from random_graded import random_graded, random_graded_damped
from random_matrices import random_pencil
from random_quadratic import random_low_rank, random_quadratic
from random_scenes import random_scene

import cea.petsc  # noqa: F401  (ahead of all that needs PETSc)
from cea.eigen.driver import solve_modes
from cea.eigen.modes import Modes
from cea.eigen.pencil import release
from cea.errors import ConvergenceError, InputError
from scenes import run_modes
from scenes.spec.problems import SceneError


@dataclass
class Outcome:
    """What came of one scene.

    Parameters
    ----------
    seed, name
        The scene.
    faults
        What is wrong.
    refused
        Why it was refused; None where it was not.
    verdict
        Verdict on the window.
    modes, undecided
        Modes found, and those among them that were left open.
    complete
        Whether it claims that every mode of the window was found.
    left_out
        Modes of the window, however fast they grow, that were neither found nor claimed.
    unsure
        Why the dense reference could not judge; None where it could.
    """

    seed: int
    name: str = ""
    faults: list[Fault] = field(default_factory=list)
    refused: str | None = None
    verdict: str | None = None
    modes: int = 0
    undecided: int = 0
    complete: bool = True
    left_out: int = 0
    unsure: str | None = None

    def __str__(self) -> str:
        lines = []
        for kind, number in Counter(fault.kind for fault in self.faults).items():
            first = next(fault.text for fault in self.faults if fault.kind == kind)
            lines.append(f"{self.name}: {number} {kind}, the first: {first}")
        return "\n".join(lines)


def scene_outcome(seed: int) -> Outcome:
    """Run a random scene and judge what it says."""

    def run(found: Outcome):
        scene = random_scene(seed)
        found.name = scene.name
        result = run_modes(scene)
        return result.modes, result.analysis.growth_threshold

    return _outcome(seed, run)


def matrix_outcome(seed: int) -> Outcome:
    """Solve a random pencil and judge what it says."""

    def run(found: Outcome):
        pencil, end = random_pencil(seed)
        found.name = f"random matrices {seed}"
        return solve_modes(pencil, end), None

    return _outcome(seed, run)


def quadratic_outcome(seed: int, problem_of: Callable = random_quadratic) -> Outcome:
    """Solve a random damped pencil and judge what it says."""
    problem = problem_of(seed)

    def run(found: Outcome):
        found.name = f"random damped matrices {seed}"
        modes = solve_modes(problem.pencil(), problem.max_frequency, min_growth=problem.min_growth)
        return modes, None

    def judged(found: Outcome, modes: Modes, _: float | None):
        found.verdict, found.modes = modes.verdict(), len(modes)
        found.undecided = modes.verdicts().count("undecided")
        found.complete = modes.window.complete
        values, errors = dense_quadratic(
            problem.mass,
            problem.whole_damping,
            problem.stiffness,
            2 * np.pi * problem.max_frequency,
        )
        found.faults = judge_quadratic(modes, values, errors)

    return _outcome(seed, run, judged)


def low_rank_outcome(seed: int) -> Outcome:
    """Solve a random pencil with damping of low rank and judge what it says."""
    return quadratic_outcome(seed, random_low_rank)


def graded_outcome(seed: int) -> Outcome:
    """Solve a random graded pencil and judge what it says by the one that was graded."""
    problem = random_graded(seed)

    def run(found: Outcome):
        found.name = f"random graded matrices {seed}: {problem.name}"
        return solve_modes(problem.pencil(), problem.max_frequency), None

    def judged(found: Outcome, modes: Modes, threshold: float | None):
        said = _told(found, modes, threshold)
        found.faults = judge(said, problem.dense(), threshold)

    return _outcome(seed, run, judged)


def graded_damped_outcome(seed: int) -> Outcome:
    """Solve a random graded pencil with damping or rotation, and judge it likewise."""
    problem = random_graded_damped(seed)

    def run(found: Outcome):
        found.name = f"random graded matrices {seed}: {problem.name}"
        return solve_modes(problem.pencil(), problem.max_frequency), None

    def judged(found: Outcome, modes: Modes, threshold: float | None):
        _told(found, modes, threshold)
        found.faults = judge_quadratic(modes, *problem.dense_quadratic())

    return _outcome(seed, run, judged)


def _outcome(seed: int, run: Callable, judged: Callable | None = None) -> Outcome:
    found = Outcome(seed)
    try:
        modes, threshold = run(found)
    except (InputError, SceneError, ConvergenceError) as error:
        found.refused = f"{type(error).__name__}: {error}"
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        text = f"{type(error).__name__} in {place.name}: {' '.join(str(error).split())[:300]}"
        found.faults = [Fault("crash", text)]
    else:
        (judged or _judge)(found, modes, threshold)
    return found


def _told(found: Outcome, modes: Modes, threshold: float | None) -> Found:
    """What modes say of themselves, told of their run."""
    said = found_by(modes, threshold)
    found.verdict, found.modes = said.verdict, len(said.kappa)
    found.undecided = int((said.verdicts == "undecided").sum())
    found.complete = said.complete
    return said


def _judge(found: Outcome, modes: Modes, threshold: float | None) -> None:
    said = _told(found, modes, threshold)
    matrices = modes.pencil.at(modes.values)
    try:
        dense = dense_eigenvalues(matrices, said.top**2)
        found.faults = judge(said, dense, threshold)
        found.left_out = left_out(said, dense)
    except UnsureError as error:
        found.unsure = str(error)
    release(matrices)


def statistics(outcomes: Iterable[Outcome]) -> str:
    """How many there were, what is wrong with them, what was refused or left open."""
    every = list(outcomes)
    lines = [f"{len(every)} runs, {sum(o.modes for o in every)} modes"]
    kinds = Counter(kind for o in every for kind in {f.kind for f in o.faults})
    lines.append(f"faulty: {sum(bool(o.faults) for o in every)} {dict(kinds)}")
    lines.append(f"verdicts: {dict(Counter(o.verdict for o in every if o.verdict))}")
    lines.append(f"modes left open: {sum(o.undecided for o in every)}")
    open_ones = [o for o in every if o.verdict == "undecided"]
    for reason, told in (("not complete", False), ("modes left open", True)):
        seeds = [o.seed for o in open_ones if o.complete == told]
        lines.append(f"  undecided, {reason}: {len(seeds)}, seeds {seeds[:12]}")
    lines.append(f"windows that claim not to be complete: {sum(not o.complete for o in every)}")
    lines.append(f"with modes left out: {sum(bool(o.left_out) for o in every)}")
    refusals = Counter(_reason(o.refused) for o in every if o.refused)
    lines.append(f"refused: {sum(refusals.values())}")
    for reason, count in refusals.most_common():
        seeds = [o.seed for o in every if o.refused and _reason(o.refused) == reason]
        lines.append(f"  {count}: {reason}, seeds {seeds[:6]}")
    unsure = Counter(o.unsure for o in every if o.unsure)
    lines.append(f"reference unsure: {dict(unsure)}")
    return "\n".join(lines)


def _reason(refusal: str) -> str:
    """A refusal without its numbers."""
    return " ".join(w for w in refusal.split() if not any(c.isdigit() for c in w))[:90]


def tell(text: str) -> None:
    """Print at once."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main(first: str, last: str, what: str = "scenes") -> None:
    """Run a range of seeds and print what came of them."""
    outcomes, begin = [], time.process_time()
    outcome = {
        "scenes": scene_outcome,
        "matrices": matrix_outcome,
        "quadratic": quadratic_outcome,
        "low-rank": low_rank_outcome,
        "graded": graded_outcome,
        "graded-damped": graded_damped_outcome,
    }[what]
    for seed in range(int(first), int(last)):
        outcomes.append(outcome(seed))
        if outcomes[-1].faults:
            tell(str(outcomes[-1]))
    seconds = time.process_time() - begin
    tell(f"{statistics(outcomes)}\nseconds: {seconds:.0f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
