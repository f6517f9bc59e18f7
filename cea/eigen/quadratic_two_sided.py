"""Errors of damped and rotating eigenvalues by their left vectors, as :mod:`cea.eigen.two_sided`.

With a left vector y and r = P(lambda) x, lambda is in error by

    e / abs(y^H (2 lambda M + D) x),    e = abs(y)^T (abs(r) + u abs(P)(abs(lambda)) abs(x)),

but by no more than sqrt(e / abs(y^H M x)), where the two eigenvalues of a motion meet.
"""

from dataclasses import replace

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import column_blocks, columns_inner, times
from cea.eigen.eigenpairs import internal_forces
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_damping import Damping
from cea.eigen.quadratic_pairs import QuadraticPairs, QuadraticSizes
from cea.eigen.sensitivity import LeftVectors
from cea.eigen.shifted import Shifted
from cea.eigen.subspace import InvariantSubspace
from cea.eigen.two_sided import (
    COLUMNS,
    ILL,
    MORE,
    PLAIN,
    bounds_widened,
    cancels,
    disagreement,
)

_ROUGH = 1e-11
"""Backward error of the entries up to which eigenvectors are as good as rounding lets them be."""


def one_sided(
    matrices: Matrices,
    factors: Shifted,
    subspace: InvariantSubspace,
    pairs: QuadraticPairs,
    scale: float,
) -> bool:
    """Whether the right vectors say too little of the errors of eigenvalues; collective.

    Parameters
    ----------
    matrices, factors
        The pencil at given parameters, factorised.
    subspace, pairs
        Invariant subspace of the companion form, and the eigenpairs of that.
    scale
        Its gamma (1/s).
    """
    if not subspace.size:
        return False
    ill = subspace.graded or pairs.conditions.max() > ILL or pairs.residuals.max() > _ROUGH
    if ill or cancels(matrices.mass, pairs.vectors):
        return True
    return _left_out(matrices, factors, subspace, scale) > PLAIN


def _left_out(
    matrices: Matrices, factors: Shifted, subspace: InvariantSubspace, scale: float
) -> float:
    """How much a subspace leaves out of the z of its left vectors, which are y: an estimate.

    With the adjoint OP* of the companion form's OP, and OP Q = Q T, it is Q - OP* Q T^-H.
    """
    random = np.random.default_rng(3).standard_normal((2, subspace.size, COLUMNS))
    mixed = (random[0] + 1j * random[1]) / np.sqrt(2)
    # Of what is far from the shift a step of inverse iteration leaves rounding.
    far = np.abs(np.diag(subspace.projected) - factors.rate) / abs(factors.rate)
    mixed /= np.maximum(1.0, far)[:, None]
    turned = subspace.projected.conj().T @ mixed - np.conj(factors.rate) * mixed
    rows = len(subspace.basis) // 2
    whole = subspace.basis @ turned
    load = times(matrices.mass, whole[:rows] + np.conj(factors.rate) / scale * whole[rows:])
    w = factors.solve_with_forces(load.conj(), transposed=True)[0].conj()
    rest = subspace.basis[rows:] @ mixed + scale * w
    squares = columns_inner(rest, times(matrices.mass, rest), matrices.mass.comm).real
    return float(np.sqrt(squares.sum() / COLUMNS))


def two_sided_errors(
    matrices: Matrices, pairs: QuadraticPairs, left: LeftVectors
) -> tuple[Floats, Floats]:
    """Errors of eigenvalues (1/s), and lengths (s) of left vectors, y^H (2 lambda M + D) x = 1.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    pairs, left
        Eigenpairs and their left vectors.
    """
    comm, mass, values = matrices.stiffness.comm, matrices.mass, pairs.eigenvalues
    errors, slopes = np.empty((2, len(values)))
    damping = Damping(matrices)
    sizes = QuadraticSizes(matrices, damping)
    for block in column_blocks(len(values)):
        value, x, y = values[block], pairs.vectors[:, block], left.vectors[:, block]
        f = pairs.forces[:, block]
        inertia, drag = times(mass, x), damping.times(x)
        defect = internal_forces(matrices, x, f) + value**2 * inertia + value * drag
        parts = np.abs(defect) + np.finfo(float).eps * sizes.forces(value, x, f)
        work = comm.tompi4py().allreduce(np.einsum("ij,ij->j", np.abs(y), parts))
        turned = np.abs(columns_inner(y, 2 * value * inertia + drag, comm))
        length = np.sqrt(columns_inner(y, times(mass, y), comm).real)
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(work / np.abs(columns_inner(y, inertia, comm)))
            errors[block] = np.fmin(work / turned, root)
            slopes[block] = length / turned
    sizes.free()
    damping.free()
    errors[np.isnan(errors)] = np.inf
    return errors, slopes


def judged_by_both(
    matrices: Matrices,
    subspace: InvariantSubspace,
    pairs: QuadraticPairs,
    left: tuple[Complexes, LeftVectors] | None,
    end: float,
) -> QuadraticPairs:
    """Eigenpairs whose errors are those by their left vectors, where these say much more.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    subspace
        Invariant subspace of the companion form that they are of.
    pairs
        Eigenpairs.
    left
        Eigenvalues of the transposed problem, in any order, and left vectors of the pairs; nothing
        is known of any error without.
    end
        omega of the end of the window (1/s).
    """
    values = pairs.eigenvalues
    if left is None:
        unknown = np.full(len(values), np.inf)
        return replace(pairs, errors=unknown, bounds=unknown)
    errors, slopes = two_sided_errors(matrices, pairs, left[1])
    known = np.maximum(np.nan_to_num(slopes, nan=0.0), pairs.slopes)
    far = np.maximum(1.0, np.abs(values) / end) ** 2
    apart = disagreement(values, left[0], known * far)
    errors = np.maximum(errors, np.minimum(apart * far * known, np.sqrt(apart * far)))
    errors, bounds = bounds_widened(subspace, values, errors, pairs.conditions)
    more = np.minimum(errors, bounds) > MORE * pairs.uncertainties
    return replace(
        pairs,
        slopes=np.where(more, known, pairs.slopes),
        errors=np.where(more, errors / known, pairs.errors),
        bounds=np.where(more, bounds, pairs.bounds),
    )
