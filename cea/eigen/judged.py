"""From what a search found to modes: with their errors, and with left vectors where wanted."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from cea.eigen.clusters import cluster_bounds
from cea.eigen.eigenpairs import checked
from cea.eigen.found import Found
from cea.eigen.modes import Modes, modes_of
from cea.eigen.pencil import Matrices, Pencil
from cea.eigen.search import WindowSearch
from cea.eigen.sensitivity import left_vectors_of
from cea.eigen.shifted import Shifted
from cea.timing import StageTimer


@dataclass(frozen=True)
class Question:
    """What was solved.

    Parameters
    ----------
    pencil, values, matrices
        A pencil, the parameters it was solved at, and its sums there.
    factors
        The pencil factorised near the modes.
    timer
        Counts post-processing.
    """

    pencil: Pencil
    values: Mapping[str, float]
    matrices: Matrices
    factors: Shifted
    timer: StageTimer


def judged(
    found: Found, top: float, question: Question, search: WindowSearch | None = None
) -> Modes:
    """Modes of what was found in a window, with their errors.

    Parameters
    ----------
    found
        What was found.
    top
        omega^2 (1/s^2).
    question
        What was solved.
    search
        What searches left vectors; None where none are wanted. It moves the factors.
    """
    matrices, factors, timer = question.matrices, question.factors, question.timer
    kappa, vectors = found.subspace.eigenpairs()
    window = found.window(top, kappa)
    with timer("post-processing"):  # those around the window show too what rounding does
        conditions = found.subspace.conditions()
        pairs = checked(matrices, factors, kappa, vectors, conditions)
        if not matrices.symmetric:
            bounds = cluster_bounds(
                found.subspace.projected, pairs.kappa, pairs.errors, pairs.conditions
            )
            pairs = replace(pairs, bounds=bounds)
    left_vectors = None
    if search is not None:
        kappa, vectors = search.left()
        with timer("post-processing"):
            left_vectors = left_vectors_of(matrices, factors, pairs, kappa, vectors, top)
    return modes_of(question.pencil, question.values, matrices, pairs, left_vectors, window)
