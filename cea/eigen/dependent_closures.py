"""Linearly dependent contact constraints, and the forces that they leave undetermined.

Rows of J, the closures, are dependent, N^T J = 0, where bodies are bonded around a point, where
supports fix both sides, or where two contacts impose the same condition. The forces of a contact of
finite stiffness, C f = J x, then satisfy N^T C f = 0, however stiff it is, and so do those of its
limit. With this condition as additional rows the matrix is regular for any stiffness, infinite
included.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from cea.arrays import Floats
from cea.eigen.block_products import times, transposed_times
from cea.eigen.mumps import Mumps, inertia
from cea.matrices import destroy, distributed, identity, local_part
from cea.petsc import MPI, Mat, PETSc
from cea.ranks import local_rows

_NEGLIGIBLE_ROW = 1e-14
"""Norm of a row of J relative to the largest below which it counts as rounding."""
_UNINVOLVED = 1e-14
"""Squared norm of a null vector on a contact below which it does not involve that contact."""
_NEGLIGIBLE = 1e-18
"""Entries of a column of unit norm below which they are dropped."""
_NEAR = 1e-5
"""Singular value of J with unit rows below which its space is computed by inverse iteration."""
_STEPS = 6
"""Steps of inverse iteration; the first removes vectors of much larger singular values."""


@dataclass(frozen=True)
class Dependence:
    """Left null space of the closures: N^T J = 0 for rows of J scaled to unit norm.

    ``null`` is N and ``lengths`` are the norms of rows, those of this rank; ``parts`` are the rows
    of each contact.
    """

    null: Floats
    lengths: Floats
    parts: tuple[slice, ...]
    comm: PETSc.Comm

    @property
    def size(self) -> int:
        """Number of dependences."""
        return int(self.null.shape[1])

    @classmethod
    def of(cls, closure: Mat, rows: Sequence[int], tolerance: float) -> "Dependence":
        """Find the left singular vectors of J, its rows scaled, with values below a tolerance.

        ``rows`` are the numbers of rows of each contact on this rank, stacked in ``closure``.
        """
        unit, lengths = _unit_rows(closure)
        null = _null_vectors(unit, tolerance)
        destroy(unit)
        ends = accumulate(rows, initial=0)
        return cls(null, lengths, tuple(slice(*pair) for pair in pairwise(ends)), closure.comm)

    def within(self, chosen: Sequence[bool]) -> int:
        """Return the number of dependences that involve only the chosen contacts."""
        values, _ = self._involvement(self.null[~self._by_row(chosen)])
        return int(np.sum(values <= _UNINVOLVED))

    def border(self, compliances: Sequence[Mat], scales: Sequence[float]) -> Mat:
        """Return Z, whose columns span C N.

        For contacts of different stiffness columns that involve the softest one are scaled by its
        P; the others are left to the next softest, so that no column is lost to rounding.
        ``compliances`` and ``scales`` are C^ and c_c (m/N) of each contact.
        """
        unit = self.null / self.lengths[:, None]
        both = zip(compliances, self.parts, strict=True)
        image = np.vstack([times(compliance, unit[part]) for compliance, part in both])
        of_row = self._by_row(scales)
        rest, columns = np.eye(self.size), []
        for softest in sorted(set(scales), reverse=True):
            values, vectors = self._involvement(self.null[of_row == softest] @ rest)
            own = rest @ vectors[:, values > _UNINVOLVED]
            rest = rest @ vectors[:, values <= _UNINVOLVED]
            weights = of_row / softest if softest else np.ones(len(of_row))
            weights[of_row > softest] = 0.0  # softer contacts are not involved
            columns.append(weights[:, None] * (image @ own))
            if not rest.shape[1]:
                break
        return self._as_matrix(np.hstack(columns))

    def _by_row(self, of_contacts: Sequence[float]) -> NDArray[Any]:
        """Expand values of contacts to the rows of this rank."""
        return np.repeat(of_contacts, [part.stop - part.start for part in self.parts])

    def _involvement(self, rows: Floats) -> tuple[Floats, Floats]:
        """Return squared singular values and right singular vectors of some rows of N."""
        gram = self.comm.tompi4py().allreduce(rows.T @ rows, MPI.SUM)
        values, vectors = np.linalg.eigh(gram)
        return values, vectors

    def _as_matrix(self, columns: Floats) -> Mat:
        """Return the columns, scaled to unit norm, as PETSc AIJ without negligible entries."""
        comm = self.comm.tompi4py()
        columns = columns / np.sqrt(comm.allreduce((columns**2).sum(axis=0), MPI.SUM))
        columns[np.abs(columns) < _NEGLIGIBLE] = 0.0
        count = columns.shape[1]
        start, stop = local_rows(count, comm)
        return distributed(csr_array(columns), (stop - start, count), self.comm)


def _unit_rows(closure: Mat) -> tuple[Mat, Floats]:
    """Return J, restricted to its nonzero columns and scaled to unit rows, and the norms of rows.

    Negligible rows are divided by the largest norm, and so stay negligible.
    """
    comm = closure.comm.tompi4py()
    local = local_part(closure)
    squares = csr_array((local.data**2, local.indices, local.indptr), shape=local.shape)
    length = np.sqrt(np.asarray(squares.sum(axis=1)).ravel())
    longest = comm.allreduce(length.max(initial=0.0), MPI.MAX)
    length[length <= _NEGLIGIBLE_ROW * longest] = longest
    touched = np.unique(np.concatenate(comm.allgather(np.unique(local.indices))))
    start, stop = local_rows(len(touched), comm)
    scaled = csr_array(diags_array(1 / length) @ local)[:, touched]
    return distributed(csr_array(scaled), (stop - start, len(touched)), closure.comm), length


def _null_vectors(unit: Mat, tolerance: float) -> Floats:
    """Return orthonormal left singular vectors N of values below a tolerance, rows of this rank.

    The inertia of [1, J^T; J, t^2] counts the singular values of J below t. Inverse iteration with
    t^2 + J J^T yields their space, in which they are computed without squaring.
    """
    near = unit.getSize()[0] - inertia(_augmented(unit, _NEAR**2))[0]
    comm = unit.comm.tompi4py()
    rows, columns = unit.getLocalSize()
    vectors = np.random.default_rng(comm.rank).normal(size=(rows, near))
    if not near:
        return vectors
    factors = Mumps(_augmented(unit, -(_NEAR**2)), symmetric=True)
    for _ in range(_STEPS):
        right = np.vstack([np.zeros((columns, near)), vectors])
        parts = comm.allgather(factors.solve_block(right)[columns:])
        first = sum(map(len, parts[: comm.rank]))
        vectors = np.linalg.qr(np.vstack(parts))[0][first : first + rows]
    factors.free()
    image = transposed_times(unit, vectors)
    triangle = np.vstack(comm.allgather(np.linalg.qr(image, mode="r")))
    _, sizes, turned = np.linalg.svd(triangle)
    below = np.append(sizes, np.zeros(near - len(sizes))) < tolerance
    return vectors @ turned[below].T


def _augmented(unit: Mat, corner: float) -> Mat:
    """Return [1, J^T; J, corner] as PETSc AIJ."""
    rows, columns = unit.getLocalSize()
    above, below = identity(columns, unit.comm), identity(rows, unit.comm)
    below.scale(corner)
    transpose = unit.transpose(PETSc.Mat())
    whole = PETSc.Mat().createNest([[above, transpose], [unit, below]]).convert("aij")
    destroy(above, below, transpose)
    return whole
