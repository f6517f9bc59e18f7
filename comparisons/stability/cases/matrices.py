"""Matrices from files: units far apart, masses next to nothing, clusters, Jordan blocks."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, get_args

import numpy as np

from cea.arrays import Floats
from comparisons.stability.parts.case import HONEST, NONE, REFUSED, WARNED, Case, Run
from comparisons.stability.parts.matrix_files import (
    Block,
    Format,
    OfFiles,
    matrices_of,
    transformed,
    upper,
)
from comparisons.stability.parts.references import formula
from comparisons.stability.parts.ways import ALONE

SUBJECT = "matrices"
_STIFFNESSES = np.linspace(1.0, 60.0, 12)
_PLAIN = tuple(Block(k) for k in _STIFFNESSES)
_UNDAMPED = tuple(Block(k, f=0.3 if 4 < k < 12 else 0.0) for k in _STIFFNESSES)
"""Some of them flutter."""
_DAMPED = tuple(replace(block, c=0.02, g=0.1) for block in _UNDAMPED)
_N = 2 * len(_DAMPED)


def _mixing(n: int, seed: int, size: float) -> Floats:
    return np.eye(n) + size * np.random.default_rng(seed).standard_normal((n, n)) / np.sqrt(n)


_MIXED = _mixing(_N, 5, 0.4)


def _run(
    row: str, blocks: tuple[Block, ...], matrices: Mapping[str, Floats], **options: Any
) -> Run:
    problem, true = OfFiles(matrices, options.pop("form", "npz")), formula(upper(blocks))
    return replace(Run(row, ALONE[0], problem, true, lowest=12, warnings=NONE), **options)


def _refused(row: str, matrices: Mapping[str, Floats]) -> Run:
    options: dict[str, Any] = {"reference": None, "expected": REFUSED}
    return _run(row, _DAMPED, matrices, names="positive definite", **options)


def _units() -> Iterator[Run]:
    """Scaling of unknowns and of time changes nothing."""
    mixed = transformed(matrices_of(_DAMPED), _MIXED)
    for form in get_args(Format):
        yield _run(f"damped, rotating, with friction: .{form}", _DAMPED, mixed, form=form)
    undamped = transformed(matrices_of(_PLAIN), _MIXED)
    yield _run("neither damped nor rotating", _PLAIN, undamped)
    for digits in (3, 6, 9, 12):
        scaled = transformed(mixed, np.diag(np.geomspace(10.0**-digits, 10.0**digits, _N)))
        yield _run(f"units of unknowns 1e-{digits} to 1e{digits}", _DAMPED, scaled)
    for time in (1e-9, 1e-4, 1e4, 1e9):
        faster = tuple(Block(b.k / time**2, b.c / time, b.g / time, b.f / time**2) for b in _DAMPED)
        matrices = {"M": mixed["M"], "C": mixed["C"] / time, "K": mixed["K"] / time**2}
        yield _run(f"unit of time {time:.0e} s", faster, matrices)


def _masses() -> Iterator[Run]:
    """A mass next to nothing is a mode far beyond the window; a singular one is refused."""
    for mass in (1e-3, 1e-6, 1e-9, 1e-12):
        blocks = (*_DAMPED, Block(5.0 / mass))
        matrices = matrices_of(blocks)
        for name in ("M", "K"):
            matrices[name][-2:, -2:] *= mass
        change = np.eye(_N + 2)
        change[:_N, :_N] = _MIXED
        change[-2:, :_N] = 0.1
        yield _run(f"masses of {mass:.0e} beside 1", blocks, transformed(matrices, change))
    for number in (1, 5):
        matrices = matrices_of(_DAMPED)
        matrices["M"][:number, :number] = 0.0
        yield _refused(f"{number} unknowns without mass", matrices)
        yield _refused(f"{number} motions without mass", transformed(matrices, _MIXED))


def _clusters() -> Iterator[Run]:
    """Copies, and Jordan blocks, whose members have the square root of rounding."""
    equal = (Block(4.0, c=0.02, f=0.1),) * 10 + (Block(9.0, c=0.02),) * 10 + _DAMPED
    matrices = matrices_of(equal)
    mixed = transformed(matrices, _mixing(2 * len(equal), 6, 0.3))
    yield _run("10 copies of two, as they are", equal, matrices, lowest=45)
    yield _run("10 copies of two, mixed", equal, mixed, lowest=45)
    for coupling in (1.0, 1e-6):
        blocks = (Block(4.0, c=0.02), *_DAMPED)
        jordan = matrices_of(blocks)
        jordan["K"][0, 1] += coupling
        row = f"a Jordan block, coupling {coupling:.0e}"
        yield _run(row, blocks, jordan, expected=WARNED)


def _rounding() -> Iterator[Run]:
    noise = 1 + 2e-16 * np.sign(np.tri(_N) - 0.5)
    for row, blocks, options in (
        ("unsymmetric by friction and by rounding", _DAMPED, {}),
        (
            "symmetric but for rounding",
            tuple(Block(block.k, block.c) for block in _DAMPED),
            {"warnings": ("symmetrised",)},
        ),
    ):
        rounded = transformed(matrices_of(blocks), _MIXED)
        rounded["K"] = rounded["K"] * noise
        yield _run(row, blocks, rounded, **options)


def _graded() -> Iterator[Run]:
    """D1 K D2 and D1 M D2 have the eigenvalues of K and M; a shear that no scaling undoes."""
    random = np.random.default_rng(11)
    turn: Floats = np.linalg.qr(random.standard_normal((_N, _N)))[0]
    steps, others = (random.permutation(np.linspace(-1.0, 1.0, _N)) for _ in range(2))

    def turned(blocks: tuple[Block, ...]) -> dict[str, Floats]:
        return {**transformed(matrices_of(blocks), turn.T), "M": np.eye(_N)}

    def powers(steps: Floats, digits: int) -> Floats:
        """Powers of two between 10^-digits and 10^digits: they round nothing."""
        return 2.0 ** np.round(digits * np.log2(10.0) * steps)

    def scaled(plain: Mapping[str, Floats], left: Floats, right: Floats) -> dict[str, Floats]:
        return {name: left[:, None] * matrix * right for name, matrix in plain.items()}

    for name, blocks in (("undamped", _UNDAMPED), ("damped, rotating", _DAMPED)):
        plain = turned(blocks)
        for digits in (2, 4, 6, 9, 12):
            one, other = powers(steps, digits), powers(others, digits)
            row = f"{name}, 1e-{digits} to 1e{digits}"
            yield _run(f"D K D^-1, {row}", blocks, scaled(plain, one, 1 / one))
            yield _run(f"D1 K D2, {row}", blocks, scaled(plain, one, other))
    half = _N // 2
    shear = np.zeros((_N, _N))
    shear[:half, half:] = turn[:half, half:]
    for size in (1e1, 1e3, 1e5, 1e7):
        there, back = np.eye(_N) + size * shear, np.eye(_N) - size * shear
        stiffness = turn.T @ (there @ matrices_of(_UNDAMPED)["K"] @ back) @ turn
        row = f"sheared by {size:.0e}, turned"
        yield _run(row, _UNDAMPED, {**turned(_UNDAMPED), "K": stiffness}, expected=HONEST)


CASES = {
    "graded": Case("Matrices whose unknowns and equations are scaled far apart", _graded),
    "matrices_from_files": Case(
        "Matrices from files in all units, and near to what has no answer",
        *(_units, _masses, _clusters, _rounding),
    ),
}
