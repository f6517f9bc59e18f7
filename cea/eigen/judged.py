"""From what a search found to modes: with their errors, and with left vectors where wanted."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from numpy.linalg import LinAlgError

from cea.eigen.clusters import cluster_bounds
from cea.eigen.eigenpairs import checked
from cea.eigen.found import Found
from cea.eigen.modes import Modes, modes_of
from cea.eigen.pencil import Matrices, Pencil
from cea.eigen.search import WindowSearch
from cea.eigen.sensitivity import dual_norms, left_vectors_of
from cea.eigen.shifted import Shifted
from cea.eigen.two_sided import judged_by_both, one_sided
from cea.errors import ConvergenceError
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
    found: Found,
    top: float,
    question: Question,
    search: WindowSearch | None = None,
    *,
    left: bool = False,
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
        What searches left vectors where they are wanted, or errors cannot be told without; None
        where it failed. It moves the factors.
    left
        Whether left vectors are wanted.
    """
    matrices, factors, timer = question.matrices, question.factors, question.timer
    subspace = found.subspace
    with timer("post-processing"):  # those around the window show too what rounding does
        kappa, vectors = subspace.eigenpairs()
        window = found.window(top, kappa)
        pairs = checked(matrices, factors, kappa, vectors, subspace.conditions())
        if not matrices.symmetric:
            bounds = cluster_bounds(subspace.projected, pairs.kappa, pairs.errors, pairs.conditions)
            pairs = replace(pairs, bounds=bounds)
        unsure = search is not None and one_sided(matrices, factors, subspace, pairs)
    left_vectors = None
    if search is not None and (left or unsure):
        try:
            kappa, vectors = search.left(kappa)
            with timer("post-processing"):
                left_vectors = left_vectors_of(matrices, factors, pairs, kappa, vectors, top)
        except (ConvergenceError, LinAlgError):
            if left or not unsure:
                raise
    with timer("post-processing"):
        if left and left_vectors is not None and not matrices.symmetric:
            conditions = dual_norms(matrices.mass, left_vectors.vectors)
            pairs = replace(pairs, conditions=conditions)
        if unsure:
            both = None if left_vectors is None else (kappa, left_vectors)
            pairs = judged_by_both(matrices, subspace, pairs, both, top)
        wanted = left_vectors if left else None
        return modes_of(question.pencil, question.values, matrices, pairs, wanted, window)
