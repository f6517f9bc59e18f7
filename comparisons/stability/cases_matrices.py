"""Matrices from files: scaled, clustered, sheared, near to what has no answer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import block_diag, qr

from cea.arrays import Complexes, Floats
from comparisons.stability.case import EXPECTED, Run, Runs, formula
from comparisons.stability.dense import lambdas
from comparisons.stability.problems import OfFiles
from comparisons.stability.ways import ALONE


@dataclass(frozen=True)
class Block:
    """Two unknowns: (lambda^2 + (c -+ i g) lambda + k -+ i f) = 0."""

    k: float  # stiffness (1/s^2)
    c: float = 0.0  # damping (1/s)
    g: float = 0.0  # gyroscopic coupling (1/s)
    f: float = 0.0  # circulatory coupling (1/s^2)

    def eigenvalues(self) -> Complexes:
        """Its four eigenvalues."""
        signs = np.array([1j, -1j])
        half, rest = 0.5 * (self.c - signs * self.g), self.k - signs * self.f
        root = np.sqrt(half**2 - rest + 0j)
        larger = -half - np.where((half.conj() * root).real >= 0, root, -root)
        return np.concatenate([larger, rest / larger])  # no difference of what is nearly equal


def _matrices(blocks: Sequence[Block]) -> dict[str, Floats]:
    """M, C and K of blocks, shape (2 n, 2 n)."""
    one, turn = np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]])
    return {
        "M": np.eye(2 * len(blocks)),
        "C": block_diag(*(b.c * one + b.g * turn for b in blocks)),
        "K": block_diag(*(b.k * one + b.f * turn for b in blocks)),
    }


def _transformed(matrices: Mapping[str, Floats], change: Floats) -> dict[str, Floats]:
    """The same system in other unknowns: T^T A T, what is symmetric so to the last bit."""
    changed = {}
    for name, matrix in matrices.items():
        product = change.T @ matrix @ change
        symmetric = (matrix == matrix.T).all()
        changed[name] = 0.5 * (product + product.T) if symmetric else product
    return changed


def _upper(blocks: Sequence[Block]) -> Complexes:
    """Eigenvalues of blocks with Im lambda >= 0."""
    values = np.concatenate([block.eigenvalues() for block in blocks])
    return values[values.imag >= 0]


_STIFFNESSES = np.linspace(1.0, 60.0, 12)
_PLAIN = tuple(Block(k) for k in _STIFFNESSES)
_UNDAMPED = tuple(Block(k, f=0.3 if 4 < k < 12 else 0.0) for k in _STIFFNESSES)
"""Some of them flutter."""
_DAMPED = tuple(replace(block, c=0.02, g=0.1) for block in _UNDAMPED)
_N = 2 * len(_DAMPED)


def _mixing(n: int, seed: int, size: float) -> Floats:
    return np.eye(n) + size * np.random.default_rng(seed).standard_normal((n, n)) / np.sqrt(n)


_MIXED = _mixing(_N, 5, 0.4)


def _run(row: str, true: Any, matrices: Mapping[str, Floats], **fields: Any) -> Run:
    """Matrices in files beside eigenvalues of blocks, or given ones; None: they are refused."""
    given: dict[str, Any] = {"lowest": 12, "warnings": (), "expected": "accurate"} | fields
    if true is None:
        given |= {"expected": "refused", "names": "positive definite"}
    elif not isinstance(true, np.ndarray):
        true = _upper(true)
    reference = None if true is None else formula(true.tolist())
    may = EXPECTED[given.pop("expected")]
    return Run(row, ALONE[0], OfFiles(matrices), reference, may, **given)


def _units() -> Runs:
    """Scaling of unknowns and of time changes nothing."""
    mixed = _transformed(_matrices(_DAMPED), _MIXED)
    yield _run("damped, rotating, with friction", _DAMPED, mixed)
    undamped = _transformed(_matrices(_PLAIN), _MIXED)
    yield _run("neither damped nor rotating", _PLAIN, undamped)
    for digits in (3, 6, 9, 12):
        scaled = _transformed(mixed, np.diag(np.geomspace(10.0**-digits, 10.0**digits, _N)))
        yield _run(f"units of unknowns 1e-{digits} to 1e{digits}", _DAMPED, scaled)
    for time in (1e-9, 1e-4, 1e4, 1e9):
        faster = tuple(Block(b.k / time**2, b.c / time, b.g / time, b.f / time**2) for b in _DAMPED)
        matrices = {"M": mixed["M"], "C": mixed["C"] / time, "K": mixed["K"] / time**2}
        yield _run(f"unit of time {time:.0e} s", faster, matrices)


def _masses() -> Runs:
    """A mass next to nothing is a mode far beyond the window; a singular one is refused."""
    for mass in (1e-3, 1e-6, 1e-9, 1e-12):
        blocks = (*_DAMPED, Block(5.0 / mass))
        matrices = _matrices(blocks)
        for name in ("M", "K"):
            matrices[name][-2:, -2:] *= mass
        change = np.eye(_N + 2)
        change[:_N, :_N] = _MIXED
        change[-2:, :_N] = 0.1
        yield _run(f"masses of {mass:.0e} beside 1", blocks, _transformed(matrices, change))
    for number in (1, 5):
        matrices = _matrices(_DAMPED)
        matrices["M"][:number, :number] = 0.0
        yield _run(f"{number} unknowns without mass", None, matrices)
        yield _run(f"{number} motions without mass", None, _transformed(matrices, _MIXED))


def _clusters() -> Runs:
    """Copies, and Jordan blocks, whose members have the square root of rounding."""
    equal = (Block(4.0, c=0.02, f=0.1),) * 10 + (Block(9.0, c=0.02),) * 10 + _DAMPED
    matrices = _matrices(equal)
    mixed = _transformed(matrices, _mixing(2 * len(equal), 6, 0.3))
    yield _run("10 copies of two, as they are", equal, matrices, lowest=45)
    yield _run("10 copies of two, mixed", equal, mixed, lowest=45)
    for coupling in (1.0, 1e-6):
        blocks = (Block(4.0, c=0.02), *_DAMPED)
        jordan = _matrices(blocks)
        jordan["K"][0, 1] += coupling
        row = f"a Jordan block, coupling {coupling:.0e}"
        yield _run(row, blocks, jordan, expected="warned")


def _rounding() -> Runs:
    symmetric = tuple(Block(block.k, block.c) for block in _DAMPED)
    for row, blocks, warnings in (
        ("unsymmetric by friction and by rounding", _DAMPED, ()),
        ("symmetric but for rounding", symmetric, ("symmetrised",)),
    ):
        rounded = _transformed(_matrices(blocks), _MIXED)
        rounded["K"] = rounded["K"] * (1 + 2e-16 * np.sign(np.tri(_N) - 0.5))
        yield _run(row, blocks, rounded, warnings=warnings)


def matrices_from_files() -> Runs:
    """Matrices from files in all units, and near to what has no answer."""
    for part in (_units, _masses, _clusters, _rounding):
        yield from part()


def graded() -> Runs:
    """Matrices whose unknowns and equations are scaled far apart."""
    random = np.random.default_rng(11)
    turn: Floats = qr(random.standard_normal((_N, _N)))[0]
    steps = [random.permutation(np.linspace(-1.0, 1.0, _N)) for _ in range(2)]
    for name, blocks in (("undamped", _UNDAMPED), ("damped, rotating", _DAMPED)):
        plain = _transformed(_matrices(blocks), turn.T) | {"M": np.eye(_N)}
        for digits in (2, 4, 6, 9, 12):
            # Scaling rows and columns changes no eigenvalue; powers of two round nothing.
            one, other = (2.0 ** np.round(digits * np.log2(10.0) * each) for each in steps)
            for words, right in (("D K D^-1", 1 / one), ("D1 K D2", other)):
                scaled = {key: one[:, None] * matrix * right for key, matrix in plain.items()}
                yield _run(f"{words}, {name}, 1e-{digits} to 1e{digits}", blocks, scaled)
    half, shear = _N // 2, np.zeros((_N, _N))
    shear[:half, half:] = turn[:half, half:]
    for size in (1e1, 1e3, 1e5, 1e7):  # a similarity that no scaling undoes
        there, back = np.eye(_N) + size * shear, np.eye(_N) - size * shear
        K = turn.T @ (there @ _matrices(_UNDAMPED)["K"] @ back) @ turn
        sheared = {"M": np.eye(_N), "K": K}
        yield _run(f"sheared by {size:.0e}, turned", _UNDAMPED, sheared, expected="honest")


def exceptional_point() -> Runs:
    """Hoffmann's model at 1e-2 to 1e-14 from its coalescence."""
    # Beyond mu_c (1 + d) it grows by about sqrt(d); below it does not grow.
    k11, k12, k22, k3 = 2.5, 0.5, 2.0, 4 / 3
    critical = ((k11 - k22) ** 2 + 4 * k12**2) / (4 * k12 * k3)
    others = np.linspace(0.6, 4.0, 6)  # kappa of unknowns that are coupled to nothing
    for side, word in ((1.0, "beyond"), (-1.0, "before")):
        for distance in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14):
            # kappa = 2.25 -+ sqrt(-d (k11 - k22)^2 / 4 - d k12^2)
            split = -side * distance * ((k11 - k22) ** 2 / 4 + k12**2)
            root, middle = np.sqrt(complex(split)), 0.5 * (k11 + k22)
            true = lambdas(np.array([middle - root, middle + root, *others]))
            K = block_diag([[k11, k12], [k12, k22]], np.diag(others))
            K[0, 1] -= critical * (1 + side * distance) * k3
            expected, row = "accurate" if distance > 1e-6 else "warned", f"{distance:.0e}"
            matrices = {"M": np.eye(len(K)), "K": K}
            yield _run(f"{word} it by {row}", true, matrices, expected=expected, lowest=7)


def multiplicities() -> Runs:
    """Eigenvalues 2 to 30 times in given matrices."""
    beyond = np.linspace(20.0, 1e4, 60)  # kappa beyond the window
    for number in (2, 5, 13, 30):
        for word, mu in {"stable": 0.0, "fluttering": 0.3, "diverging": 2.0}.items():
            block = np.array([[1.0, -mu], [mu if word == "fluttering" else -mu, 1.1]])
            kappas = np.linalg.eigvals(block)
            K = block_diag(*[block] * number, np.diag(beyond))
            turn: Floats = qr(np.random.default_rng(1).standard_normal(K.shape))[0]
            true = lambdas(np.concatenate([np.repeat(kappas, number), beyond]))
            turned = {"M": np.eye(len(K))} | _transformed({"K": K}, turn)
            yield _run(f"{number} copies, {word}", true, turned, lowest=2 * number)
