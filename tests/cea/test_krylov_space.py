"""Krylov spaces: the relation they hold, orthonormal beside what is locked, to rounding."""

import numpy as np
import pytest

from cea.eigen.krylov_space import KrylovSpace


class Dense:
    """An operator and an inner product given as full matrices."""

    def __init__(self, operator, mass):
        self.operator, self.mass = operator, mass

    def apply(self, block, image):
        """OP times a block."""
        return self.operator @ block

    def image(self, block):
        """M times a block."""
        return self.mass @ block

    def inner(self, left, right):
        """Without ranks."""
        return left.T @ right


@pytest.mark.parametrize("locked", [0, 5])
def test_the_space_holds_its_relation(locked):
    """Eigenvalues over ten decades, as an inverse has them; a restart keeps the relation."""
    rng, n = np.random.default_rng(3), 160
    turn = np.linalg.qr(rng.standard_normal((n, n)))[0]
    upper = np.diag(np.geomspace(1.0, 1e-10, n)) + 1e-2 * np.triu(rng.normal(size=(n, n)), 1) / n
    root = np.eye(n) + 0.2 * np.diag(rng.uniform(size=n))
    mass = root @ root
    solved = np.linalg.inv(root) @ turn @ upper @ turn.T @ root
    q = np.asfortranarray(np.linalg.inv(root) @ turn[:, :locked])
    space = KrylovSpace(Dense(solved, mass), q, n - locked)
    space.start(np.asfortranarray(rng.standard_normal((n, 4))))
    for step in range(12):
        space.extend()
        if step == 8:
            values, vectors = np.linalg.eig(space.square)
            order = np.argsort(-np.abs(values))[:20]
            vectors, triangle = np.linalg.qr(vectors[:, order].real)
            form = triangle @ np.diag(values[order].real) @ np.linalg.inv(triangle)
            space.restart(form, vectors)
    whole = space._take(0, locked + space.size + space.next)
    gram = whole.T @ mass @ whole
    assert np.abs(gram - np.eye(len(gram))).max() < 1e-12
    held = whole @ np.vstack([space.coupling, space.operator])
    assert np.abs(solved @ space.combined(np.eye(space.size)) - held).max() < 1e-12


def test_a_space_that_is_full_ends():
    rng, n = np.random.default_rng(0), 21
    operator = rng.standard_normal((n, n))
    space = KrylovSpace(Dense(operator, np.eye(n)), np.empty((n, 0), order="F"), n)
    space.start(np.asfortranarray(rng.standard_normal((n, 4))))
    while space.next:
        space.extend()
    assert space.size == n
    found = np.sort_complex(np.linalg.eigvals(space.square))
    assert np.abs(found - np.sort_complex(np.linalg.eigvals(operator))).max() < 1e-10
