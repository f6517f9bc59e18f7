"""Rows at many points compressed to as many as are independent: by hand, and on interfaces."""

import numpy as np
from scipy.sparse import csr_array

from cea.contact.compression import compressed
from cea.petsc import MPI


def hats(x, cells):
    """Hat functions on equal cells at points of [0, 1]."""
    return np.maximum(0.0, 1 - np.abs(cells * x[:, None] - np.arange(cells + 1)))


def rows(points=700, seed=1):
    """Gaps between two functions on meshes that do not match, slips of other functions."""
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(size=points))
    left, right = hats(x, 40), -hats(x, 33)
    gap = np.hstack([left, right, np.zeros((points, 50))])
    slip = np.hstack([0.3 * left, np.zeros_like(right), hats(x, 49)])
    return csr_array(gap), csr_array(slip), x[:, None]


def size(matrix):
    return np.abs(matrix).max()


def test_products_are_kept_and_rows_are_as_many_as_the_rank():
    gap, slip, x = rows()
    closure, reaction = (m.toarray() for m in compressed(gap, slip, x, MPI.COMM_SELF))
    gap, slip = gap.toarray(), slip.toarray()
    assert len(closure) == np.linalg.matrix_rank(gap) == np.linalg.matrix_rank(closure)
    assert size(closure.T @ closure - gap.T @ gap) < 1e-13 * size(gap.T @ gap)
    assert size(reaction.T @ closure - slip.T @ gap) < 1e-13 * size(slip.T @ gap)


def test_small_rows_keep_their_digits_beside_large_ones():
    """Stiffness that varies by 1e15: that of the soft half, which only soft points touch."""
    gap, slip, x = rows()
    scale = np.sqrt(np.where(x[:, 0] < 0.52, 1.0, 1e15))[:, None]
    closure, reaction = compressed(
        csr_array(gap * scale), csr_array(slip * scale), x, MPI.COMM_SELF
    )
    soft = np.r_[0:19, 41:57]
    normal, friction = (
        (matrix[:, soft].T @ closure[:, soft]).toarray() for matrix in (closure, reaction)
    )
    gap, slip = (m.toarray()[:, soft] for m in (gap, slip))
    assert size(normal - gap.T @ gap) < 1e-12 * size(normal)
    assert size(friction - slip.T @ gap) < 1e-12 * size(friction)


def test_normals_along_axes_leave_rounding_that_is_no_gap():
    gap, slip, x = rows()
    noisy = gap.toarray()
    noisy[:, 80:90] = 1e-14 * np.random.default_rng(2).normal(size=(len(noisy), 10))
    closure, _ = compressed(csr_array(noisy), slip, x, MPI.COMM_SELF)
    assert closure.shape[0] == np.linalg.matrix_rank(gap.toarray())
