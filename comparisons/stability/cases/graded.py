"""Unknowns and equations of units far apart: entries know the eigenvalues, norms do not."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cea.arrays import Floats
from comparisons.stability.parts.case import HONEST, NONE, Run, case
from comparisons.stability.parts.matrix_files import Block, OfFiles, matrices_of, transformed, upper
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.ways import ALONE

_WAY = ALONE[0]
_UNDAMPED = tuple(Block(k, f=0.3 if 4 < k < 12 else 0.0) for k in np.linspace(1.0, 60.0, 12))
_DAMPED = tuple(replace(block, c=0.02, g=0.1) for block in _UNDAMPED)
_N = 2 * len(_DAMPED)
_RANDOM = np.random.default_rng(11)
_TURN = np.linalg.qr(_RANDOM.standard_normal((_N, _N)))[0]
_STEPS = _RANDOM.permutation(np.linspace(-1.0, 1.0, _N))
_OTHERS = _RANDOM.permutation(np.linspace(-1.0, 1.0, _N))


def _powers(steps: Floats, digits: int) -> Floats:
    """Powers of two between 10^-digits and 10^digits: they round nothing."""
    return 2.0 ** np.round(digits * np.log2(10.0) * steps)


def _scaled(matrices: Mapping[str, Floats], left: Floats, right: Floats) -> dict[str, Floats]:
    return {name: left[:, None] * matrix * right for name, matrix in matrices.items()}


def _run(
    row: str, blocks: tuple[Block, ...], matrices: Mapping[str, Floats], **options: Any
) -> Run:
    true = formula(upper(blocks))
    return replace(Run(row, _WAY, OfFiles(matrices), true, lowest=12, warnings=NONE), **options)


@case("Matrices whose unknowns and equations are scaled far apart", subject="matrices")
def graded() -> Iterator[Run]:
    """D1 K D2 and D1 M D2 have the eigenvalues of K and M; what no scaling undoes is owned to."""
    for name, blocks in (("undamped", _UNDAMPED), ("damped, rotating", _DAMPED)):
        plain = {**transformed(matrices_of(blocks), _TURN.T), "M": np.eye(_N)}
        for digits in (2, 4, 6, 9, 12):
            one, other = _powers(_STEPS, digits), _powers(_OTHERS, digits)
            row = f"{name}, 1e-{digits} to 1e{digits}"
            yield _run(f"D K D^-1, {row}", blocks, _scaled(plain, one, 1 / one))
            yield _run(f"D1 K D2, {row}", blocks, _scaled(plain, one, other))
    plain = {**transformed(matrices_of(_UNDAMPED), _TURN.T), "M": np.eye(_N)}
    upper_block = np.zeros((_N, _N))
    upper_block[: _N // 2, _N // 2 :] = _TURN[: _N // 2, _N // 2 :]
    for size in (1e1, 1e3, 1e5, 1e7):
        there, back = np.eye(_N) + size * upper_block, np.eye(_N) - size * upper_block
        stiffness = _TURN.T @ (there @ matrices_of(_UNDAMPED)["K"] @ back) @ _TURN
        row = f"sheared by {size:.0e}, turned"
        yield _run(row, _UNDAMPED, {**plain, "K": stiffness}, expected=HONEST)
