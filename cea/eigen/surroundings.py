"""What lies around a disc that was searched.

When the eigenvalues in a disc have converged, some of those around it nearly have. They are no
results, but a search in random directions beside all of them sees nothing that is near the shift,
and is sooner sure that nothing in the disc was missed: what would be missing stands alone.
"""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes
from cea.eigen.krylov_space import KrylovSpace
from cea.eigen.subspace import InvariantSubspace
from cea.errors import ConvergenceError

PAIR = 1e-9
"""Relative distance of moduli up to which eigenvalues stay together, as conjugate ones must."""


class Searcher(Protocol):
    """What searches a disc beside an invariant subspace."""

    def search(
        self,
        known: InvariantSubspace,
        radius: float,
        seed: int,
        *,
        both_ends: bool = False,
        surrounded: bool = False,
    ) -> InvariantSubspace:
        """What is known together with what lies beside it in the disc."""
        ...


def leading(theta: Complexes, chosen: NDArray[np.bool_]) -> int:
    """Number of the largest theta that are all chosen; no conjugates are parted."""
    order = np.argsort(-np.abs(theta))
    number = len(order) if chosen.all() else int(np.argmin(chosen[order]))
    if 0 < number < len(order):
        last, beyond = theta[order[number - 1]], theta[order[number]]
        number -= int(last.imag != 0 and np.isclose(last.conj(), beyond, rtol=PAIR, atol=0.0))
    return number


def with_more(
    known: InvariantSubspace,
    space: KrylovSpace,
    form: NDArray[Any],
    own: NDArray[Any],
    both: NDArray[Any],
    shift: complex,
) -> tuple[InvariantSubspace, InvariantSubspace]:
    """Invariant subspaces of a space that began beside nothing: one, and one with more around it.

    The first has the leading vectors of the second, in the same memory.

    Parameters
    ----------
    known
        The subspace of nothing.
    space
        Where they were found.
    form, own
        Schur form of the first on the square of the space, and its orthonormal vectors.
    both
        Orthonormal vectors of the square that span more with them.
    shift
        That of the operator.
    """
    apart = both - own @ (own.conj().T @ both)
    more = np.linalg.svd(apart)[0][:, : both.shape[1] - own.shape[1]]
    images = space.square @ more
    basis = space.combined(np.hstack([own, more]))
    found = known.within(basis[:, : own.shape[1]], space.coupling @ own, form, shift)
    return found, found.within(basis, own.conj().T @ images, more.conj().T @ images, shift)


def nothing_beside(
    krylov: Searcher, around: InvariantSubspace, shift: float, radius: float, seed: int
) -> bool:
    """Whether a disc holds nothing but what is known in it and around it.

    Parameters
    ----------
    krylov
        Searches discs about the shift.
    around
        What is known.
    shift, radius
        The disc (1/s^2).
    seed
        Of the random start vectors.
    """
    try:
        found = krylov.search(around, radius, seed, both_ends=True, surrounded=True)
    except ConvergenceError:
        return False
    return not (np.abs(found.eigenvalues(around.size) - shift) < radius).any()
