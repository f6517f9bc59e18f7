"""How symmetric a matrix is, and its parts that are and are not."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.sparse import csr_array, diags_array

Kind = Literal["symmetric", "symmetric to rounding", "skew", "general"]

_ROUNDING = 16 * np.finfo(float).eps
"""Difference of an entry and its mirror image that rounding explains, relative to their size."""


@dataclass(frozen=True)
class Symmetry:
    """How symmetric a matrix is: to the last bit, but for rounding, not at all.

    The asymmetry is the largest difference of an entry and its mirror image, relative to their
    size: the larger of both, or the mean of the diagonal entries of their row and column,
    sqrt(abs(a_ii a_jj)), which scaling of unknowns leaves alone.
    """

    kind: Kind
    asymmetry: float


def symmetry_of(matrix: csr_array) -> Symmetry:
    """How symmetric a square matrix is, shape (n, n)."""
    transpose = matrix.T.tocsr()
    difference = csr_array(matrix - transpose).tocoo()
    differing = difference.data != 0
    if not differing.any():
        return Symmetry("symmetric", 0.0)
    rows, columns = difference.coords[0][differing], difference.coords[1][differing]
    gaps = np.abs(difference.data[differing])
    root = np.sqrt(np.abs(matrix.diagonal()))
    larger = csr_array(abs(matrix)).maximum(csr_array(abs(transpose)))
    sizes = np.maximum(root[rows] * root[columns], np.asarray(larger[rows, columns]).ravel())
    worst = float((gaps / sizes).max())
    if worst <= _ROUNDING:
        return Symmetry("symmetric to rounding", worst)
    skew = not (matrix + transpose).count_nonzero()
    return Symmetry("skew" if skew else "general", worst)


def half_of(matrix: csr_array) -> str | None:
    """Which half of a symmetric matrix this may be: no entry beside the diagonal has its mirror.

    None where one has, of a diagonal matrix, and where the diagonal is empty, as of friction forces
    along one direction from pressures along another.
    """
    if not matrix.diagonal().any():
        return None
    rows, columns = matrix.tocoo().coords
    below, above = bool((rows > columns).any()), bool((rows < columns).any())
    if not (below or above):
        return None
    if below != above:
        return "lower triangle" if below else "upper triangle"
    pattern = csr_array((matrix - diags_array(matrix.diagonal())) != 0)
    return None if pattern.multiply(pattern.T).count_nonzero() else "half of mirrored entries"


def mirrored(half: csr_array) -> csr_array:
    """The symmetric matrix of which one half is given."""
    return csr_array(half + half.T - diags_array(half.diagonal()))


def equal_entries(matrix: csr_array) -> tuple[csr_array, csr_array]:
    """The entries that are equal to their mirror image, and the others: no bit is changed."""
    whole = matrix.tocoo()
    rows, columns = whole.coords
    same = whole.data == np.asarray(matrix.T.tocsr()[rows, columns]).ravel()
    equal, rest = (
        csr_array((whole.data[part], (rows[part], columns[part])), shape=matrix.shape)
        for part in (same, ~same)
    )
    return equal, rest
