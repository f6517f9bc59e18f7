"""Eigenpairs of an invariant subspace whose eigenvalues are equal but for rounding."""

import numpy as np
import pytest

from cea.eigen.subspace import InvariantSubspace

EPS = np.finfo(float).eps


def pairs_of(projected):
    """Eigenvalues and vectors of a subspace that is all there is."""
    made = InvariantSubspace(np.eye(len(projected)), projected, symmetric=False)
    return made.eigenpairs()


@pytest.mark.parametrize("corner", [0.0, 1e-6 * EPS, -1e-6 * EPS])
def test_one_vector_twice_is_replaced(corner):
    """A Jordan block that is nothing but rounding, or nearly so, as of rigid motions."""
    matrix = np.diag([0.0, 0.0, 1.0, 2.0, 3.0])
    matrix[:2, :2] = [[0.0, 30 * EPS], [corner, 0.0]]
    own = np.linalg.eig(matrix)[1]
    values, vectors = pairs_of(matrix)
    slow = np.abs(values) < 1e-9
    assert slow.sum() == 2
    assert np.linalg.svd(own[:, slow], compute_uv=False)[-1] < 1e-2
    assert np.linalg.svd(vectors[:, slow], compute_uv=False)[-1] > 0.9
    assert np.abs(matrix @ vectors - vectors * values).max() < 1e3 * EPS


def test_pairs_rise_with_the_imaginary_part_of_lambda():
    """Equal complex pairs, and real kappa of both signs, between others."""
    turn = np.array([[2.0, -1.0], [1.0, 2.0]])
    blocks = [[[3.0]], turn, [[-4.0]], [[0.5]], turn, [[-1.0]], [[1.9]], [[2.2]]]
    size = sum(len(block) for block in blocks)
    matrix, first = np.zeros((size, size)), 0
    for block in blocks:
        last = first + len(block)
        matrix[first:last, first:last] = block
        first = last
    values, vectors = pairs_of(matrix)
    upper = np.flatnonzero(values.imag > 0)
    np.testing.assert_array_equal(values[upper + 1], values[upper].conj())
    assert np.abs(matrix @ vectors - vectors * values).max() < 100 * EPS
    lam = np.sqrt(-values)
    assert (np.diff(np.abs(lam.imag)) >= -10 * EPS).all()
    assert values[:2] == pytest.approx([-1.0, -4.0])
