"""Random pencils of given eigenvalues, multiple ones among them, with and without friction."""

import numpy as np
from petsc_matrices import to_petsc

from cea.eigen.pencil import Pencil


def random_pencil(seed: int) -> tuple[Pencil, float]:
    """A pencil with eigenvalues of multiplicity 2 to 30, and the end of a window (Hz).

    Without friction its kappa are zero or positive. Friction has few ranks: it moves as many copies
    of an eigenvalue and leaves the others, wherever it is not kept to a few eigenspaces.
    """
    rng = np.random.default_rng(seed)
    kappa = _eigenvalues(rng)
    n = len(kappa)
    basis, root = np.eye(n), np.eye(n)  # copies equal to the last bit
    if rng.random() < 0.6:  # or but for rounding
        basis = np.linalg.qr(rng.standard_normal((n, n)))[0]
    if rng.random() < 0.5:  # a mass that is not the identity
        root = np.linalg.qr(rng.standard_normal((n, n)))[0] * np.geomspace(1, 30, n) ** 0.5
    half = root @ basis
    stiffness, mass = _symmetric((half * kappa) @ half.T), _symmetric(root @ root.T)
    friction = None
    if rng.random() < 0.7:
        friction = half @ _of_few_ranks(rng, kappa) @ half.T
    pencil = Pencil.of(
        to_petsc(stiffness), to_petsc(mass), None if friction is None else to_petsc(friction)
    )
    low = kappa[(kappa > 0) & (kappa <= np.quantile(kappa, rng.choice([0.3, 0.6, 1.0])))]
    end = rng.choice(low if len(low) else kappa[kappa > 0]) * rng.choice([0.97, 1.03, 1.5])
    return pencil, float(np.sqrt(end) / (2 * np.pi))


def _eigenvalues(rng) -> np.ndarray:
    """Some of multiplicity 2 to 30, zero now and then among them, and many single ones above."""
    values = [20.0 * np.geomspace(0.02, 1e3, rng.integers(40, 160)) * rng.uniform(0.9, 1.1)]
    for _ in range(rng.integers(1, 5)):
        value = 0.0 if rng.random() < 0.3 else rng.uniform(0.5, 20.0)
        values.append(np.full(rng.integers(2, 31), value))
    return np.sort(np.concatenate(values)) * 10.0 ** rng.integers(-3, 9)


def _of_few_ranks(rng, kappa) -> np.ndarray:
    """An unsymmetric matrix of one to three ranks, as large as a part of the eigenvalues."""
    n, ranks = len(kappa), int(rng.integers(1, 4))
    left, right = rng.standard_normal((2, n, ranks))
    if rng.random() < 0.4:  # it acts on the eigenspaces of two eigenvalues only
        acts = np.isin(kappa, rng.choice(np.unique(kappa), 2))
        left, right = left * acts[:, None], right * acts[:, None]
    return left @ right.T * np.median(kappa) * 10.0 ** rng.uniform(-4, 0) / n


def _symmetric(matrix) -> np.ndarray:
    return 0.5 * (matrix + matrix.T)
