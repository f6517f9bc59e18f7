"""Balancing: powers of two on rows and columns that take a grading out of a pencil.

Where a matrix is D A D^-1 of one whose entries are alike, as where unknowns and forces are counted
in units far apart, norms say nothing: rounding of the largest entries covers all the others. The
entries determine the eigenvalues as well as those of A do. With a diagonal T

    T^-1 K T z = kappa T^-1 M T z,    T^-1 M T = M where T is constant on what M couples,

has the same eigenvalues, M stays symmetric, and powers of two round nothing. T makes each row of K
as large as its column (Osborne, J. ACM 7 (1960)), entries measured in the masses of both unknowns.
What friction makes of stiff contacts is no grading: the stiffness of the contact stands on the
diagonal, where no T changes it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.csgraph import connected_components

from cea.arrays import Floats
from cea.eigen.pencil import Matrices
from cea.matrices import destroy, local_part, scaled_total
from cea.petsc import MPI, Mat

_GRADED = 16.0
"""Largest entry that may be graded relative to the largest on the diagonal, from which on it is."""
_WORTH = 4.0
"""Least factor on the norm for which a pencil is balanced."""
_STEPS = 300
"""Most steps towards equal rows and columns."""
_EVEN = 0.1
"""Logarithm of the ratio of a row and its column that is even enough."""


@dataclass(frozen=True)
class Balance:
    """Factors of rows and columns, powers of two, those of this rank, shape (n_local,).

    Parameters
    ----------
    left, right
        Of rows and of columns: left K right is the balanced matrix; eigenvectors are right z, left
        ones left w, of its own z and w.
    """

    left: Floats
    right: Floats


def balance_of(matrices: Matrices, end: float, *, local: bool = False) -> Balance | None:
    """Balance of a pencil at given parameters; None where it is not graded; collective.

    Pencils that it would make unsymmetric are left as they are, and so are those with pieces that
    are never formed and contact forces that are unknowns.

    Parameters
    ----------
    matrices
        The pencil.
    end
        omega of the end of a window (1/s), by which damping is measured.
    local
        Whether each entry is measured by the diagonal entries of its own row and column: that finds
        a grading beside much larger entries, and also where stiff contacts join bodies of unlike
        masses, which are solved as well without.
    """
    beside = (matrices.multipliers, matrices.low_rank, matrices.circulatory)
    if any(each is not None for each in beside):
        return None
    scale = _mass_scale(matrices.mass)
    if not local and not _stands_out(matrices, end, scale):
        return None
    comm = matrices.mass.comm.tompi4py()
    total = csr_array(
        _absolute([matrices.stiffness, matrices.unsymmetric], matrices.mass)
        + end * _absolute([matrices.damping, matrices.gyroscopic], matrices.mass)
    )
    whole, couples, scales = (
        vstack(comm.allgather(rows), format="csr")
        for rows in (total, local_part(matrices.mass), csr_array(scale[:, None]))
    )
    in_masses = diags_array(scales.toarray()[:, 0])
    sizes = csr_array(in_masses @ whole @ in_masses)
    factors = osborne(sizes, csr_array(couples))
    before, after = (_excess(sizes, each, end**2, local=local) for each in (None, factors))
    if before <= _GRADED or after * _WORTH > before:
        return None
    own = factors[slice(*matrices.mass.getOwnershipRange())]
    return Balance(scale / own, scale * own)


def osborne(sizes: csr_array, couples: csr_array) -> Floats:
    """T, powers of two, shape (n,), which makes rows of T^-1 A T as large as columns.

    Parameters
    ----------
    sizes
        Absolute entries of A, shape (n, n).
    couples
        A symmetric matrix, shape (n, n): T is the same wherever it has an entry.
    """
    squares = sizes.copy()
    squares.data = (sizes.data / max(sizes.data.max(initial=0.0), np.finfo(float).tiny)) ** 2
    count, label = connected_components(csr_array(couples != 0), directed=False)
    belongs = csr_array((np.ones(len(label)), (np.arange(len(label)), label)), (len(label), count))
    blocks = csr_array(belongs.T @ squares @ belongs)
    transposed = csr_array(blocks.T)
    logs = np.zeros(count)
    for _ in range(_STEPS):
        weights = np.exp(2 * logs)
        rows, columns = blocks @ weights / weights, transposed @ (1 / weights) * weights
        both = (rows > 0) & (columns > 0)
        # A quarter of the logarithm balances one row alone; all move at once, by half of it.
        step = np.zeros(count)
        step[both] = 0.125 * np.log(rows[both] / columns[both])
        logs += step
        if np.abs(step).max(initial=0.0) <= 0.25 * _EVEN:
            break
    return np.asarray(2.0 ** np.round(logs / np.log(2)))[label]


def _excess(sizes: csr_array, factors: Floats | None, least: float, *, local: bool) -> float:
    """Largest entry of T^-1 A T beside the diagonal, relative to it; A itself without factors."""
    diagonal = np.maximum(sizes.diagonal(), least)
    entries = sizes.tocoo()
    rows, columns = entries.coords
    by = np.maximum(diagonal[rows], diagonal[columns]) if local else diagonal.max()
    scaled = entries.data if factors is None else entries.data * factors[columns] / factors[rows]
    return float((scaled / by).max(initial=0.0))


def _mass_scale(mass: Mat) -> Floats:
    """Powers of two next to the roots of 1 / m_ii, of this rank."""
    diagonal = mass.getDiagonal()
    scale = 2.0 ** np.round(-0.5 * np.log2(diagonal.array_r))
    destroy(diagonal)
    return scale


def _stands_out(matrices: Matrices, end: float, scale: Floats) -> bool:
    """Whether an entry that is not symmetric is larger than all on the diagonal, in the masses.

    A symmetric matrix is balanced, and one that is positive definite has its largest entries on
    the diagonal: few entries are looked at.
    """
    comm = matrices.mass.comm.tompi4py()
    symmetric = [(matrices.stiffness, 1.0), (matrices.damping, end)]
    rest = [(matrices.unsymmetric, 1.0), (matrices.gyroscopic, end)]
    largest, across = 0.0, 0.0
    for part, factor in [*symmetric, *rest]:
        if part is not None:
            diagonal = part.getDiagonal()
            largest += factor * float(np.abs(diagonal.array_r * scale**2).max(initial=0.0))
            destroy(diagonal)
    for part, factor in rest:
        if part is not None:
            scaled, vector = part.copy(), part.createVecLeft()
            vector.array[:] = scale
            scaled.diagonalScale(L=vector, R=vector)
            entries = scaled.getValuesCSR()[2]
            across = max(across, factor * float(np.abs(entries).max(initial=0.0)))
            destroy(scaled, vector)
    return bool(comm.allreduce(across, MPI.MAX) > _GRADED * comm.allreduce(largest, MPI.MAX))


def _absolute(sums: list[Any], like: Any) -> csr_array:
    """Absolute entries of a sum, the rows of this rank; zeros of a shape where it has no part."""
    parts = [(1.0, part) for part in sums if part is not None]
    if not parts:
        return csr_array((like.getLocalSize()[0], like.getSize()[1]))
    whole = scaled_total(parts)
    rows = csr_array(abs(local_part(whole)))
    destroy(whole)
    return rows
