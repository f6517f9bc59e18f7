"""Modes of damped pencils judged by dense eigenvalues of the companion form, scaled.

All eigenvalues are compared, conjugates too. Those closer to each other than their errors are one
group, and groups are compared by their numbers.
"""

import numpy as np
from judge import Fault
from scipy.linalg import cholesky, eig, solve_triangular
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

_EPS = np.finfo(float).eps
_SAFETY = 10.0
"""Factor on errors, which are estimates of first order."""


def dense_quadratic(M, D, K, scale) -> tuple[np.ndarray, np.ndarray]:
    """All eigenvalues lambda of lambda^2 M + lambda D + K, and their errors.

    Parameters
    ----------
    M, D, K
        Dense matrices.
    scale
        Where eigenvalues are to be accurate (1/s).
    """
    root = cholesky(M, lower=True)
    n = len(M)

    def reduced(matrix):
        half = solve_triangular(root, matrix, lower=True)
        return solve_triangular(root, half.T, lower=True).T

    A = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [-reduced(K) / scale**2, -reduced(D) / scale],
        ]
    )
    values, left, right = eig(A, left=True, right=True)
    overlap = np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), _EPS)
    spread = np.linalg.cond(M)
    error = 4 * np.sqrt(2 * n) * _EPS * np.linalg.norm(A, 2) * spread / overlap
    return values * scale, error * scale


def judge_quadratic(modes, values, errors) -> list[Fault]:
    """Faults of modes, given all eigenvalues there are and their errors."""
    window, found = modes.window, modes.eigenvalues
    top = 2 * np.pi * window.max_frequency
    twins = found.imag > 0
    ours = np.append(found, found[twins].conj())
    reach = _SAFETY * np.append(modes.growth_uncertainties, modes.growth_uncertainties[twins])
    calls = np.array(modes.verdicts(), dtype=object)
    calls = np.append(calls, calls[twins])
    margin = _SAFETY * errors
    limit = 1e-4 * np.abs(values)
    surely = (
        (np.abs(values.imag) < top - margin)
        & (values.real > window.min_growth + margin)
        & (values.real < window.max_growth - margin)
    )
    if window.odd:
        surely &= np.abs(values.imag) > margin
    possibly = (np.abs(values.imag) < top + margin) & (values.real > window.min_growth - margin)
    grows, may_grow = values.real > limit + margin, values.real > limit - margin
    faults = []
    for mine, theirs in _groups(ours, reach, values, margin, top):
        place = f"{(values[theirs] if len(theirs) else ours[mine])[0]:.8g}"
        called = calls[mine]
        if len(mine) < surely[theirs].sum():
            faults.append(Fault("missing", f"{surely[theirs].sum()} at {place}, {len(mine)} found"))
        if (called != "undecided").sum() > possibly[theirs].sum():
            faults.append(
                Fault("spurious", f"{possibly[theirs].sum()} at {place}, {len(mine)} found")
            )
        if (called == "stable").sum() > (~grows & possibly)[theirs].sum() and len(theirs):
            faults.append(Fault("wrong-verdict", f"{place} is called stable and grows"))
        if (called == "unstable").sum() > may_grow[theirs].sum() and len(theirs):
            faults.append(Fault("wrong-verdict", f"{place} is called unstable and does not grow"))
    inside, near = np.abs(values.imag) < top - margin, np.abs(values.imag) < top + margin
    if modes.verdict() == "stable" and (grows & inside).any():
        faults.append(Fault("wrong-verdict", "the window is called stable and a mode grows"))
    if modes.verdict() == "unstable" and not (may_grow & near).any():
        faults.append(Fault("wrong-verdict", "the window is called unstable and nothing grows"))
    return faults


def _groups(ours, reach, values, margin, top):
    """Numbers of found and of dense values that lie within each other's errors."""
    every = np.append(ours, values)
    radius = np.append(reach, margin) + 1e-9 * np.maximum(np.abs(every), 1e-2 * top)
    near = np.abs(every[:, None] - every) <= radius[:, None] + radius
    count, label = connected_components(csr_array(near), directed=False)
    n = len(ours)
    for one in range(count):
        members = np.flatnonzero(label == one)
        yield members[members < n], members[members >= n] - n
