"""Eigenpairs of a quadratic problem, normalised, with residuals, conditions and errors.

With a left vector y, y^H (2 lambda M + D) x = 1, a change of the problem moves an eigenvalue by

    d lambda = - y^H (lambda^2 dM + lambda dD + dK) x,

so that a residual r = P(lambda) x is worth || y ||_M || r || in the norm of M^-1. Left vectors are
those of the companion form within the invariant subspace that was found, unless they are given.
Where the other eigenvalue of a motion was not found, as of overdamped ones, they say too little:

    || y ||_M >= 1 / || (2 lambda M + D) x ||.

An error e of lambda^2 makes no more than sqrt(e) of the two of a motion where they meet.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import schur

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import (
    all_inner,
    column_blocks,
    columns_inner,
    combined,
    image_of,
    norms,
    times,
)
from cea.eigen.clusters import cluster_bounds
from cea.eigen.eigenpairs import LUMPED, SMALL, internal_forces
from cea.eigen.pencil import Matrices
from cea.eigen.quadratic_damping import Damping
from cea.eigen.shift_invert import MARGIN
from cea.eigen.shifted import Shifted
from cea.eigen.sizes import Sizes
from cea.eigen.subspace import InvariantSubspace
from cea.matrices import absolute, destroy


@dataclass(frozen=True)
class QuadraticPairs:
    """Eigenpairs (lambda^2 M + lambda D + K) x = 0 of a window and around it.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,).
    vectors
        x with x^H M x = 1, the rows of this rank, shape (n_local, n).
    forces
        Contact forces that are unknowns, shape (multipliers of this rank, n).
    residuals
        Norm of P(lambda) x relative to that of its parts, abs(lambda)^2 abs(M) abs(x) and so on,
        shape (n,): the relative change of the entries of the matrices that makes it zero.
    slopes
        || y ||_M (s), shape (n,): what an error of lambda^2 makes of lambda.
    errors
        Backward errors (1/s^2): what the residual amounts to, and what rounding the entries of the
        matrices does, shape (n,).
    bounds
        Bounds on the errors of lambda (1/s) by the clusters that they belong to, shape (n,);
        infinite where there is none.
    conditions
        Condition numbers of lambda in the companion form, within the subspace, shape (n,).
    """

    eigenvalues: Complexes
    vectors: Complexes
    forces: Complexes
    residuals: Floats
    slopes: Floats
    errors: Floats
    bounds: Floats
    conditions: Floats

    @property
    def uncertainties(self) -> Floats:
        """Errors of lambda (1/s), shape (n,)."""
        return np.minimum(self.errors * self.slopes, self.bounds)


@dataclass(frozen=True)
class _Duals:
    """Norms of right and dual vectors of the companion form, of x with x^H M x = 1, shape (n,).

    Parameters
    ----------
    right, left
        Norms of [x; z] and of its dual vector, whose product with it is 1.
    slopes
        Norms of y.
    """

    right: Floats
    left: Floats
    slopes: Floats


def upper_half(found: InvariantSubspace, end: float) -> InvariantSubspace:
    """Without the eigenvalues below the real axis that are not next to it, beside omega (1/s)."""
    if not found.size:
        return found
    form, vectors, kept = schur(
        found.projected, output="complex", sort=lambda value: bool(value.imag >= -MARGIN * end)
    )
    basis = combined(found.basis, vectors[:, :kept])
    return replace(found, basis=basis, projected=form[:kept, :kept])


def checked_pairs(
    matrices: Matrices, factors: Shifted, subspace: InvariantSubspace, scale: float
) -> QuadraticPairs:
    """Eigenpairs of an invariant subspace of the companion form.

    Where contact forces are unknowns, one step of inverse iteration gives displacements that obey
    the contact, and the forces.

    Parameters
    ----------
    matrices
        The pencil at the parameters it was solved at.
    factors
        P(s) factorised.
    subspace
        Invariant subspace of the companion form.
    scale
        Its gamma (1/s).
    """
    values, vectors = subspace.eigenpairs()
    # Left vectors are scaled by lambda. About a real shift it may be zero to the last digit.
    values = np.where(values == 0, 1j * np.finfo(float).eps * scale, values)
    x = vectors[: len(vectors) // 2]
    damping = Damping(matrices)
    x, f = _normalised(matrices, damping, factors, values, x)
    duals = _duals(matrices, values, x, scale)
    residuals, errors, least = _residuals(matrices, damping, factors, values, x, f, duals, scale)
    damping.free()
    slopes = np.maximum(duals.slopes, np.minimum(least, 1 / np.sqrt(errors)))
    conditions = duals.right * duals.left
    bounds = cluster_bounds(subspace.projected, values, errors * slopes / conditions, conditions)
    return QuadraticPairs(values, x, f, residuals, slopes, errors, bounds, conditions)


def inverse_step(
    matrices: Matrices,
    damping: Damping,
    factors: Shifted,
    values: Complexes,
    x: Complexes,
    *,
    transposed: bool = False,
) -> tuple[Complexes, Complexes]:
    """One step of inverse iteration: displacements and contact forces, scaled as x is.

    P(s) x' + L^T f = (P(s) - P(lambda)) x, P(lambda) - P(s) = (lambda - s) ((lambda + s) M + D).
    """
    load = times(matrices.mass, x * (values + factors.rate))
    load += damping.times(x, transposed=transposed)
    return factors.solve_with_forces(load * (factors.rate - values), transposed=transposed)


def _normalised(
    matrices: Matrices,
    damping: Damping,
    factors: Shifted,
    values: Complexes,
    x: Complexes,
) -> tuple[Complexes, Complexes]:
    """Displacements with x^H M x = 1, and their contact forces."""
    comm, contact = matrices.stiffness.comm, []
    for block in column_blocks(len(values)):
        part, f = x[:, block], np.empty((0, x[:, block].shape[1]), dtype=complex)
        if matrices.multipliers is not None:
            part, f = inverse_step(matrices, damping, factors, values[block], part)
        size = np.sqrt(columns_inner(part, times(matrices.mass, part), comm).real)
        x[:, block] = part / size
        contact.append(f / size)
    nothing = np.empty((len(contact[0]) if contact else 0, 0), dtype=complex)
    return x, np.hstack([nothing, *contact])


def _duals(matrices: Matrices, values: Complexes, x: Complexes, scale: float) -> _Duals:
    """Dual vectors within the space of the vectors and their conjugates, by Gram matrices.

    Conjugates of those next to the real axis are among the vectors.
    """
    n, comm = len(values), matrices.stiffness.comm
    own, mixed = np.zeros((2, n, n), dtype=complex)
    for block in column_blocks(n):
        image = times(matrices.mass, x[:, block])
        own[:, block] = all_inner(x, image, comm)
        mixed[:, block] = all_inner(x.conj(), image, comm)  # x_i^T M x_j
    twins = np.flatnonzero(values.imag > MARGIN * scale)
    # Of [x, conj x]: x^H M conj(y) is the conjugate of x^T M y.
    gram = np.block(
        [[own, mixed[:, twins].conj()], [mixed[twins], own[np.ix_(twins, twins)].conj()]]
    )
    part = np.append(values, values[twins].conj()) / scale
    second = part.conj()[:, None] * gram * part
    gram = gram + second
    right = np.sqrt(np.diag(gram).real)
    gram, second = gram / np.outer(right, right), second / np.outer(right, right)
    sizes, axes = np.linalg.eigh(gram)
    sizes = np.maximum(sizes, np.finfo(float).eps * sizes.max(initial=1.0))
    inverse = (axes / sizes) @ axes.conj().T
    left = np.sqrt(np.diag(inverse).real) / right
    slopes = np.sqrt(np.maximum(np.diag(inverse @ second @ inverse).real, 0.0)) / right / scale
    return _Duals(right[:n], left[:n], slopes[:n])


def _residuals(
    matrices: Matrices,
    damping: Damping,
    factors: Shifted,
    values: Complexes,
    x: Complexes,
    f: Complexes,
    duals: _Duals,
    scale: float,
) -> tuple[Floats, Floats, Floats]:
    """Backward errors of the entries, of lambda^2 (1/s^2), and what norms of y are at least (s).

    With d = P(s)^-1 r an eigenvalue is wrong by no more than abs(lambda - s) times the norms of d,
    beside s d / gamma, and of the dual vector: the backward error of the inverse problem, which is
    the one that was solved. The smaller one counts, as for problems in kappa
    (:func:`cea.eigen.eigenpairs.checked`).
    """
    n, comm, mass = len(values), matrices.stiffness.comm, matrices.mass
    residuals, errors, least = np.empty((3, n))
    sizes = QuadraticSizes(matrices, damping)
    diagonal = mass.getDiagonal()
    root = np.sqrt(diagonal.array_r)[:, None]
    destroy(diagonal)
    shift = factors.rate
    for block in column_blocks(n):
        value, part = values[block], x[:, block]
        inertia = times(mass, part)
        drag = damping.times(part)
        defect = internal_forces(matrices, part, f[:, block]) + inertia * value**2 + drag * value
        forces = sizes.forces(value, part, f[:, block])
        works = comm.tompi4py().allreduce(np.einsum("ij,ij->j", np.abs(part), forces))
        rounding = np.finfo(float).eps * works
        residuals[block] = norms(defect, comm) / norms(forces.astype(complex), comm)
        turned = norms((2 * value * inertia + drag) / root, comm)
        least[block] = 1 / np.maximum(turned, np.finfo(float).tiny)
        error = LUMPED * norms(defect / root, comm)
        large = np.flatnonzero(error > SMALL * np.maximum(np.abs(value) ** 2, rounding))
        if len(large):  # solves cost as much as all the rest
            step, _ = factors.solve_with_forces(defect[:, large])
            length = np.sqrt(np.abs(columns_inner(step, times(mass, step), comm)))
            far = np.abs(value[large] - shift) * np.hypot(1.0, abs(shift) / scale)
            left = duals.left[block][large]
            slope = np.maximum(duals.slopes[block][large], np.finfo(float).eps * left / scale)
            inverse = far * length * left / slope
            error[large] = np.minimum(error[large], inverse)
        errors[block] = rounding + error
    sizes.free()
    return residuals, errors, least


class QuadraticSizes:
    """Absolute values of all matrices of a quadratic pencil."""

    def __init__(self, matrices: Matrices, damping: Damping) -> None:
        self._stiffness = Sizes(matrices)
        self._mass = absolute(matrices.mass)
        self._damping = damping
        self._circulatory = matrices.circulatory

    def forces(self, values: Complexes, x: Complexes, f: Complexes) -> Floats:
        """What the parts of P(lambda) x come to, the rows of this rank.

        Contact forces count twice: they stand in the rows of the contact too.
        """
        size, speed = np.abs(x), np.abs(values)
        forces = image_of(self._mass, size) * speed**2
        forces += self._damping.sizes(size) * speed
        if self._circulatory is not None:
            forces += self._circulatory.sizes(x)
        return forces + self._stiffness.forces(size, 2 * np.abs(f))

    def free(self) -> None:
        """Free the matrices but those of the damping."""
        self._stiffness.free()
        destroy(self._mass)
