"""Constrained directions at scalar dofs, and orthonormal frames of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats, Ints

_INDEPENDENT = 1e-3
"""Sine of the angle below which a direction depends linearly on the previous ones."""

_ALIGNED = 1e-12
"""Deviation of a span of directions from coordinate axes that is treated as rounding."""


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
