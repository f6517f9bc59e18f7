"""Displacements that supports prescribe, beside what they leave free.

With u = Z v + u_D, u_D the displacement of held dofs at the prescribed values and zero elsewhere,
the equilibrium of the free dofs is Z^T K Z v = Z^T F - Z^T K u_D.
"""

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.supports.directions import Directions

_SAME = 1e-9
"""Difference of values, relative to the largest, that is taken for rounding."""


def held_displacement(
    held: Directions, owner: Ints, taken: Floats, slot: Ints, field: str
) -> Floats:
    """Displacement of dofs that are held at values along directions, shape (dofs, dim)."""
    along = np.einsum("nki,ni->nk", taken[owner], held.direction)
    amount = np.zeros(taken.shape[:2])
    for k in range(taken.shape[1]):
        new = np.flatnonzero(slot == k)
        before = np.einsum("nj,nj->n", along[new, :k], amount[owner[new], :k])
        amount[owner[new], k] = (held.values[new] - before) / along[new, k]
    _check(held, owner, taken, along, amount, field)
    return np.einsum("nk,nki->ni", amount, taken)


def _check(
    held: Directions, owner: Ints, taken: Floats, along: Floats, amount: Floats, field: str
) -> None:
    """Refuse values that contradict each other, as far as their directions are the same."""
    spanned = np.einsum("nk,nki->ni", along, taken[owner])
    sine = np.linalg.norm(held.direction - spanned, axis=1)
    wrong = np.abs(held.values - np.einsum("nk,nk->n", along, amount[owner]))
    largest = np.abs(held.values).max(initial=0.0)
    if len(wrong) and (wrong > (_SAME + 4 * sine) * largest).any():
        value = float(held.values[np.argmax(wrong)])
        allowed = "the value of the other supports that hold the same component at an edge"
        raise InputError(f"{field}.value", value, allowed)
