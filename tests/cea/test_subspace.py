"""Eigenpairs of an invariant subspace whose eigenvalues are equal but for rounding."""

import numpy as np
import pytest

from cea.eigen.subspace import InvariantSubspace, _rising

EPS = np.finfo(float).eps


def pairs_of(projected):
    """Eigenvalues and vectors of a subspace that is all there is."""
    made = InvariantSubspace(np.eye(len(projected)), projected, symmetric=False)
    return made.eigenpairs()


def rotated(block, others, seed=3):
    """A block beside other eigenvalues, in other coordinates."""
    whole = np.diag(np.concatenate([np.zeros(len(block)), others]))
    whole[: len(block), : len(block)] = block
    axes = np.linalg.qr(np.random.default_rng(seed).standard_normal(whole.shape))[0]
    return axes @ whole @ axes.T


@pytest.mark.parametrize("corner", [0.0, 1e-6 * EPS, -1e-6 * EPS])
def test_one_vector_twice_is_mended(corner):
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


def test_equal_complex_pairs_stay_conjugate():
    turn = np.array([[1.0, -1.0], [1.0, 1.0]])
    noise = np.zeros((4, 4))
    noise[:2, 2:] = 20 * EPS * np.eye(2)
    matrix = rotated(np.kron(np.eye(2), turn) + noise, [5.0])
    values, vectors = pairs_of(matrix)
    assert np.abs(matrix @ vectors - vectors * values).max() < 1e3 * EPS
    upper = np.flatnonzero(values.imag > 0)
    np.testing.assert_array_equal(values[upper + 1], values[upper].conj())
    np.testing.assert_array_equal(vectors[:, upper + 1], vectors[:, upper].conj())
    assert np.linalg.svd(vectors, compute_uv=False)[-1] > 0.1


def test_what_coalesces_in_earnest_is_left_as_it_is():
    """Of a Jordan block there is no second vector."""
    matrix = rotated(np.array([[1.0, 1.0], [0.0, 1.0]]), [3.0])
    values, vectors = pairs_of(matrix)
    two = np.argsort(np.abs(values - 1.0))[:2]
    assert np.linalg.svd(vectors[:, two], compute_uv=False)[-1] < 1e-6


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


def test_conjugates_that_rounding_parts_stay_together():
    """Vectors of the lower ones are the conjugates of those before them, whatever their values."""
    turn = np.array([[1.0, -1.0], [1.0, 1.0]])
    matrix = np.kron(np.eye(3), turn)
    made = InvariantSubspace(np.eye(6), matrix, symmetric=False)
    values, vectors = (part.copy() for part in made._pairs)
    values[1::2] *= 1 + 4 * EPS
    made.__dict__["_pairs"] = values, vectors
    order = _rising(values)
    assert order.tolist() in ([0, 1, 2, 3, 4, 5], [0, 1, 4, 5, 2, 3])
    assert np.linalg.norm(made.eigenpairs()[1], axis=0).min() > 0.9


def test_a_lower_one_whose_conjugate_was_mended_has_a_vector():
    """Of a pair that is nothing but rounding one may count as a copy of zero, the other not."""
    matrix = np.diag([0.0, 0.0, 2.0])
    matrix[:2, :2] = [[0.0, EPS], [-EPS, 0.0]]
    made = InvariantSubspace(np.eye(3), matrix, symmetric=False)
    values, small = (part.copy() for part in made._pairs)
    first = int(np.argmax(values.imag > 0))
    values[first], small[:, first] = 0.0, np.eye(3)[:, 0]
    made.__dict__["_pairs"] = values, small
    found, vectors = made.eigenpairs()
    assert (found.imag < 0).sum() == 1
    assert np.abs(matrix @ vectors - vectors * found).max() < 4 * EPS
    assert np.linalg.svd(vectors, compute_uv=False)[-1] > 0.1
