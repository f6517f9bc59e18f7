"""Closures of contacts that depend on each other, and the forces that none of them determines.

A sum N^T J = 0 of closures does nothing to the displacements: where bodies are bonded round a
point, where supports hold both sides, where two contacts ask the same. The forces of a finite
stiffness, C f = J x, then obey N^T C f = 0, however stiff the contact; so do those of its limit.
With that condition as rows of their own the matrix is regular for any stiffness, and infinite.
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
"""Closures below this part of the largest are rounding."""
_UNINVOLVED = 1e-14
"""Square of the part of a dependence that does not involve a contact."""
_NEGLIGIBLE = 1e-18
"""Entries of a column of unit length below this are left out."""
_NEAR = 1e-5
"""Size of a sum of unit closures that is looked at closely."""
_STEPS = 6
"""Steps of inverse iteration: what lies well above is gone after the first."""


@dataclass(frozen=True)
class Dependence:
    """Sums of closures that vanish: N^T J = 0, N for closures of unit length.

    Of N (``null``) and of the lengths of closures it has the rows of this rank, in parts by
    contact.
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
        """Find the sums of closures, each scaled to unit length, that are below a tolerance.

        J of all contacts has so many rows of each on this rank, one below the other.
        """
        unit, lengths = _unit_rows(closure)
        null = _null_vectors(unit, tolerance)
        destroy(unit)
        ends = accumulate(rows, initial=0)
        return cls(null, lengths, tuple(slice(*pair) for pair in pairwise(ends)), closure.comm)

    def within(self, chosen: Sequence[bool]) -> int:
        """Number of dependences that involve none but chosen contacts."""
        values, _ = self._involvement(self.null[~self._by_row(chosen)])
        return int(np.sum(values <= _UNINVOLVED))

    def border(self, compliances: Sequence[Mat], scales: Sequence[float]) -> Mat:
        """Z, whose columns span C N.

        Of contacts of different stiffness the softest decides: columns are weighted by its P, and
        what does not involve it is left to the next. So none of them is lost beside the others.
        Given are C^ and c_c (m/N) of each contact.
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
            weights[of_row > softest] = 0.0  # softer ones are not involved
            columns.append(weights[:, None] * (image @ own))
            if not rest.shape[1]:
                break
        return self._as_matrix(np.hstack(columns))

    def _by_row(self, of_contacts: Sequence[float]) -> NDArray[Any]:
        """What is given by contact, for each row of this rank."""
        return np.repeat(of_contacts, [part.stop - part.start for part in self.parts])

    def _involvement(self, rows: Floats) -> tuple[Floats, Floats]:
        """Squares of the parts of sums in some rows of N, and the sums."""
        gram = self.comm.tompi4py().allreduce(rows.T @ rows, MPI.SUM)
        values, vectors = np.linalg.eigh(gram)
        return values, vectors

    def _as_matrix(self, columns: Floats) -> Mat:
        """Columns of unit length as PETSc AIJ, without entries of rounding."""
        comm = self.comm.tompi4py()
        columns = columns / np.sqrt(comm.allreduce((columns**2).sum(axis=0), MPI.SUM))
        columns[np.abs(columns) < _NEGLIGIBLE] = 0.0
        count = columns.shape[1]
        start, stop = local_rows(count, comm)
        return distributed(csr_array(columns), (stop - start, count), self.comm)


def _unit_rows(closure: Mat) -> tuple[Mat, Floats]:
    """J on the displacements it touches, its rows scaled to unit length, and their lengths.

    Rows of rounding are scaled as the longest, and stay so.
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
    """Orthonormal N with N^T J of a size below a tolerance, the rows of this rank.

    The inertia of [1, J^T; J, t^2] tells how many singular values of J lie below t; their space is
    that of the largest eigenvalues of (t^2 + J J^T)^-1. In it they are found without squaring.
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
    """[1, J^T; J, corner], PETSc AIJ."""
    rows, columns = unit.getLocalSize()
    above, below = identity(columns, unit.comm), identity(rows, unit.comm)
    below.scale(corner)
    transpose = unit.transpose(PETSc.Mat())
    whole = PETSc.Mat().createNest([[above, transpose], [unit, below]]).convert("aij")
    destroy(above, below, transpose)
    return whole
