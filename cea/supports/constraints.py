"""Supports as linear constraints, and the expansion from the free unknowns.

A point constraint fixes a direction d at one scalar dof i (a node, or a control point):
d . u_i = 0. A projected constraint is a row of coefficients over many dofs, C u = 0, assigned to
the dof and direction for which it is solved. At each dof an orthonormal frame is split into free
directions B, directions T that are solved for, and fixed ones, so that u = B v + T s and
    C T s + C B v = 0,    u = (B - T (C T)^-1 C B) v = Z v.

For prescribed values, d . u_i = g and C u = c, a displacement u_D is added, which is zero except at
constrained dofs, and the equilibrium of the free dofs is Z^T K Z v = Z^T F - Z^T K u_D.

Every rank holds all constraints, as many as surfaces have dofs.

The force of constraints A u = b is A^T l with the multipliers l of least norm: supports that fix
the same direction share its force equally. A projected row is the sum of the rows of the supports
whose faces it integrates over, and its force is divided accordingly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, diags_array, hstack, vstack
from scipy.sparse.linalg import lsqr, norm, splu

from cea.arrays import Floats, Ints, chunks
from cea.errors import InputError
from cea.matrices import distributed

_INDEPENDENT = 1e-3
"""Sine of the angle below which a direction depends linearly on the previous ones."""

_ALIGNED = 1e-12
"""Deviation of a span of directions from coordinate axes that is treated as rounding."""

_NEGLIGIBLE = 1e-14
"""Drop tolerance of coefficients, which decay exponentially with the distance of the dofs."""

_LARGEST = 1e6  # coefficient of a dependent dof above which its constraints are contradictory

_SAME = 1e-9  # relative difference of prescribed values treated as rounding
_ROUNDING = 1e-16  # relative tolerance of the multipliers


@dataclass(frozen=True)
class Directions:
    """Directions at scalar dofs; a dof may appear several times."""

    dof: Ints  # scalar dofs, shape (n,)
    direction: Floats  # unit directions there, shape (n, dim)
    value: Floats  # displacement along each (m), shape (n,)
    support: Ints  # number of the support of each, shape (n,)

    def __len__(self) -> int:
        return len(self.dof)

    @classmethod
    def of(
        cls, dof: Ints, direction: Floats, value: Floats | float = 0.0, support: Ints | int = 0
    ) -> "Directions":
        """Return directions at dofs; directions, values and supports may be one for all."""
        n = len(dof)
        direction = np.broadcast_to(direction, (n, np.shape(direction)[-1]))
        return cls(dof, direction, np.broadcast_to(value, n), np.broadcast_to(support, n))

    @classmethod
    def joined(cls, parts: Sequence["Directions"], dim: int) -> "Directions":
        """Concatenate directions."""
        every = [cls.of(np.zeros(0, dtype=np.int64), np.zeros((0, dim))), *parts]
        columns = zip(*(vars(part).values() for part in every), strict=True)
        return cls(*(np.concatenate(column) for column in columns))


def merged(entries: Directions, cosine: float) -> Ints:
    """Return a label for each entry, equal for near directions at the same dof."""
    label = np.full(len(entries), -1)
    waiting = np.arange(len(entries))
    count = 0
    while len(waiting):
        _, leader, group = np.unique(entries.dof[waiting], return_index=True, return_inverse=True)
        led = entries.direction[waiting[leader][group]]
        near = np.einsum("ij,ij->i", led, entries.direction[waiting]) >= cosine
        # A leader is near itself despite rounding, so that each pass removes some entries.
        near[leader] = True
        label[waiting[near]] = count + group[near]
        count += len(leader)
        waiting = waiting[~near]
    return np.unique(label, return_inverse=True)[1]


def orthonormal(owner: Ints, direction: Floats, count: int) -> tuple[Floats, Ints, Ints]:
    """Orthonormalise the directions of each owner, in order, by Gram-Schmidt."""
    dim = direction.shape[1]
    vectors, rank = np.zeros((count, dim, dim)), np.zeros(count, dtype=np.int64)
    slot = np.full(len(owner), -1)
    order = np.argsort(owner, kind="stable")
    turn = np.empty(len(owner), dtype=np.int64)
    turn[order] = np.arange(len(owner)) - np.searchsorted(owner[order], owner[order])
    for k in range(turn.max(initial=-1) + 1):
        entry = np.flatnonzero(turn == k)
        at, rest = owner[entry], direction[entry]
        for _ in range(2):  # reorthogonalise against cancellation
            along = np.einsum("nki,ni->nk", vectors[at], rest)
            rest = rest - np.einsum("nki,nk->ni", vectors[at], along)
        length = np.linalg.norm(rest, axis=1)
        new = (length > _INDEPENDENT) & (rank[at] < dim)
        entry, at = entry[new], at[new]
        slot[entry] = rank[at]
        vectors[at, rank[at]] = rest[new] / length[new, None]
        rank[at] += 1
    return vectors, rank, slot


def complement(taken: Floats) -> Floats:
    """Return an orthonormal frame whose last rows complete the given ones, which come first.

    If the given rows span coordinate axes, the last rows are exactly the other axes, in order.
    """
    dim = taken.shape[1]
    frame = np.linalg.svd(taken)[2]
    projector = np.einsum("nki,nkj->nij", taken, taken)
    diagonal = np.einsum("nii->ni", projector)
    is_axis = np.rint(diagonal)
    aligned = np.abs(projector - is_axis[:, :, None] * np.eye(dim)).max(axis=(1, 2)) <= _ALIGNED
    order = np.argsort(1 - is_axis[aligned], axis=1, kind="stable")
    frame[aligned] = np.eye(dim)[order]
    return frame


@dataclass(frozen=True)
class Constraints:
    """Constraints of the supports of a body, and the expansion from its free unknowns."""

    dim: int  # dimension of space
    dofs: Ints  # constrained scalar dofs, increasing, shape (m,)
    removed: Ints  # number of unknowns eliminated at each of them, shape (m,)
    # their displacement components from the free unknowns, shape (dim * m, free unknowns)
    rows: csr_array
    frame: csr_array  # the same without dependent dofs: B at each of them
    # part of A of each support at these dofs, by its number, shape (constraints, dim * m)
    shares: Mapping[int, csr_array]
    # prescribed displacement components at these dofs (m), shape (dim * m,); None if all
    # are zero
    prescribed: Floats | None = None

    def split(self, force: Floats, supports: int) -> Floats:
        """Split constraint forces at the dofs (N), (m, dim), by support, (supports, m, dim)."""
        parts = np.zeros((supports, *force.shape))
        if self.shares:
            every = csr_array(sum(self.shares.values()))
            exactly = {"atol": _ROUNDING, "btol": _ROUNDING, "conlim": 0.0}
            multipliers = lsqr(every.T, force.ravel(), **exactly)[0]
            for support, rows in self.shares.items():
                parts[support] = (rows.T @ multipliers).reshape(force.shape)
        return parts

    @cached_property
    def selects(self) -> bool:
        """Whether free unknowns are displacement components, so that Z selects some of them."""
        alone = len(np.unique(self.rows.indices)) == self.rows.nnz
        return bool(alone and np.all(self.rows.data == 1.0))

    def first_free(self, dofs: Ints) -> Ints:
        """Return the number of the first free unknown at scalar dofs, or after them."""
        before = np.concatenate([[0], np.cumsum(self.removed)])
        return self.dim * dofs - before[np.searchsorted(self.dofs, dofs)]

    def expansion(self, first: int, last: int, comm: Any) -> Any:
        """Return Z, PETSc AIJ (full x free)."""
        local = self._local(self.rows, first, last)
        starts, stops = self.first_free(np.array([first, last]))
        return distributed(local, (int(stops - starts), local.shape[1]), comm)

    def frames(self, first: int, last: int) -> csr_array:
        """Return B of the scalar dofs of a rank: their displacement from their free unknowns.

        B^T B = I, and B^T u gives the free unknowns of an admissible displacement u.
        """
        own = slice(*self.first_free(np.array([first, last])))
        return csr_array(self._local(self.frame, first, last)[:, own])

    def _local(self, rows: csr_array, first: int, last: int) -> csr_array:
        """Return the displacement of the scalar dofs of a rank from all free unknowns."""
        held = self._held(first, last)
        plain = np.setdiff1d(np.arange(first, last), self.dofs[held], assume_unique=True)
        column = (self.first_free(plain)[:, None] + np.arange(self.dim)).ravel()
        entries = (np.ones(len(column)), column, np.arange(len(column) + 1))
        identity = csr_array(entries, shape=(len(column), rows.shape[1]))
        of_held = rows[self.dim * held.start : self.dim * held.stop]
        order = np.argsort(_components(np.concatenate([plain, self.dofs[held]]), self.dim))
        return csr_array(vstack([identity, of_held], format="csr")[order])

    def _held(self, first: int, last: int) -> slice:
        """Return the range of constrained scalar dofs that belongs to a rank."""
        return slice(*np.searchsorted(self.dofs, [first, last]))

    def prescribed_displacement(self, first: int, last: int) -> Floats | None:
        """Return u_D of the scalar dofs of a rank (m), full; None if it is zero."""
        if self.prescribed is None:
            return None
        held, whole = self._held(first, last), np.zeros(self.dim * (last - first))
        part = self.prescribed[self.dim * held.start : self.dim * held.stop]
        whole[_components(self.dofs[held] - first, self.dim)] = part
        return whole


def _components(dofs: Ints, dim: int) -> Ints:
    """Return the full dofs of scalar dofs."""
    return (dim * dofs[:, None] + np.arange(dim)).ravel()


@dataclass(frozen=True)
class ProjectedConstraints:
    """Rows of C u = c, each with the dof and direction for which it is solved."""

    # one dof and direction per row; a row is dropped if its direction is already constrained
    anchor: Directions
    # coefficients by number of the support, shape (rows, dim * num_scalar_dofs) each, whose sum
    # is C; only anchored dofs have any
    shares: Mapping[int, csr_array]
    right: Floats  # c of C u = c, shape (rows,), zero where no anchor has a value


def constrain(
    num_scalar_dofs: int,
    held: Directions,
    projected: ProjectedConstraints | None = None,
    *,
    field: str = "supports",
) -> Constraints:
    """Eliminate the constraints of a body: directions at dofs, and projected constraints.

    Raise InputError, naming ``field``, if projected constraints contradict the directions next to
    them, or supports prescribe different values for one component.
    """
    dim = held.direction.shape[1]
    every = Directions.joined([held, projected.anchor] if projected else [held], dim)
    dofs, owner = np.unique(every.dof, return_inverse=True)
    taken, removed, slot = orthonormal(owner, every.direction, len(dofs))
    first = dim * dofs - np.cumsum(removed) + removed
    total = dim * num_scalar_dofs - int(removed.sum())
    free = frame = _free_rows(complement(taken), removed, first, total)
    place = slice(len(held))
    values = _held_displacement(held, owner[place], taken, slot[place], field).ravel()
    solved = np.flatnonzero(slot[len(held) :] >= 0)
    at, row = owner[len(held) :][solved], slot[len(held) :][solved]
    # Displacement of the dofs per unit amount along the directions solved for.
    entries = (taken[at, row].ravel(), _components(at, dim), dim * np.arange(len(at) + 1))
    anchors, shares = csr_array(csc_array(entries, shape=(dim * len(dofs), len(at)))), {}
    if projected and len(solved):
        columns = _components(dofs, dim)
        shares = {s: csr_array(rows[solved][:, columns]) for s, rows in projected.shares.items()}
        C = csr_array(sum(shares.values()))
        free = csr_array(free + anchors @ _elimination(C @ anchors, C @ free, field))
        if every.value.any():
            size = np.abs(every.value).max()  # the drop tolerance is absolute
            rest = csr_array((C @ values - projected.right[solved])[:, None] / size)
            amounts = _elimination(C @ anchors, rest, field)
            values = values + size * (anchors @ amounts).toarray()[:, 0]
    free.data[np.abs(free.data) < _NEGLIGIBLE] = 0.0
    free.eliminate_zeros()
    free.sort_indices()
    along = replace(held, direction=_in_span(held, owner[place], taken, slot[place]))
    rows = _rows_by_support(along, _components(owner[place], dim), dim * len(dofs), shares)
    prescribed = values if every.value.any() else None
    return Constraints(dim, dofs, removed, free, frame, rows, prescribed)


def _in_span(held: Directions, owner: Ints, taken: Floats, slot: Ints) -> Floats:
    """Return held directions projected on the independent ones: nearly parallel ones are equal."""
    count, dim = taken.shape[:2]
    number = np.bincount(owner[slot >= 0], minlength=count)
    span = np.where(np.arange(dim)[:, None] < number[:, None, None], taken, 0.0)
    along = np.einsum("nki,ni->nk", span[owner], held.direction)
    direction = np.einsum("nk,nki->ni", along, span[owner])
    return np.asarray(direction / np.linalg.norm(direction, axis=1, keepdims=True))


def _rows_by_support(
    held: Directions, columns: Ints, width: int, shares: Mapping[int, csr_array]
) -> dict[int, csr_array]:
    """Return the constraints of each support: directions, and projected rows of unit norm."""
    (n, dim), rows = held.direction.shape, {}
    total = csr_array(sum(shares.values())) if shares else csr_array((0, width))
    scale = diags_array(1 / norm(total, axis=1))
    for support in sorted({*held.support.tolist(), *shares}):
        own = np.where(held.support[:, None] == support, held.direction, 0.0)
        points = csr_array((own.ravel(), columns, dim * np.arange(n + 1)), shape=(n, width))
        projected = scale @ shares.get(support, csr_array(total.shape))
        rows[support] = csr_array(vstack([points, projected]))
        rows[support].eliminate_zeros()
    return rows


def _free_rows(frame: Floats, removed: Ints, first: Ints, total: int) -> csr_array:
    """Return the displacement of each dof from its free unknowns, shape (dim * dofs, total)."""
    count, dim, _ = frame.shape
    dof, row, component = np.nonzero(frame * (np.arange(dim) >= removed[:, None])[:, :, None])
    column = first[dof] + row - removed[dof]
    entries = (frame[dof, row, component], (dim * dof + component, column))
    return csr_array(coo_array(entries, shape=(dim * count, total)))


def _elimination(solved: csr_array, free: csr_array, field: str) -> csr_array:
    """Return -(C T)^-1 C B without negligible coefficients, in chunks of columns."""
    used = np.unique(free.indices)
    right = free.tocsc()[:, used]
    try:
        factors = splu(solved.tocsc())
    except RuntimeError:
        raise _contradiction(field) from None
    parts = [coo_array((solved.shape[0], 0))]
    for chunk in chunks(len(used), 8 * solved.shape[0]):
        part = -factors.solve(right[:, chunk].toarray())
        if not np.abs(part).max(initial=0.0) < _LARGEST:
            raise _contradiction(field)
        part[np.abs(part) < _NEGLIGIBLE] = 0.0  # before the dense part becomes sparse
        parts.append(coo_array(part))
    packed = coo_array(hstack(parts))
    entries = (packed.data, (packed.row, used[packed.col]))
    return csr_array(coo_array(entries, shape=(solved.shape[0], free.shape[1])))


def _contradiction(field: str) -> InputError:
    return InputError(
        field,
        "directions that vary on a surface, next to others at its edge",
        "directions that differ, or agree, all along this edge",
    )


def _held_displacement(
    held: Directions, owner: Ints, taken: Floats, slot: Ints, field: str
) -> Floats:
    """Return the displacement of dofs with prescribed values, shape (dofs, dim)."""
    along = np.einsum("nki,ni->nk", taken[owner], held.direction)
    amount = np.zeros(taken.shape[:2])
    for k in range(taken.shape[1]):
        new = np.flatnonzero(slot == k)
        before = np.einsum("nj,nj->n", along[new, :k], amount[owner[new], :k])
        amount[owner[new], k] = (held.value[new] - before) / along[new, k]
    # Prescribed values must agree as far as their directions agree.
    spanned = np.einsum("nk,nki->ni", along, taken[owner])
    sine = np.linalg.norm(held.direction - spanned, axis=1)
    wrong = np.abs(held.value - np.einsum("nk,nk->n", along, amount[owner]))
    largest = np.abs(held.value).max(initial=0.0)
    if (wrong > (_SAME + 4 * sine) * largest).any():
        value = float(held.value[np.argmax(wrong)])
        allowed = "the value of the other supports of the same component at an edge"
        raise InputError(f"{field}.value", value, allowed)
    return np.einsum("nk,nki->ni", amount, taken)
