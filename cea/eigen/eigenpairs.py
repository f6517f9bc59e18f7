"""Modes from eigenpairs: normalised and sorted, with their residuals and condition numbers.

Products with the matrices are formed for a block of columns at a time: nothing of the size of all
vectors is kept beside them.
"""

from typing import Any

import numpy as np

from cea.body import Floats
from cea.eigen.modes import Complexes, Modes, Window
from cea.eigen.pencil import BorderedSolver
from cea.matrices import destroy
from cea.petsc import PETSc

_BLOCK = 64
"""Columns at a time."""
_NEGLIGIBLE = 1e-10
"""Eigenvalues below this part of the window's upper end count as zero in relative residuals."""


def modes_from_eigenpairs(
    operator: Any,
    mass: Any,
    kappa: Complexes,
    vectors: Complexes,
    window: Window,
    *,
    symmetric: bool,
    bordered: BorderedSolver | None = None,
) -> Modes:
    """Modes lambda^2 = -kappa with Im lambda >= 0 up to the end of the window.

    Parameters
    ----------
    operator
        S - F, PETSc AIJ.
    mass
        M, PETSc AIJ.
    kappa
        Eigenvalues of (S - F) x = kappa M x, shape (n,).
    vectors
        Eigenvectors, the rows of this rank, shape (n_local, n). They are normalised in place.
    window
        What was searched.
    symmetric
        Without friction: eigenvalues are taken from Rayleigh quotients, conditions are 1.
    bordered
        Factorised pencil at ``window.shift`` where contact forces are unknowns: one step of
        inverse iteration gives displacements that obey the contact, and the forces.
    """
    n = len(kappa)
    kappa, residuals, gram = kappa.copy(), np.empty(n), np.zeros((n, n), dtype=complex)
    for start in range(0, n, _BLOCK):
        block = slice(start, min(start + _BLOCK, n))
        x = vectors[:, block]
        if bordered is None:
            forces = _apply(operator, x)
        else:
            x, forces = _with_contact_forces(bordered, operator, mass, kappa[block], x, window)
        inertia = _apply(mass, x)
        norms = np.sqrt(_columns_inner(x, inertia, mass.comm).real)
        x, forces, inertia = x / norms, forces / norms, inertia / norms
        vectors[:, block] = x
        if symmetric:  # the Rayleigh quotient has the square of the vector's error
            kappa[block] = _columns_inner(x, forces, mass.comm).real
        else:
            lower = inertia.conj().T @ vectors[:, : block.stop]
            gram[block, : block.stop] = mass.comm.tompi4py().allreduce(lower)
        scale = np.maximum(np.abs(kappa[block]), _NEGLIGIBLE * window.upper)
        defects = forces - inertia * kappa[block]
        residuals[block] = _norms(defects, mass.comm) / (scale * _norms(inertia, mass.comm))
    conditions = np.ones(n) if symmetric else _conditions(gram)

    eigenvalues = np.sqrt(-kappa).astype(complex)
    eigenvalues = np.where(eigenvalues.imag < 0, -eigenvalues, eigenvalues) + 0j
    order = np.lexsort((eigenvalues.real, eigenvalues.imag))
    order = order[eigenvalues.imag[order] <= 2 * np.pi * window.max_frequency]
    return Modes(
        eigenvalues=eigenvalues[order],
        residuals=residuals[order],
        conditions=conditions[order],
        vectors=vectors[:, order],
        template=mass.createVecRight(),
        window=window,
    )


def _with_contact_forces(
    bordered: BorderedSolver,
    operator: Any,
    mass: Any,
    kappa: Complexes,
    vectors: Complexes,
    window: Window,
) -> tuple[Complexes, Complexes]:
    """One step of inverse iteration: displacements that obey the contact, and all forces on them.

    Returns
    -------
    tuple
        x and (S - F) x + L^T f, scaled as the vectors were.
    """
    n = vectors.shape[1]
    inertia = _apply(mass, vectors * (kappa - window.shift))
    x, f = bordered.solve_block(np.hstack([inertia.real, inertia.imag]))
    displacements, contact = x[:, :n] + 1j * x[:, n:], f[:, :n] + 1j * f[:, n:]
    transpose = bordered.multipliers.reaction.transpose(PETSc.Mat())
    forces = _apply(operator, displacements) + _apply(transpose, contact)
    destroy(transpose)
    return displacements, forces


def _apply(matrix: Any, vectors: Complexes) -> Complexes:
    """Matrix times a block of vectors, real and imaginary parts in one sparse-dense product."""
    n = vectors.shape[1]
    block = np.asfortranarray(np.hstack([vectors.real, vectors.imag]))
    columns = matrix.getSizes()[1]
    dense = PETSc.Mat().createDense((columns, (PETSc.DECIDE, 2 * n)), array=block, comm=matrix.comm)
    product = matrix.matMult(dense)
    result = product.getDenseArray()
    values = result[:, :n] + 1j * result[:, n:]
    destroy(product, dense)
    return values


def _columns_inner(left: Complexes, right: Complexes, comm: Any) -> Complexes:
    """Inner product of each column with its counterpart."""
    return comm.tompi4py().allreduce(np.einsum("ij,ij->j", left.conj(), right))


def _norms(vectors: Complexes, comm: Any) -> Floats:
    return np.sqrt(_columns_inner(vectors, vectors, comm).real)


def _conditions(gram: Complexes) -> Floats:
    """Condition numbers from the Gram matrix of unit eigenvectors: sqrt of diag of its inverse.

    Parameters
    ----------
    gram
        Gram matrix, of which the lower triangle is read.
    """
    values, vectors = np.linalg.eigh(gram, UPLO="L")
    values = np.maximum(values, np.finfo(float).eps * values.max(initial=1.0))
    return np.sqrt(np.maximum((np.abs(vectors) ** 2 / values).sum(axis=1), 1.0))
