"""Supports as linear constraints, and the expansion from what they leave free.

A point constraint holds a direction d at one scalar dof i (a node, or a control point):
d . u_i = 0. A projected constraint is a row of coefficients over many dofs, C u = 0, anchored at
the dof and the direction it is to be solved for. At each dof an orthonormal frame is split into
free directions B, directions T solved for, and held ones, so that u = B v + T s and

    C T s + C B v = 0,    u = (B - T (C T)^-1 C B) v = Z v.

Where supports prescribe values, d . u_i = g and C u = c, a displacement u_D is added to that
(:mod:`cea.supports.prescribed`).

Every rank holds all constraints: there are as many as a surface has dofs.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, hstack
from scipy.sparse.linalg import splu

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.matrices import distributed
from cea.petsc import PETSc
from cea.supports.directions import Directions, complement, orthonormal
from cea.supports.prescribed import held_displacement

_NEGLIGIBLE = 1e-14
"""Coefficients dropped; those of dependent dofs fall exponentially with distance."""

_LARGEST = 1e6
"""Coefficient of a dependent dof beyond which its constraints contradict each other."""

_CHUNK_BYTES = 64 * 2**20


@dataclass(frozen=True)
class ProjectedConstraints:
    """Rows of C u = 0, each with the dof and direction it is to be solved for.

    Parameters
    ----------
    anchor
        One dof and direction for each row. A row whose direction is held there already is dropped.
    rows
        Coefficients, shape (rows, dim * num_scalar_dofs); they touch anchored dofs only.
    right
        c of C u = c, shape (rows,), where anchors have values; None of zero.
    """

    anchor: Directions
    rows: csr_array
    right: Floats | None = None


@dataclass(frozen=True)
class Constraints:
    """What the supports of a body leave free.

    Parameters
    ----------
    dim
        Dimension of space.
    num_scalar_dofs
        Scalar dofs of the body.
    dofs
        Scalar dofs with a constraint, rising, shape (m,).
    removed
        Unknowns lost at each of them, shape (m,).
    rows
        Their displacement components from the free unknowns, shape (dim * m, free unknowns).
    frame
        The same without what dependent dofs add: B at each of them.
    prescribed
        Displacement components of theirs that are prescribed (m), shape (dim * m,); None where all
        is held at zero.
    """

    dim: int
    num_scalar_dofs: int
    dofs: Ints
    removed: Ints
    rows: csr_array
    frame: csr_array
    prescribed: Floats | None = None

    @property
    def any(self) -> bool:
        """True when something is held."""
        return len(self.dofs) > 0

    @cached_property
    def selects(self) -> bool:
        """True when free unknowns are plain displacement components: Z picks some of them."""
        alone = len(np.unique(self.rows.indices)) == self.rows.nnz
        return bool(alone and np.all(self.rows.data == 1.0))

    @property
    def kept(self) -> NDArray[np.bool_]:
        """Where Z picks components: which, shape (dim * num_scalar_dofs,)."""
        kept = np.ones(self.dim * self.num_scalar_dofs, dtype=bool)
        kept[_components(self.dofs, self.dim)] = np.diff(self.rows.indptr) > 0
        return kept

    def first_free(self, dofs: Ints) -> Ints:
        """Number of the first free unknown at each scalar dof, or of the next one."""
        return _first_free(self.dim, self.dofs, self.removed, dofs)

    def numbers(self, dofs: Ints) -> Ints:
        """Free unknown of each component of scalar dofs, -1 where held; supports must select.

        Parameters
        ----------
        dofs
            Scalar dofs, shape (n,), any order.

        Returns
        -------
        ndarray
            Rising along each row, but for those held, shape (n, dim).
        """
        found = self.first_free(dofs)[:, None] + np.arange(self.dim)
        if not self.any:
            return found
        at_held = np.full(len(self.dofs) * self.dim, -1, dtype=np.int64)
        at_held[np.diff(self.rows.indptr) > 0] = self.rows.indices
        place = np.minimum(np.searchsorted(self.dofs, dofs), len(self.dofs) - 1)
        held = self.dofs[place] == dofs
        found[held] = at_held.reshape(-1, self.dim)[place[held]]
        return found

    def expansion(self, first: int, last: int, comm: Any) -> Any:
        """Z, PETSc AIJ (full x free).

        Parameters
        ----------
        first, last
            Scalar dofs of this rank; its free unknowns are those at them.
        comm
            MPI communicator.
        """
        local = self._local(self.rows, first, last)
        starts, stops = self.first_free(np.array([first, last]))
        return distributed(local, (int(stops - starts), local.shape[1]), comm)

    def frames(self, first: int, last: int) -> csr_array:
        """B of the scalar dofs of a rank: their displacement from the free unknowns at them.

        B^T B = I, and B^T u gives the free unknowns of a displacement u that the supports admit.

        Parameters
        ----------
        first, last
            Scalar dofs of the rank.

        Returns
        -------
        csr_array
            Shape (dim * (last - first), free unknowns at these dofs).
        """
        starts, stops = self.first_free(np.array([first, last]))
        return csr_array(self._local(self.frame, first, last)[:, int(starts) : int(stops)])

    def _local(self, rows: csr_array, first: int, last: int) -> csr_array:
        """Displacement of the scalar dofs of a rank from all free unknowns.

        Parameters
        ----------
        rows
            That of all dofs with a constraint.
        first, last
            Scalar dofs of the rank.
        """
        dim = self.dim
        held = slice(*np.searchsorted(self.dofs, [first, last]))
        plain = np.setdiff1d(np.arange(first, last), self.dofs[held], assume_unique=True)
        component = np.arange(dim)
        free = coo_array(rows[dim * held.start : dim * held.stop])
        of_held = _components(self.dofs[held] - first, dim)
        entries = (
            np.concatenate([np.ones(dim * len(plain)), free.data]),
            (
                np.concatenate([_components(plain - first, dim), of_held[free.row]]),
                np.concatenate(
                    [(self.first_free(plain)[:, None] + component).ravel(), free.col],
                ),
            ),
        )
        size = dim * (last - first)
        return csr_array(coo_array(entries, shape=(size, rows.shape[1])))

    def prescribed_displacement(self, first: int, last: int, expansion: Any) -> Any | None:
        """u_D, PETSc vector (full), m; None where all is held at zero.

        Parameters
        ----------
        first, last
            Scalar dofs of this rank.
        expansion
            Z, PETSc AIJ (full x free).
        """
        if self.prescribed is None:
            return None
        held = slice(*np.searchsorted(self.dofs, [first, last]))
        vector = expansion.createVecLeft()
        part = self.prescribed[self.dim * held.start : self.dim * held.stop]
        vector.array[_components(self.dofs[held] - first, self.dim)] = part
        return vector

    def restrict(self, matrix: Any, expansion: Any) -> Any:
        """Z^T A Z of a symmetric matrix, symmetric as far as rounding goes.

        Plain components are picked from the matrix; the product is formed only for others.

        Parameters
        ----------
        matrix
            A, PETSc AIJ (full x full).
        expansion
            Z, PETSc AIJ (full x free).
        """
        if not self.any:
            return matrix
        if not self.selects:
            # Ten times faster than PtAP of serial AIJ where dependent dofs have long rows.
            half = matrix.matMult(expansion)
            product = expansion.transposeMatMult(half)
            half.destroy()
            return product
        first, last = expansion.getOwnershipRange()
        chosen = (first + np.flatnonzero(self.kept[first:last])).astype(PETSc.IntType)
        free = PETSc.IS().createGeneral(chosen, comm=matrix.comm)
        return matrix.createSubMatrix(free, free)


def constrain(
    num_scalar_dofs: int,
    held: Directions,
    projected: ProjectedConstraints | None = None,
    *,
    field: str = "supports",
) -> Constraints:
    """Eliminate the constraints of a body.

    Parameters
    ----------
    num_scalar_dofs
        Scalar dofs of the body.
    held
        Directions held at single dofs.
    projected
        Constraints over many dofs.
    field
        Name of the supports in messages.

    Raises
    ------
    InputError
        When projected constraints contradict the held directions around them, or supports hold one
        component at different values.
    """
    dim = held.direction.shape[1]
    anchor = projected.anchor if projected else Directions.joined([], dim)
    every = Directions.joined([held, anchor], dim)
    dofs, owner = np.unique(every.dof, return_inverse=True)
    taken, removed, slot = orthonormal(owner, every.direction, len(dofs))
    first = _first_free(dim, dofs, removed, dofs)
    total = dim * num_scalar_dofs - int(removed.sum())
    free = frame = _free_rows(complement(taken), removed, first, total)
    values = None
    if held.value is not None:
        place = slice(len(held))
        values = held_displacement(held, owner[place], taken, slot[place], field).ravel()
    solved = np.flatnonzero(slot[len(held) :] >= 0)
    if projected and len(solved):
        at, row = owner[len(held) :][solved], slot[len(held) :][solved]
        dependent = _dependent_columns(taken[at, row], at, len(dofs))
        C = projected.rows[solved][:, _components(dofs, dim)]
        free = csr_array(free + dependent @ _elimination(C @ dependent, C @ free, field))
        if every.value is not None:
            values = np.zeros(dim * len(dofs)) if values is None else values
            size = np.abs(every.value).max() or 1.0  # coefficients are dropped below a size
            right = 0.0 if projected.right is None else projected.right[solved]
            rest = csr_array((C @ values - right)[:, None] / size)
            amounts = _elimination(C @ dependent, rest, field)
            values = values + size * (dependent @ amounts).toarray()[:, 0]
    free.data[np.abs(free.data) < _NEGLIGIBLE] = 0.0
    free.eliminate_zeros()
    return Constraints(dim, num_scalar_dofs, dofs, removed, free, frame, values)


def _first_free(dim: int, held: Ints, removed: Ints, dofs: Ints) -> Ints:
    before = np.concatenate([[0], np.cumsum(removed)])
    return dim * dofs - before[np.searchsorted(held, dofs)]


def _components(dofs: Ints, dim: int) -> Ints:
    """Full dofs of scalar dofs."""
    return (dim * dofs[:, None] + np.arange(dim)).ravel()


def _free_rows(frame: Floats, removed: Ints, first: Ints, total: int) -> csr_array:
    """Displacement of each dof from its own free unknowns, shape (dim * dofs, total)."""
    count, dim, _ = frame.shape
    dof, row, component = np.nonzero(frame * (np.arange(dim) >= removed[:, None])[:, :, None])
    column = first[dof] + row - removed[dof]
    entries = (frame[dof, row, component], (dim * dof + component, column))
    return csr_array(coo_array(entries, shape=(dim * count, total)))


def _dependent_columns(vectors: Floats, at: Ints, count: int) -> csr_array:
    """Displacement of each dof from the amounts along vectors, shape (dim * count, vectors)."""
    dim = vectors.shape[1]
    columns = np.repeat(np.arange(len(at)), dim)
    entries = (vectors.ravel(), (_components(at, dim), columns))
    return csr_array(coo_array(entries, shape=(dim * count, len(at))))


def _elimination(solved: csr_array, free: csr_array, field: str) -> csr_array:
    """-(C T)^-1 C B with negligible coefficients dropped, a chunk of columns at a time."""
    used = np.unique(free.indices)
    right = free.tocsc()[:, used]
    try:
        factors = splu(solved.tocsc())
    except RuntimeError:
        raise _contradiction(field) from None
    step = max(1, _CHUNK_BYTES // (8 * solved.shape[0]))
    parts = []
    for start in range(0, len(used), step):
        part = -factors.solve(right[:, start : start + step].toarray())
        if not np.abs(part).max(initial=0.0) < _LARGEST:
            raise _contradiction(field)
        part[np.abs(part) < _NEGLIGIBLE] = 0.0  # before the dense part becomes sparse
        parts.append(coo_array(part))
    if not parts:
        return csr_array((solved.shape[0], free.shape[1]))
    packed = coo_array(hstack(parts))
    entries = (packed.data, (packed.row, used[packed.col]))
    return csr_array(coo_array(entries, shape=(solved.shape[0], free.shape[1])))


def _contradiction(field: str) -> InputError:
    return InputError(
        field,
        "directions that turn along a surface, beside others held at its edge",
        "at such an edge, directions that differ everywhere or agree everywhere",
    )
