"""From what a search found to modes: with their errors, and with left vectors where wanted."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.linalg import LinAlgError

from cea.arrays import Complexes
from cea.eigen.coverage import upper_end
from cea.eigen.errors import error_estimates
from cea.eigen.left_vectors import (
    LeftVectors,
    left_vectors_of,
    needs_left_vectors,
    two_sided,
    with_lengths,
)
from cea.eigen.modes import Modes, modes_of
from cea.eigen.pencil import Matrices, Pencil
from cea.eigen.quadratic_window import QuadraticNeighbours, QuadraticWindow
from cea.eigen.shift_invert import Undamped
from cea.eigen.spectrum import Window, nearest_window
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.window import DampedSearch, Found, WindowSearch
from cea.errors import ConvergenceError
from cea.timing import StageTimer


@dataclass(frozen=True)
class EigenProblem:
    """What is solved.

    Parameters
    ----------
    pencil, values, matrices
        A pencil, the parameters it is solved at, and its sums there.
    end
        omega of the end of the window (1/s); of the modes nearest to a place its modulus.
    timer
        Counts the stages.
    """

    pencil: Pencil
    values: Mapping[str, float]
    matrices: Matrices
    end: float
    timer: StageTimer

    def nearest_modes(self, found: InvariantSubspace, op: Undamped) -> Modes:
        """Modes of what was found next to a place, which is no window."""
        with self.timer("post-processing"):
            pairs = error_estimates(op, found)
            window = (QuadraticNeighbours.of if op.damped else nearest_window)(
                op.shift, pairs.values
            )
            return modes_of(self.pencil, self.values, self.matrices, pairs, None, window)


def modes_found(
    problem: EigenProblem, found: Found, search: WindowSearch, *, left: bool | None
) -> Modes:
    """Modes of what was found in a window, with their errors.

    Parameters
    ----------
    problem
        What was solved.
    found
        What was found.
    search
        What searches left vectors where they are wanted, or errors cannot be told without.
    left
        Whether left vectors are wanted; None searches none whatever was found.
    """
    timer, subspace, op = problem.timer, found.subspace, search.near
    with timer("post-processing"):  # those around the window show too what rounding does
        pairs = error_estimates(op, subspace)
        unsure = left is not None and needs_left_vectors(op, subspace, pairs)
    both: tuple[Complexes, LeftVectors] | None = None
    if op.symmetric and left:
        both = pairs.values, LeftVectors(pairs.vectors, pairs.forces)
    elif left or unsure:
        try:
            values, vectors = search.left(len(pairs.vectors))
            op = search.near
            with timer("post-processing"):
                both = values, left_vectors_of(op, pairs, values, vectors)
        except (ConvergenceError, LinAlgError):
            if left:
                raise
            op = search.near
    with timer("post-processing"):
        if left and both is not None and not (op.symmetric or subspace.graded):
            pairs = with_lengths(op, pairs, both[1])
        if unsure:
            pairs = two_sided(op, subspace, pairs, both)
        window = _window(problem, found, search, pairs.values)
        wanted = both[1] if left and both is not None else None
        return modes_of(problem.pencil, problem.values, problem.matrices, pairs, wanted, window)


def _window(problem: EigenProblem, found: Found, search: WindowSearch, values: Complexes) -> Window:
    """The window, and why it is believed complete."""
    end, disc = problem.end, found.discs[0] if found.discs else None
    common: dict[str, Any] = {
        "max_frequency": end / (2 * np.pi),
        "shift": disc.centre if disc else 0.0,
        "radius": disc.radius if disc else 0.0,
        "found": len(values),
        "discs": len(found.discs),
        "max_growth": np.inf if found.bounded else found.growth,
        "bounded": found.bounded,
        "odd": found.odd,
        "symmetric_count": found.counted,
        "whole": found.subspace.whole,
    }
    if isinstance(search, DampedSearch):
        below = int(np.sum((values.imag >= 0) & (values.imag <= end)))
        return QuadraticWindow(**common, upper=end, found_below=below, min_growth=-search.decay)
    upper = upper_end(end**2)
    return Window(**common, upper=upper, found_below=int(np.sum(values.real < upper)))
