"""Left eigenvectors of a pencil, and errors that right ones do not tell.

Of the left vectors the invariant subspace of the right ones knows no more than their projection.
What it leaves out comes of one step of inverse iteration with the transposed matrix; friction
between bodies makes it about as large as one. Where it is much larger, or conditions are bad, left
vectors are searched themselves. With the residual r and rounding u of all entries lambda is then in
error by

    e / abs(y^H (2 lambda M + D) x),    e = abs(y)^T (abs(r) + u abs(P) abs(x)),

to first order, however unknowns and equations are scaled, but by no more than
sqrt(e / abs(y^H M x)), where the two eigenvalues of a motion meet. That holds as far as y is right.
Left eigenvalues come of systems, start vectors and roundings of their own: by how much they and
right ones differ is what both searches have made of the matrices, a backward error that is counted
for every eigenvalue, times its condition.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import column_blocks, columns_inner, times
from cea.eigen.errors import Eigenpairs, residual
from cea.eigen.matching import DEGENERATE, assign, connected, group
from cea.eigen.pencil import Sizes
from cea.eigen.shift_invert import ShiftInvert
from cea.eigen.spectrum import SLOW
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError

SAME = 1e-4
"""Relative distance of left and right eigenvalues beyond which they are not the same."""
_ILL = 1e2
"""Condition number up to which one residual says enough of an eigenvalue."""
_PLAIN, _COLUMNS = 30.0, 4
"""What may be left out of left vectors for the subspace to say enough of them, by so many random
combinations of it."""
_ROUGH = 1e-11
"""Residual of a damped eigenpair up to which it is as good as rounding lets it be."""
_UNKNOWN = 1e300
"""Error in the place of an infinite one."""


@dataclass(frozen=True)
class LeftVectors:
    """Left eigenvectors y with y_i^H M x_j = delta_ij, or as damped pencils have them.

    There y_i^H ((lambda_i + lambda_j) M + D) x_j is 2 lambda_i for i = j, and zero otherwise.
    ``forces`` are their multipliers; both are the rows of this rank.
    """

    vectors: Complexes
    forces: Complexes

    def __getitem__(self, modes: Any) -> "LeftVectors":
        return LeftVectors(self.vectors[:, modes], self.forces[:, modes])


def needs_left_vectors(op: ShiftInvert, subspace: InvariantSubspace, pairs: Eigenpairs) -> bool:
    """Whether the right vectors say too little of the errors of eigenvalues; collective."""
    if op.symmetric or not len(pairs.values):
        return False
    rough = op.damped and pairs.residuals.max() > _ROUGH
    if subspace.graded or rough or pairs.conditions.max() > _ILL:
        return True
    mixed = np.random.default_rng(3).standard_normal((subspace.size, _COLUMNS))
    # Of what is far from the shift a step of inverse iteration leaves rounding.
    far = np.abs(np.diag(subspace.projected) - op.shift) / abs(op.shift)
    mixed /= np.maximum(1.0, far)[:, None]
    moved = subspace.projected.T @ mixed - op.shift * mixed
    rest = np.asfortranarray(op.left_out(subspace.basis, mixed, moved))
    squares = columns_inner(rest, times(op.matrices.mass, rest), op.matrices.mass.comm)
    return bool(np.sqrt(squares.sum() / _COLUMNS) > _PLAIN)


def left_vectors_of(
    op: ShiftInvert, pairs: Eigenpairs, left_values: Complexes, left: Complexes
) -> LeftVectors:
    """Left vectors of eigenpairs, in their order; where eigenvalues touch, a dual basis.

    They are of eigenvalues of the transposed pencil and their vectors, conjugates of left ones.
    ConvergenceError when an eigenvalue has no left vector.
    """
    values, x = pairs.values, pairs.vectors
    slow = SLOW * op.scale if op.damped else (SLOW * op.scale) ** 2  # rigid motions have no speed
    scale = np.abs(values).max(initial=slow)
    rows, columns = assign(np.abs(values[:, None] - left_values) / scale, SAME)
    if len(rows) < len(values):
        raise ConvergenceError(
            f"{len(values) - len(rows)} of {len(values)} eigenvalues have no left vector",
            best=left_values,
        )
    y = left[:, columns].conj()
    for members in group(values, np.sqrt(DEGENERATE), 0.0 if op.damped else slow):
        overlap, target = op.pairing(values[members], y[:, members], x[:, members])
        y[:, members] = y[:, members] @ np.linalg.pinv(overlap).conj().T * target.conj()
    g = np.empty((0, len(values)), dtype=complex)
    if op.matrices.multipliers is not None:
        y, g = op.inverse_step(values, y.conj(), transposed=True)
        y, g = y.conj(), g.conj()
    return LeftVectors(y, g)


def two_sided(
    op: ShiftInvert,
    subspace: InvariantSubspace,
    pairs: Eigenpairs,
    left: tuple[Complexes, LeftVectors] | None,
) -> Eigenpairs:
    """Eigenpairs whose errors are those by their left vectors, where these say much more.

    Given are all eigenvalues of the transposed pencil, and the left vectors of the pairs; nothing
    is known of any error without.
    """
    values = pairs.values
    if left is None:
        unknown = np.full(len(values), np.inf)
        return replace(pairs, errors=unknown)
    errors, slopes = _two_sided_errors(op, pairs, left[1])
    slopes = np.nan_to_num(slopes, nan=0.0, posinf=_UNKNOWN)
    slopes = np.maximum(slopes, np.finfo(float).tiny if subspace.graded else pairs.slopes)
    # Of a graded pencil lengths say something in the units that the subspace was found in.
    measure = pairs.conditions if subspace.graded else slopes
    far = np.maximum(1.0, np.abs(op.square(values)) / op.scale**2)
    distances = np.abs(values[:, None] - left[0])
    rows, columns = assign(distances)
    apart = distances[rows, columns] / (measure * far)[rows]  # a backward error for all of a window
    explained = far * float(apart.max(initial=0.0))
    moved = explained * measure
    if op.damped and not subspace.graded:
        moved = np.minimum(moved, np.sqrt(explained))
    errors = np.maximum(errors, moved)
    for members in connected(np.abs(values[:, None] - values) <= np.add.outer(errors, errors)):
        errors[members] *= len(members)  # discs that overlap hold all of their eigenvalues
    conditions = pairs.conditions if op.damped else slopes
    return replace(pairs, slopes=slopes, conditions=conditions, errors=errors / slopes)


def _two_sided_errors(
    op: ShiftInvert, pairs: Eigenpairs, left: LeftVectors
) -> tuple[Floats, Floats]:
    """Errors of eigenvalues, and lengths of left vectors of unit product, shape (n,)."""
    matrices, comm, n = op.matrices, op.matrices.stiffness.comm, len(pairs.values)
    errors, slopes = np.empty((2, n))
    sizes = Sizes(matrices, op.damping)
    for block in column_blocks(n):
        value, x, y = pairs.values[block], pairs.vectors[:, block], left.vectors[:, block]
        f, square = pairs.forces[:, block], op.square(pairs.values[block])
        defect, derivative, inertia = residual(op, value, x, f)
        entries = sizes.forces(x, 2 * np.abs(f), np.sqrt(np.abs(square)))
        parts = np.abs(defect) + np.finfo(float).eps * entries
        work = op.comm.tompi4py().allreduce(np.einsum("ij,ij->j", np.abs(y), parts))
        squares = columns_inner(y, times(matrices.mass, y), comm).real
        turned = np.abs(columns_inner(y, derivative, comm))
        with np.errstate(divide="ignore", invalid="ignore"):
            errors[block] = work / turned
            if op.damped:
                root = np.sqrt(work / np.abs(columns_inner(y, inertia, comm)))
                errors[block] = np.fmin(errors[block], root)
            slopes[block] = np.sqrt(np.maximum(squares, 0.0)) / turned
    sizes.free()
    errors[np.isnan(errors)] = np.inf
    return errors, slopes
