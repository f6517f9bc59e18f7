"""Cases of matrices from files."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, qr

from cea.arrays import Complexes, Floats
from comparisons.stability.case import EXPECTED, Run, Runs, formula
from comparisons.stability.dense import lambdas
from comparisons.stability.problems import WRITERS, of_files
from comparisons.stability.ways import ALONE

Blocks = tuple[NDArray[Any], NDArray[Any]]
"""d (1/s) and s (1/s^2), shape (n,), of lambda^2 + d lambda + s = 0 and of its conjugate.

Each is a block of two unknowns: Re d is damping, -Im d gyroscopic coupling, Re s stiffness, -Im s
circulatory coupling.
"""


def _eigenvalues(blocks: Blocks) -> Complexes:
    """Eigenvalues of blocks with Im lambda >= 0."""
    d, s = (np.concatenate([values, values.conj()]) + 0j for values in blocks)
    root = np.sqrt(d**2 / 4 - s)
    larger = -d / 2 - np.where((d.conj() * root).real >= 0, root, -root)
    values = np.concatenate([larger, s / larger])  # avoids cancellation
    return values[values.imag >= 0]


def _matrices(blocks: Blocks) -> dict[str, Floats]:
    """M, C and K of blocks, shape (2 n, 2 n)."""
    C, K = (block_diag(*([[z.real, -z.imag], [z.imag, z.real]] for z in each)) for each in blocks)
    return {"M": np.eye(len(C)), "C": C, "K": K}


def _transformed(matrices: Mapping[str, Floats], change: Floats) -> dict[str, Floats]:
    """The same system in other unknowns, T^T A T; symmetric matrices stay exactly symmetric."""
    changed = {}
    for name, matrix in matrices.items():
        product = change.T @ matrix @ change
        symmetric = (matrix == matrix.T).all()
        changed[name] = 0.5 * (product + product.T) if symmetric else product
    return changed


_N = 24
_K = np.linspace(1.0, 60.0, _N // 2)
_F, _D = _K - 0.3j * ((_K > 4) & (_K < 12)), np.full(_N // 2, 0.02 - 0.1j)
_PLAIN, _UNDAMPED, _DAMPED = (0 * _D, _K), (0 * _D, _F), (_D, _F)
"""Blocks without damping, of which some flutter, and which are damped and rotate too."""


def _mixing(n: int, seed: int, size: float) -> Floats:
    return np.eye(n) + size * np.random.default_rng(seed).standard_normal((n, n)) / np.sqrt(n)


_MIXED = _mixing(_N, 5, 0.4)


def _mixed(blocks: Blocks) -> dict[str, Floats]:
    return _transformed(_matrices(blocks), _MIXED)


def _run(
    row: str, true: Any, matrices: Mapping[str, Floats], *, form: str = "npz", **fields: Any
) -> Run:
    """A run of matrices in files; ``true``: blocks, eigenvalues, or None if they are refused."""
    given: dict[str, Any] = {"lowest": 12, "warnings": (), "expected": "accurate"} | fields
    if true is None:
        given |= {"expected": "refused", "names": "positive definite"}
    values = _eigenvalues(true) if isinstance(true, tuple) else true
    reference, may = None if true is None else formula(values), EXPECTED[given.pop("expected")]
    return Run(row, ALONE[0], partial(of_files, matrices, form=form), reference, may, **given)


def _units() -> Runs:
    """Yield runs with other units of unknowns and of time."""
    mixed = _mixed(_DAMPED)
    for form in WRITERS:
        yield _run(f"damped, rotating, with friction: .{form}", _DAMPED, mixed, form=form)
    yield _run("neither damped nor rotating", _PLAIN, _mixed(_PLAIN))
    for digits in (3, 6, 9, 12):
        scaled = _transformed(mixed, np.diag(np.geomspace(10.0**-digits, 10.0**digits, _N)))
        yield _run(f"units of unknowns 1e-{digits} to 1e{digits}", _DAMPED, scaled)
    for time in (1e-9, 1e-4, 1e4, 1e9):
        faster = mixed | {"C": mixed["C"] / time, "K": mixed["K"] / time**2}
        yield _run(f"unit of time {time:.0e} s", (_D / time, _F / time**2), faster)


def _masses() -> Runs:
    """Yield runs with tiny masses, whose modes are far beyond the window, and singular ones."""
    for mass in (1e-3, 1e-6, 1e-9, 1e-12):
        blocks = np.append(_D, 0), np.append(_F, 5.0 / mass)
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
    """Yield runs with multiple eigenvalues and Jordan blocks, with errors of sqrt(rounding)."""
    equal = np.append([0.02] * 20, _D), np.append([4.0 - 0.1j] * 10 + [9.0] * 10, _F)
    matrices = _matrices(equal)
    mixed = _transformed(matrices, _mixing(len(matrices["M"]), 6, 0.3))
    yield _run("10 copies of two, as they are", equal, matrices, lowest=45)
    yield _run("10 copies of two, mixed", equal, mixed, lowest=45)
    for coupling in (1.0, 1e-6):
        blocks = np.append(0.02, _D), np.append(4.0, _F)
        jordan = _matrices(blocks)
        jordan["K"][0, 1] += coupling
        row = f"a Jordan block, coupling {coupling:.0e}"
        yield _run(row, blocks, jordan, expected="warned")


def _rounding() -> Runs:
    for row, blocks in (
        ("unsymmetric by friction and by rounding", _DAMPED),
        ("symmetric but for rounding", (_D.real, _K)),
    ):
        rounded = _mixed(blocks)
        rounded["K"] *= 1 + 2e-16 * np.sign(np.tri(_N) - 0.5)
        yield _run(row, blocks, rounded)


def matrices_from_files() -> Runs:
    """Matrices from files: units, tiny and singular masses, multiple eigenvalues, rounding."""
    for part in (_units, _masses, _clusters, _rounding):
        yield from part()


def graded() -> Runs:
    """Badly scaled matrices: graded unknowns and equations."""
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
    """Eigenvalues of multiplicity 2 to 30 in given matrices."""
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
