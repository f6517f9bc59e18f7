"""Matrices whose eigenvalues are multiple, alone and beside growing ones."""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import block_diag, qr

from cea.arrays import Floats
from comparisons.stability.parts.case import NONE, Run, case
from comparisons.stability.parts.dense import lambdas
from comparisons.stability.parts.problems import OfMatrices
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.ways import ALONE

_FREE = np.linspace(20.0, 1e4, 60)
"""Eigenvalues kappa beyond the window."""
_ANGLES = {"stable": 0.0, "fluttering": 0.3, "diverging": 2.0}
"""Friction that turns pairs of eigenvalues 1, 1 + 0.1 into others."""


@case("Eigenvalues 2 to 30 times in given matrices", subject="friction and spectra")
def multiplicities() -> Iterator[Run]:
    """Copies are found however many there are, and whatever grows beside them."""
    for number in (2, 5, 13, 30):
        for word, mu in _ANGLES.items():
            block = np.array([[1.0, 0.0], [0.0, 1.1]])
            friction = np.array([[0.0, mu], [-mu if word == "fluttering" else mu, 0.0]])
            kappas = np.linalg.eigvals(block - friction)
            S = block_diag(*[block] * number, np.diag(_FREE))
            F = block_diag(*[friction] * number, np.zeros((len(_FREE), len(_FREE))))
            turn = _rotation(len(S))
            true = lambdas(np.concatenate([np.repeat(kappas, number), _FREE]))
            yield Run(
                f"{number} copies, {word}",
                ALONE[0],
                OfMatrices(_symmetric(turn.T @ S @ turn), np.eye(len(S)), turn.T @ F @ turn),
                formula(true.tolist()),
                lowest=2 * number,
                warnings=NONE,
            )


def _rotation(n: int) -> Floats:
    """An orthogonal matrix, the same each time."""
    return qr(np.random.default_rng(1).standard_normal((n, n)))[0]


def _symmetric(matrix: Floats) -> Floats:
    return 0.5 * (matrix + matrix.T)
