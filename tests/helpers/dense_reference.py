"""Dense eigenvalues of an assembled pencil, with what rounding leaves open of each.

Eigenvalues near a shift come from the inverse of the assembled matrices there, refined in extended
precision: that keeps small eigenvalues however stiff the contact is. Those far from it come from
the matrices as they stand, contact forces eliminated. LAPACK does the rest: nothing is shared with
the driver that is judged.
"""

from dataclasses import dataclass

import numpy as np
from petsc_matrices import to_numpy
from scipy.linalg import (
    LinAlgError,
    cho_factor,
    cho_solve,
    cholesky,
    eig,
    eigh,
    null_space,
    solve_triangular,
    svd,
)

_EPS = np.finfo(float).eps
_SHIFTS = (-0.31, -0.83, -0.057, -3.1, -0.0071)
"""Shifts that are tried, relative to the upper end of the window."""
_STEPS = 4
"""Most steps of refinement."""


class UnsureError(Exception):
    """The dense reference cannot tell the eigenvalues."""


@dataclass(frozen=True)
class Dense:
    """All finite eigenvalues kappa = -lambda^2 of K x = kappa M x (1/s^2), shape (n,)."""

    kappa: np.ndarray
    error: np.ndarray  # what rounding moves each by, in LAPACK and in entries of the matrices
    symmetric: bool  # there is no friction: eigenvalues are real


def lambda_of(kappa):
    """Lambda = sqrt(-kappa) with Im lambda >= 0."""
    values = np.sqrt(-np.asarray(kappa, dtype=complex))
    return np.where(values.imag < 0, -values, values) + 0j


def lambda_error(kappa, error):
    """Error of lambda from one of kappa = -lambda^2."""
    size = np.sqrt(np.abs(kappa))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(error < np.abs(kappa), error / (2 * size), np.sqrt(error))


@dataclass(frozen=True)
class _Problem:
    """K x + L^T f = kappa M x, J x = C f, where each displacement has the mass 1 on the diagonal.

    Forces without compliance come first. Sums that the pencil does not make are made in extended
    precision.
    """

    K: np.ndarray
    M: np.ndarray
    J: np.ndarray
    L: np.ndarray
    C: np.ndarray
    root: np.ndarray  # M = root root^T
    tied: int  # forces without compliance
    symmetric: bool


def dense_eigenvalues(matrices, top: float) -> Dense:
    """Dense eigenvalues of matrices on one rank, those about as large as ``top`` the best.

    ``UnsureError`` is raised where rounding leaves too little of them.
    """
    problem = _problem(matrices)
    finite = len(problem.K) - problem.tied
    near, near_error, spread = _inverted(problem, top)
    far, far_error, size = _as_it_stands(problem)
    cut = _cut(np.abs(near), np.abs(far), np.sqrt(size * spread), finite)
    small, large = np.abs(near) < cut, np.abs(far) >= cut
    kappa = np.concatenate([near[small], far[large]])
    error = np.concatenate([near_error[small], far_error[large]])
    return Dense(kappa, error, problem.symmetric)


def _problem(matrices) -> _Problem:
    K, M = to_numpy(matrices.stiffness), to_numpy(matrices.mass)
    if matrices.unsymmetric is not None:
        K = K.astype(np.longdouble) + to_numpy(matrices.unsymmetric)
    scale = 2.0 ** np.round(-0.5 * np.log2(np.diag(M)))  # powers of two round nothing
    J, L, C, tied = _forces(matrices.multipliers, scale)
    M = M * np.outer(scale, scale)
    root = cholesky(M, lower=True)
    return _Problem(K * np.outer(scale, scale), M, J, L, C, root, tied, matrices.symmetric)


def _forces(multipliers, scale):
    """J, L and C, forces without compliance first, and how many these are."""
    if multipliers is None:
        nothing = np.zeros((0, len(scale)))
        return nothing, nothing, np.zeros((0, 0)), 0
    names = ("closure", "reaction", "compliance")
    J, L, C = (to_numpy(getattr(multipliers, name)) for name in names)
    J, L = J * scale, L * scale
    if multipliers.border is not None:
        J, L, C = _left_by(to_numpy(multipliers.border), J, L, C)
    yields = np.abs(C).max(axis=1, initial=0.0) > 0
    tied_J, tied_L = _independent(J[~yields], L[~yields])
    tied = len(tied_J)
    whole = np.zeros((tied + int(yields.sum()),) * 2)
    whole[tied:, tied:] = C[np.ix_(yields, yields)]
    return np.vstack([tied_J, J[yields]]), np.vstack([tied_L, L[yields]]), whole, tied


