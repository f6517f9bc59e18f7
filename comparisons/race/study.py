"""Seconds for all modes of a window, beside runs of shift-and-invert by scipy in the same process.

What a person would do without this program: five shifts along the imaginary axis of the window, at
each the eigenvalues nearest to it by ARPACK and SuperLU in complex arithmetic, with no word on what
lies between them. Two ways: the companion form given to ``eigs`` as it is, 2 n unknowns; and the
same with the systems reduced to Q(sigma) = sigma^2 M + sigma C + K by hand, n unknowns.
"""

from collections.abc import Callable, Mapping
from time import perf_counter, process_time
from typing import Any

import numpy as np
from scipy.sparse import block_array, csc_array, eye_array
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs, splu

from cea.arrays import Complexes
from cea.errors import InputError
from cea.petsc import MPI
from scenes import Result
from scenes.results.record import record
from scenes.running.matrices import AssembledMatrices
from scenes.spec.matrices import MatrixScene

COMMAND = "race"
SHIFTS = 5
"""Runs of scipy."""
WANTED = 20
"""Eigenvalues of each."""
_SAME = 1e-6
"""Relative distance of eigenvalues that are the same."""

Matrices = Mapping[str, Any]
"""M, C and K, scipy."""


def race(
    scene: MatrixScene,
    inputs: Mapping[str, Any],
    *,
    repeats: int = 3,
    progress: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Time a scene and runs of scipy by turns.

    Parameters
    ----------
    scene
        A scene of matrices with damping.
    inputs
        What it was asked for in words.
    repeats
        Times that each is run; the median counts.
    progress
        Called with what begins.

    Returns
    -------
    dict
        The record: ``entrants``, each with ``name``, ``seconds`` and ``processor`` of every
        repeat, ``found``, how many of our modes it found, and ``modes``, how many there are.

    Raises
    ------
    InputError
        On several ranks, or without damping.
    """
    if MPI.COMM_WORLD.size > 1:
        raise InputError("ranks", MPI.COMM_WORLD.size, "1: scipy runs on one")
    if repeats < 1:
        raise InputError("repeats", repeats, "1 or more")
    if not scene.damping:
        raise InputError("damping", {}, "one matrix or more: the race is one of quadratic problems")
    begun = perf_counter()
    assembled = AssembledMatrices(scene)
    first = assembled.modes()
    matrices = first.matrices()
    runs: dict[str, Callable[[], Complexes]] = {
        "cea, the whole window": lambda: assembled.modes().eigenvalues,
        f"scipy, {SHIFTS} shifts, Q(sigma) factorised": lambda: _by_scipy(reduced, matrices, scene),
        f"scipy, {SHIFTS} shifts, companion form": lambda: _by_scipy(companion, matrices, scene),
    }
    taken: dict[str, list[tuple[float, float]]] = {name: [] for name in runs}
    found = dict.fromkeys(runs, 0)
    for _ in range(repeats):
        for name, run in runs.items():
            progress(name)
            assembled.free()
            start, worked = perf_counter(), process_time()
            values = run()
            taken[name].append((perf_counter() - start, process_time() - worked))
            found[name] = _common(first, values)
    assembled.free()
    entrants = [
        {
            "name": name,
            "seconds": [clock for clock, _ in times],
            "processor": [processor for _, processor in times],
            "found": found[name],
        }
        for name, times in taken.items()
    ]
    data = {"scene": scene.name, "modes": len(first.modes), "entrants": entrants}
    seconds, warnings = perf_counter() - begun, [w.plain() for w in first.warnings]
    return record(COMMAND, data, inputs=inputs, seconds=seconds, warnings=warnings)


def _common(first: Result, values: Complexes) -> int:
    """How many modes of a result are among some eigenvalues."""
    apart = np.abs(first.eigenvalues[:, None] - values)
    return int((apart.min(axis=1) <= _SAME * np.abs(first.eigenvalues)).sum())


def _by_scipy(
    way: Callable[[Matrices, complex], Complexes], matrices: Matrices, scene: MatrixScene
) -> Complexes:
    """Eigenvalues nearest to shifts in the middle of equal parts of the window."""
    top = 2 * np.pi * scene.window.max_frequency
    shifts = 1j * top * (np.arange(SHIFTS) + 0.5) / SHIFTS
    found = []
    for shift in shifts:
        try:
            found.append(way(matrices, shift))
        except ArpackError as error:
            found.append(np.asarray(getattr(error, "eigenvalues", []), dtype=complex))
    return np.concatenate(found)


def companion(matrices: Matrices, shift: complex) -> Complexes:
    """Eigenvalues nearest to a shift by the companion form, as it is."""
    M, C, K = (matrices[name] for name in "MCK")
    one = eye_array(M.shape[0], format="csc")
    # Complex matrices: of real ones ARPACK iterates with the real part of the inverse alone.
    left = block_array([[None, one], [-K, -C]], format="csc", dtype=complex)
    right = block_array([[one, None], [None, M]], format="csc", dtype=complex)
    return eigs(left, WANTED, M=right, sigma=shift, return_eigenvectors=False)


def reduced(matrices: Matrices, shift: complex) -> Complexes:
    """Eigenvalues nearest to a shift by the companion form, its systems reduced to Q(shift)."""
    M, C, K = (matrices[name] for name in "MCK")
    n = M.shape[0]
    factors, rest = splu(csc_array(shift**2 * M + shift * C + K)), csc_array(shift * M + C)

    def inverse(z: Complexes) -> Complexes:
        x, velocity = z[:n], z[n:]
        moved = factors.solve(-(M @ velocity + rest @ x))
        return np.concatenate([moved, x + shift * moved])

    operator = LinearOperator((2 * n, 2 * n), matvec=inverse, dtype=complex)
    return shift + 1 / eigs(operator, WANTED, return_eigenvectors=False)
