"""Searches of a disc by Krylov-Schur of SLEPc, one vector at a time: a reference for the blocks.

Each solve is one of a single vector, and of an eigenvalue of several copies one run finds one: the
next, beside what is known, finds the next. It is slower by far than :mod:`cea.eigen.block_krylov`
and shares nothing with it but factors.
"""

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import image_of
from cea.eigen.dense_products import inner, subtract
from cea.eigen.krylov_run import Outside
from cea.eigen.nearest import NearestSearch
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted
from cea.eigen.subspace import InvariantSubspace
from cea.timing import StageTimer

_FIRST = 16
"""Eigenvalues asked for at first; twice as many where they do not reach the end of the disc."""
_DEPENDENT = 1e-10
"""Square of a direction, relative to the largest, below which it is not one of its own."""


class SlepcSearch:
    """Searches around one shift, beside what is known.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    factors
        The pencil factorised at the shift.
    tolerance, max_restarts, timer, transposed
        As of :class:`cea.eigen.block_krylov.BlockKrylov`.

    Attributes
    ----------
    farthest
        Infinite: the far end of the spectrum is not seen.
    reached
        None: discs are searched whole.
    around, confirmed
        None and False: eigenvalues around a disc are not kept, and no vectors join.
    """

    farthest = np.inf
    reached = None
    around = None
    confirmed = False

    def __init__(
        self,
        matrices: Matrices,
        factors: Shifted,
        *,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
        transposed: bool = False,
    ) -> None:
        self._mass, self._factors, self._transposed = matrices.mass, factors, transposed
        self._finite = matrices.size - matrices.tied
        self._nearest = NearestSearch(
            matrices, factors, tolerance, max_restarts, timer, transposed=transposed
        )
        self._timer = timer
        self._comm = matrices.mass.comm.tompi4py()

    def search(
        self,
        known: InvariantSubspace,
        radius: float,
        seed: int,
        *,
        both_ends: bool = False,
        surrounded: bool = False,
        outside: Outside | None = None,
        fresh: bool = False,
    ) -> InvariantSubspace:
        """What is known together with what lies beside it in a disc.

        Parameters
        ----------
        known
            An invariant subspace found before, at any shift.
        radius
            Radius of the disc about the shift.
        seed
            Of the random start vector.
        both_ends, surrounded, outside, fresh
            As of :meth:`cea.eigen.block_krylov.BlockSearch.search`; they change nothing here.

        Raises
        ------
        ConvergenceError
            When the disc does not become full.
        """
        del both_ends, surrounded, outside, fresh
        left, wanted = self._finite - known.size, _FIRST
        while left > 0:
            kappa, vectors = self._nearest.nearest(min(wanted, left), known.basis, seed)
            distances = np.abs(kappa - self._factors.kappa)
            if len(kappa) >= left or distances.max() > radius:
                return self._with(known, kappa, vectors, distances <= radius)
            wanted *= 2
        return known

    def _with(
        self,
        known: InvariantSubspace,
        kappa: Complexes,
        vectors: Complexes,
        inside: NDArray[np.bool_],
    ) -> InvariantSubspace:
        """The known with the span of some vectors, which is invariant beside it."""
        chosen = np.flatnonzero(inside & (kappa.imag >= 0))
        oscillate = chosen[kappa[chosen].imag > 0]
        v = np.asfortranarray(np.hstack([vectors[:, chosen].real, vectors[:, oscillate].imag]))
        if not v.shape[1]:
            return known
        with self._timer("krylov"):
            for _ in range(2):
                subtract(v, known.basis, self._inner(known.basis, image_of(self._mass, v)))
                squares, axes = np.linalg.eigh(self._inner(v, image_of(self._mass, v)))
                kept = squares > _DEPENDENT * squares.max()
                v = np.asfortranarray(v @ (axes[:, kept] / np.sqrt(squares[kept])))
            step = self._factors.solve_block(image_of(self._mass, v), transposed=self._transposed)
            image = image_of(self._mass, step)
        coupling, form = self._inner(known.basis, image), self._inner(v, image)
        return known.extended(v, coupling, form, self._factors.kappa)

    def _inner(self, left: Floats, right: Floats) -> Floats:
        return np.asarray(self._comm.allreduce(inner(left, right)))