def _left_by(border, J, L, C):
    """Forces that a border leaves, those that it does not touch as they are."""
    touched = np.abs(border).max(axis=1) > 0
    free = null_space(border[touched].T)
    values, vectors = eigh(free.T @ C[np.ix_(touched, touched)] @ free)
    free = free @ vectors
    values = np.where(values > 1e-14 * np.abs(values).max(initial=0.0), values, 0.0)
    own = np.diag(values)
    across = (free.T @ C[np.ix_(touched, ~touched)]) * (values > 0)[:, None]
    return (
        np.vstack([free.T @ J[touched], J[~touched]]),
        np.vstack([free.T @ L[touched], L[~touched]]),
        np.block([[own, across], [across.T, C[np.ix_(~touched, ~touched)]]]),
    )


def _independent(J, L):
    """Ties without those that follow from others: the smallest forces carry the rest."""
    if not len(J):
        return J, L
    rows = np.linalg.norm(J, axis=1)
    rows = np.where(rows > 0, rows, 1.0)[:, None]
    u, s, v = svd(J / rows, full_matrices=False)
    kept = s > 1e-11 * s[0]
    if kept.all():
        return J, L
    return s[kept, None] * v[kept], u[:, kept].T @ (L / rows)


def _inverted(problem: _Problem, top: float):
    """Eigenvalues from the inverse at a shift, their errors, and how near the shift they reach."""
    n, best, chosen = len(problem.K), np.inf, None
    for part in _SHIFTS:
        matrix, scale = _bordered(problem, part * top)
        try:
            rough = np.linalg.inv(matrix.astype(float))
            size = np.linalg.norm(rough[:n, :n] @ problem.M, 2) * abs(part)
        except LinAlgError:
            continue
        if size < best:
            best, chosen = size, (part * top, matrix, scale, rough)
    if chosen is None:
        raise UnsureError("every shift is an eigenvalue")
    shift, matrix, scale, rough = chosen
    inverse, change = _refined(matrix, rough)
    x, f, g = inverse[:n, :n], scale * inverse[n:, :n], scale * inverse[:n, n:].T
    T = problem.root.T @ x @ problem.root
    norm = np.linalg.norm(T, 2)
    theta, left, right = eig(T, left=True, right=True)
    kept = np.abs(theta) > _noise(len(T)) * norm
    theta, left, right = theta[kept], left[:, kept], right[:, kept]
    kappa = shift + 1 / theta
    overlap = np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), _EPS)
    right, left, size = problem.root @ right, problem.root @ left, np.abs(theta)
    own = change[:n, :n] + _EPS * np.abs(rough[:n, :n])
    error = 4 * np.sqrt(n) * _EPS * norm
    error = error + np.einsum("in,ij,jn->n", np.abs(left), own, np.abs(right), optimize=True)
    displacements = np.abs(x.T @ left / size), np.abs(x @ right / size)
    forces = np.abs(g @ left / size), np.abs(f @ right / size)
    entries = _entries(problem, *displacements, *forces, np.abs(kappa))
    return kappa, (error / size**2 + 4 * _EPS * entries) / overlap, 1 / norm


def _bordered(problem: _Problem, shift: float):
    """[K - s M, L^T; J, -C] at a shift s, rows and columns of forces scaled, and their scales."""
    rows = np.abs(problem.J).max(axis=1, initial=0.0)
    size = float(np.abs(problem.K).max())
    scale = 2.0 ** np.round(np.log2(size / np.where(rows > 0, rows, 1.0)))[:, None]
    stiffness = problem.K - np.longdouble(shift) * problem.M
    low = np.hstack([problem.J * scale, -problem.C * (scale * scale.T)])
    return np.vstack([np.hstack([stiffness, (problem.L * scale).T]), low]), scale


def _refined(matrix, rough):
    """The inverse of a matrix of extended precision, and the last correction of it."""
    inverse, before = rough.astype(np.longdouble), np.inf
    for _ in range(_STEPS):
        change = rough @ (np.eye(len(matrix)) - matrix @ inverse).astype(float)
        size = np.abs(change).max()
        if not size < 0.5 * before:
            break
        inverse, before = inverse + change, size
        if size < _EPS * np.abs(inverse).max():
            break
    return inverse.astype(float), np.abs(change)


