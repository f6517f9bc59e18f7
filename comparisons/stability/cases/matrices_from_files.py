"""Matrices from files: units far apart, masses next to nothing, clusters, Jordan blocks."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from comparisons.stability.parts.case import NONE, REFUSED, WARNED, Run, case
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

_WAY = ALONE[0]
_BLOCKS = tuple(
    Block(k, c=0.02, g=0.1, f=0.3 if 4 < k < 12 else 0.0) for k in np.linspace(1.0, 60.0, 12)
)
"""Some of them flutter."""
_N = 2 * len(_BLOCKS)
_MIXED = np.eye(_N) + 0.4 * np.random.default_rng(5).standard_normal((_N, _N)) / np.sqrt(_N)
_FORMATS: tuple[Format, ...] = ("mat", "mtx", "npz", "petsc")


def _run(row: str, blocks: tuple[Block, ...], problem: OfFiles, **options: Any) -> Run:
    return replace(
        Run(row, _WAY, problem, formula(upper(blocks)), lowest=12, warnings=NONE), **options
    )


@case("Matrices from files in all units, and near to what has no answer", subject="matrices")
def matrices_from_files() -> Iterator[Run]:
    """Scaling of unknowns and of time changes nothing; a mass that is singular is refused."""
    mixed = transformed(matrices_of(_BLOCKS), _MIXED)
    for form in _FORMATS:
        yield _run(f"damped, rotating, with friction: .{form}", _BLOCKS, OfFiles(mixed, form))
    plain = tuple(Block(block.k) for block in _BLOCKS)
    undamped = transformed(matrices_of(plain), _MIXED)
    yield _run("neither damped nor rotating", plain, OfFiles(undamped))
    for digits in (3, 6, 9, 12):
        scaled = transformed(mixed, np.diag(np.geomspace(10.0**-digits, 10.0**digits, _N)))
        yield _run(f"units of unknowns 1e-{digits} to 1e{digits}", _BLOCKS, OfFiles(scaled))
    for time in (1e-9, 1e-4, 1e4, 1e9):
        faster = tuple(Block(b.k / time**2, b.c / time, b.g / time, b.f / time**2) for b in _BLOCKS)
        matrices = {"M": mixed["M"], "C": mixed["C"] / time, "K": mixed["K"] / time**2}
        yield _run(f"unit of time {time:.0e} s", faster, OfFiles(matrices))
    yield from _masses()
    yield from _clusters()


def _masses() -> Iterator[Run]:
    """A mass next to nothing is a mode far beyond the window."""
    for mass in (1e-3, 1e-6, 1e-9, 1e-12):
        light = Block(5.0 / mass)
        matrices = matrices_of((*_BLOCKS, light))
        matrices["M"][-2:, -2:] *= mass
        matrices["K"][-2:, -2:] *= mass
        change = np.eye(_N + 2)
        change[:_N, :_N] = _MIXED
        change[-2:, :_N] = 0.1
        yield _run(
            f"masses of {mass:.0e} beside 1",
            (*_BLOCKS, light),
            OfFiles(transformed(matrices, change)),
        )
    for number in (1, 5):
        matrices = matrices_of(_BLOCKS)
        matrices["M"][:number, :number] = 0.0
        yield _run(
            f"{number} unknowns without mass",
            _BLOCKS,
            OfFiles(matrices),
            reference=None,
            expected=REFUSED,
            names="positive definite",
        )
        yield _run(
            f"{number} motions without mass",
            _BLOCKS,
            OfFiles(transformed(matrices, _MIXED)),
            reference=None,
            expected=REFUSED,
            names="positive definite",
        )


def _clusters() -> Iterator[Run]:
    """Copies, and Jordan blocks, whose members have the square root of rounding."""
    equal = (Block(4.0, c=0.02, f=0.1),) * 10 + (Block(9.0, c=0.02),) * 10 + _BLOCKS
    n = 2 * len(equal)
    change = np.eye(n) + 0.3 * np.random.default_rng(6).standard_normal((n, n)) / np.sqrt(n)
    yield _run("10 copies of two, as they are", equal, OfFiles(matrices_of(equal)), lowest=45)
    yield _run(
        "10 copies of two, mixed",
        equal,
        OfFiles(transformed(matrices_of(equal), change)),
        lowest=45,
    )
    for coupling in (1.0, 1e-6):
        blocks = (Block(4.0, c=0.02), *_BLOCKS)
        jordan = matrices_of(blocks)
        jordan["K"][0, 1] += coupling
        row = f"a Jordan block, coupling {coupling:.0e}"
        yield _run(row, blocks, OfFiles(jordan), expected=WARNED)
    noise = 1 + 2e-16 * np.sign(np.tri(_N) - 0.5)
    rounded = transformed(matrices_of(_BLOCKS), _MIXED)
    rounded["K"] = rounded["K"] * noise
    yield _run("unsymmetric by friction and by rounding", _BLOCKS, OfFiles(rounded))
    plain = tuple(Block(block.k, block.c) for block in _BLOCKS)
    rounded = transformed(matrices_of(plain), _MIXED)
    rounded["K"] = rounded["K"] * noise
    yield _run("symmetric but for rounding", plain, OfFiles(rounded), warnings=("symmetrised",))
