"""The driver of this program."""

import numpy as np

from cea.eigen.driver import solve_modes
from cea.timing import StageTimer
from comparisons.bench.solve.methods.method import Answer
from comparisons.bench.solve.methods.problem import Problem


def solve(problem: Problem) -> Answer:
    """All modes of the window, with what shows that they are all."""
    timer = StageTimer()
    modes = solve_modes(problem.pencil(), np.sqrt(problem.top) / (2 * np.pi), timer=timer)
    window = modes.window
    claims = "complete" if window.bounded else f"complete to a growth of {window.max_growth:.3g}"
    kappa = -(modes.eigenvalues**2)
    return Answer(kappa, modes.vectors, claims, dict(timer.processor_seconds))