def _entries(p: _Problem, y, x, g, f, kappa):
    """|(y, g)^T matrix (x, f)| with absolute values throughout, column by column."""
    total = np.sum(y * (np.abs(p.K).astype(float) @ x + kappa * (np.abs(p.M) @ x)), axis=0)
    total += np.sum((np.abs(p.L) @ y) * f + (np.abs(p.J) @ x) * g, axis=0)
    return total + np.sum(g * (np.abs(p.C) @ f), axis=0)


def _as_it_stands(problem: _Problem):
    """Eigenvalues with contact forces eliminated, their errors, and the norm of the matrix."""
    r = problem.tied
    yielding = problem.C[r:, r:]
    size = 1 / np.sqrt(np.diag(yielding))
    try:
        factor = cho_factor(yielding * np.outer(size, size))
    except LinAlgError as error:
        raise UnsureError("a compliance that is not positive definite") from error
    forces = size[:, None] * cho_solve(factor, size[:, None] * problem.J[r:])
    K = problem.K + problem.L[r:].T @ forces
    half = solve_triangular(problem.root, K.astype(float), lower=True)
    A = solve_triangular(problem.root, half.T, lower=True).T
    worse = 1.0
    if r:
        Z, W = (
            svd(solve_triangular(problem.root, each[:r].T, lower=True).T)[2][r:].T
            for each in (problem.J, problem.L)
        )
        both = W.T @ Z
        worse = np.linalg.cond(both)
        if worse > 1e10:
            raise UnsureError("friction jams the ties")
        A = np.linalg.solve(both, W.T @ A @ Z)
    kappa, left, right = eig(A, left=True, right=True)
    norm = np.linalg.norm(A, 2)
    kept = np.abs(kappa) > _noise(len(A)) * worse * norm
    overlap = np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), _EPS)
    error = 4 * np.sqrt(len(A)) * _EPS * norm * worse / overlap
    return kappa[kept], error[kept], norm


def _noise(n):
    """Part of the norm of a matrix below which its eigenvalues are rounding."""
    return 100 * np.sqrt(n) * _EPS


def _cut(near, far, middle, finite):
    """Modulus that parts the eigenvalues, with as many on both sides as there are in all."""
    near, far = np.sort(near), np.sort(far)
    gaps = []
    for below in range(max(1, finite - len(far)), min(len(near), finite - 1) + 1):
        above = finite - below
        low = max(near[below - 1], far[-above - 1] if above < len(far) else 0.0)
        high = min(near[below] if below < len(near) else np.inf, far[-above])
        low = max(low, 1e-300)
        if low * (1 + 1e-9) < high:
            between = np.sqrt(low) * np.sqrt(min(high, 1e300))
            gaps.append((abs(np.log(between / middle)), between))
    if not gaps and len(near) >= finite:
        return np.inf
    if not gaps:
        raise UnsureError("no modulus parts the eigenvalues of both problems alike")
    return min(gaps)[1]


def dense_linear(M, K) -> Dense:
    """All eigenvalues kappa of K x = kappa M x, of dense matrices that are scaled well."""
    return Dense(*_eigenvalues(_reduced(M, K), np.linalg.cond(M)), symmetric=False)


def dense_quadratic(M, D, K, scale) -> tuple[np.ndarray, np.ndarray]:
    """All eigenvalues lambda of lambda^2 M + lambda D + K, accurate about a scale, and errors."""
    n = len(M)
    low = [-_reduced(M, K) / scale**2, -_reduced(M, D) / scale]
    A = np.block([[np.zeros((n, n)), np.eye(n)], low])
    values, error = _eigenvalues(A, np.linalg.cond(M))
    return values * scale, error * scale


def _reduced(M, A):
    """L^-1 A L^-T with M = L L^T."""
    root = cholesky(M, lower=True)
    half = solve_triangular(root, A, lower=True)
    return solve_triangular(root, half.T, lower=True).T


def _eigenvalues(A, spread):
    """Eigenvalues of a dense matrix, and what rounding may move each by."""
    values, left, right = eig(A, left=True, right=True)
    overlap = np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), _EPS)
    return values, 4 * np.sqrt(len(A)) * _EPS * np.linalg.norm(A, 2) * spread / overlap
