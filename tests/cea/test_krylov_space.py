"""Krylov spaces: the relation they hold, orthonormal beside what is known, to rounding."""

import numpy as np
import pytest

from cea.eigen.blocks import beside, combined, inner, subtract
from cea.eigen.krylov_space import KrylovSpace


class Dense:
    """An operator and an inner product given as full matrices."""

    def __init__(self, operator, mass):
        self.operator, self.mass = operator, mass
        self.dtype = complex if np.iscomplexobj(operator) else float

    def apply(self, block, image):
        """OP times a block."""
        return self.operator @ block

    def image(self, block):
        """M times a block."""
        return self.mass @ block

    def inner(self, left, right):
        """Without ranks."""
        return inner(left, right)


def numbers(rng, shape, kind):
    values = rng.standard_normal(shape)
    return values + 1j * rng.standard_normal(shape) if kind is complex else values


@pytest.mark.parametrize("known", [0, 5])
def test_the_space_holds_its_relation(known):
    """Eigenvalues over ten decades, as an inverse has them; a restart keeps the relation."""
    rng, n = np.random.default_rng(3), 160
    turn = np.linalg.qr(numbers(rng, (n, n), float))[0]
    upper = np.diag(np.geomspace(1.0, 1e-10, n)) + 1e-2 * np.triu(rng.normal(size=(n, n)), 1) / n
    root = np.eye(n) + 0.2 * np.diag(rng.uniform(size=n))
    mass = root @ root
    solved = np.linalg.inv(root) @ turn @ upper @ turn.conj().T @ root
    q = np.asfortranarray(np.linalg.inv(root) @ turn[:, :known])
    owner = Dense(solved, mass)
    space = KrylovSpace(owner, q, n - known)
    space.start(np.asfortranarray(numbers(rng, (n, 4), float)))
    for step in range(12):
        space.extend()
        if step == 8:
            values, vectors = np.linalg.eig(space.square)
            order = np.argsort(-np.abs(values))[:20]
            assert np.abs(values[order].imag).max() == 0
            vectors, values = vectors.real, values.real
            vectors, triangle = np.linalg.qr(vectors[:, order])
            form = triangle @ np.diag(values[order]) @ np.linalg.inv(triangle)
            space.restart(form, vectors)
    whole = space._take(0, known + space.size + space.next)
    gram = whole.conj().T @ mass @ whole
    assert np.abs(gram - np.eye(len(gram))).max() < 1e-12
    v = space.combined(np.eye(space.size))
    held = whole @ np.vstack([space.coupling, space.operator])
    assert np.abs(solved @ v - held).max() < 1e-12


def test_a_space_that_is_full_ends():
    rng, n = np.random.default_rng(0), 21
    owner = Dense(rng.standard_normal((n, n)), np.eye(n))
    space = KrylovSpace(owner, np.empty((n, 0), order="F"), n)
    space.start(np.asfortranarray(rng.standard_normal((n, 4))))
    while space.next:
        space.extend()
    assert space.size == n
    found = np.sort_complex(np.linalg.eigvals(space.square))
    assert np.abs(found - np.sort_complex(np.linalg.eigvals(owner.operator))).max() < 1e-10


@pytest.mark.parametrize("kind", [float, complex])
def test_products_are_those_of_numpy(kind):
    rng = np.random.default_rng(1)
    tall, block = (np.asfortranarray(numbers(rng, (50, k), kind)) for k in (7, 3))
    factors = numbers(rng, (7, 3), kind)
    assert np.allclose(combined(tall, factors), tall @ factors, atol=1e-13)
    assert combined(tall, factors).flags.f_contiguous
    assert np.allclose(combined(tall.real.copy(order="F"), factors), tall.real @ factors)
    assert np.allclose(inner(tall, block), tall.conj().T @ block, atol=1e-13)
    assert np.array_equal(beside(tall, block), np.hstack([tall, block]))
    for there in (block.copy(order="F"), block.copy(order="C")):
        subtract(there, tall, factors)
        assert np.allclose(there, block - tall @ factors, atol=1e-13)
