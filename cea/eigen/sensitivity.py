"""Left eigenvectors of a pencil, and derivatives of its eigenvalues in its parameters.

With y^H (2 lambda M + D) x = 2 lambda, which is y^H M x = 1 without damping, and contact forces f,
g beside x, y (:mod:`cea.eigen.multipliers`),

    d lambda = - (y^H (lambda^2 dM + lambda dD + dK) x - dc_f (R y)^H f - dc_c g^H C^ f)
               / (2 lambda).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import all_inner, column_blocks, times
from cea.eigen.eigenpairs import Eigenpairs, inverse_step
from cea.eigen.eigenvalue_matching import DEGENERATE, assign, group
from cea.eigen.pencil import Matrices, Pencil, Role
from cea.eigen.shifted import Shifted
from cea.eigen.spectrum import SLOW
from cea.errors import ConvergenceError
from cea.petsc import Mat

SAME = 1e-4
"""Relative distance of left and right eigenvalues beyond which they are not the same."""


POWERS: dict[Role, int] = {"mass": 2, "damping": 1, "stiffness": 0}
"""Powers of lambda that go with the pieces of a pencil."""


@dataclass(frozen=True)
class LeftVectors:
    """Left eigenvectors y with y_i^H M x_j = delta_ij, or as damped pencils have them.

    There y_i^H ((lambda_i + lambda_j) M + D) x_j is 2 lambda_i for i = j, and zero otherwise.

    Parameters
    ----------
    vectors
        The rows of this rank, shape (n_local, n).
    forces
        Their multipliers, the rows of this rank, shape (multipliers of this rank, n).
    """

    vectors: Complexes
    forces: Complexes

    def __getitem__(self, modes: Any) -> "LeftVectors":
        return LeftVectors(self.vectors[:, modes], self.forces[:, modes])


def left_vectors_of(
    matrices: Matrices,
    factors: Shifted,
    pairs: Eigenpairs,
    kappa: Complexes,
    vectors: Complexes,
    top: float,
) -> LeftVectors:
    """Left vectors of eigenpairs, in their order.

    Parameters
    ----------
    matrices, factors
        The pencil, and factorised.
    pairs
        Eigenpairs.
    kappa, vectors
        Eigenvectors of K^T and their eigenvalues; none without friction, where right ones serve.
    top
        Upper end of the window (1/s^2).
    """
    if matrices.symmetric:
        return LeftVectors(pairs.vectors, pairs.forces)
    y = biorthonormal(matrices.mass, pairs.kappa, pairs.vectors, kappa, vectors, top)
    g = np.empty((0, len(pairs.kappa)), dtype=complex)
    if matrices.multipliers is not None:
        y, g = inverse_step(matrices, factors, pairs.kappa.conj(), y, transposed=True)
    return LeftVectors(y, g)


def biorthonormal(
    mass: Mat,
    kappa: Complexes,
    vectors: Complexes,
    left_kappa: Complexes,
    left_vectors: Complexes,
    top: float,
) -> Complexes:
    """Left vectors in the order of right ones, with y_i^H M x_j = delta_ij.

    Where eigenvalues touch, left vectors are the dual basis of the right ones in the left space.

    Parameters
    ----------
    mass
        M, PETSc AIJ.
    kappa, vectors
        Eigenvalues, shape (n,), and right vectors, the rows of this rank, shape (n_local, n).
    left_kappa, left_vectors
        Eigenvalues of the transposed problem and their vectors, at least as many.
    top
        Upper end of the window (1/s^2), by which rigid motions are judged: they have no speed.

    Raises
    ------
    ConvergenceError
        When an eigenvalue has no left vector.
    """
    slow = SLOW**2 * top
    cost = np.abs(kappa[:, None] - left_kappa.conj()) / np.abs(kappa).max(initial=slow)
    rows, columns = assign(cost, SAME)
    if len(rows) < len(kappa):
        raise ConvergenceError(
            f"{len(kappa) - len(rows)} of {len(kappa)} eigenvalues have no left vector",
            best=left_kappa,
        )
    left = left_vectors[:, columns]
    for members in group(kappa, np.sqrt(DEGENERATE), slow):
        image = times(mass, vectors[:, members])
        overlap = all_inner(left[:, members], image, mass.comm)
        left[:, members] = left[:, members] @ np.linalg.inv(overlap).conj().T
    return left


def dual_norms(mass: Mat, vectors: Complexes) -> Floats:
    """M-norms of vectors, the columns of this rank's rows, shape (n,)."""
    squares = np.empty(vectors.shape[1])
    for block in column_blocks(vectors.shape[1]):
        x = vectors[:, block]
        image = times(mass, x)
        squares[block] = mass.comm.tompi4py().allreduce(np.einsum("ij,ij->j", x.conj(), image).real)
    return np.sqrt(squares)


def derivatives(
    pencil: Pencil,
    values: Mapping[str, float],
    name: str,
    eigenvalues: Complexes,
    vectors: Complexes,
    forces: Complexes,
    left: LeftVectors,
) -> Complexes:
    """Derivatives of eigenvalues lambda in a parameter (:meth:`cea.eigen.modes.Modes.sensitivity`).

    Parameters
    ----------
    pencil, values
        The pencil and the parameters it was solved at.
    name
        The parameter.
    eigenvalues, vectors, forces
        lambda (1/s), right vectors and their contact forces.
    left
        Left vectors.
    """
    n = len(eigenvalues)
    change = np.zeros((n, n), dtype=complex)
    for term in pencil.terms:
        slope = term.coefficient.derivative(name, values)
        if slope:
            power = eigenvalues ** POWERS[term.role]
            change += slope * power * _projected(term.matrix, left.vectors, vectors)
    comm, first = pencil.comm, 0
    for circulatory in pencil.circulatory:
        slope = circulatory.coefficient.derivative(name, values)
        if slope:
            change += slope * all_inner(left.vectors, circulatory.piece.times(vectors), comm)
    for piece in pencil.low_rank:
        slope = piece.coefficient.derivative(name, values)
        if slope:
            drag = piece.piece.projected(left.vectors, vectors, comm)
            change += slope * eigenvalues * drag
    for of_contact in pencil.forces:
        last = first + of_contact.closure.getLocalSize()[0]
        f, g = forces[first:last], left.forces[first:last]
        slope = of_contact.friction.derivative(name, values)
        if slope and of_contact.slip is not None:
            change -= slope * all_inner(times(of_contact.slip, left.vectors), f, comm)
        slope = of_contact.inverse_stiffness.derivative(name, values)
        if slope:
            change -= slope * all_inner(g, times(of_contact.compliance, f), comm)
        first = last
    moved = np.diag(change).copy()
    for members in group(eigenvalues, DEGENERATE):
        if len(members) > 1:
            moved[members] = np.linalg.eigvals(change[np.ix_(members, members)])
    with np.errstate(divide="ignore", invalid="ignore"):
        return -moved / (2 * eigenvalues)


def _projected(matrix: Mat, left: Complexes, right: Complexes) -> Complexes:
    """Y^H A X, shape (n, n)."""
    n = right.shape[1]
    result = np.empty((n, n), dtype=complex)
    for block in column_blocks(n):
        result[:, block] = all_inner(left, times(matrix, right[:, block]), matrix.comm)
    return result
