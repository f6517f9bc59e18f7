"""Elimination of the constraints of a body, which gives :class:`Constraints`."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, diags_array, hstack, vstack
from scipy.sparse.linalg import norm, splu

from cea.arrays import Floats, Ints, chunks
from cea.errors import InputError
from cea.supports.constraints import Constraints, components, first_free_at
from cea.supports.directions import Directions, complement, orthonormal

_NEGLIGIBLE = 1e-14
"""Drop tolerance of coefficients, which decay exponentially with the distance of the dofs."""

_LARGEST = 1e6  # coefficient of a dependent dof above which its constraints are contradictory

_SAME = 1e-9  # relative difference of prescribed values treated as rounding


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
    first = first_free_at(dim, dofs, removed, dofs)
    total = dim * num_scalar_dofs - int(removed.sum())
    free = frame = _free_rows(complement(taken), removed, first, total)
    place = slice(len(held))
    values = _held_displacement(held, owner[place], taken, slot[place], field).ravel()
    solved = np.flatnonzero(slot[len(held) :] >= 0)
    at, row = owner[len(held) :][solved], slot[len(held) :][solved]
    # Displacement of the dofs per unit amount along the directions solved for.
    entries = (taken[at, row].ravel(), components(at, dim), dim * np.arange(len(at) + 1))
    anchors, shares = csr_array(csc_array(entries, shape=(dim * len(dofs), len(at)))), {}
    if projected and len(solved):
        columns = components(dofs, dim)
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
    rows = _rows_by_support(along, components(owner[place], dim), dim * len(dofs), shares)
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
