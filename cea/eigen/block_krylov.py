"""Block Krylov-Schur search: eigenvalues around a shift, from many start vectors at once.

With OP = (K - sigma M)^-1 M eigenvalues near the shift sigma are the largest theta = 1 / (kappa -
sigma). A block of random vectors spans the Krylov space: as many copies of an eigenvalue are found
as the block has columns, and a block is solved for at a fraction of the price of its columns one by
one. What has converged is locked; further searches stay outside of it,

    OP [Q V] = [Q V] [ T  C ]
                     [ 0  H ] + residual,

so that Q and V together remain an invariant subspace, friction or not (Stewart, A Krylov-Schur
algorithm for large eigenproblems, SIAM J. Matrix Anal. Appl. 23 (2002)).
"""

import sys
from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.eigen.blocks import image_of
from cea.eigen.dense_products import inner
from cea.eigen.krylov_run import KrylovRun, Outside
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted
from cea.eigen.slices import NO_SLICES, Plan
from cea.eigen.subspace import InvariantSubspace
from cea.timing import StageTimer


class BlockSearch(ABC):
    """Searches around one shift, beside what is known, with an operator that inverts there.

    Parameters
    ----------
    rows
        Rows of its vectors on all ranks.
    finite
        Number of finite eigenvalues of the pencil.
    shift
        The shift.
    comm
        Communicator (mpi4py).
    tolerance
        Residual of OP relative to theta below which an eigenvalue has converged.
    max_restarts
        Restarts before a search is given up.
    timer
        Counts krylov.

    Attributes
    ----------
    farthest
        Largest modulus of an eigenvalue that the space of the last search knows of beside what was
        known; infinite where it does not see the far end of the spectrum.
    around
        What the last search found with what nearly converged around its disc; None where it was
        not the first.
    """

    unknown = "kappa"
    """What the eigenvalues are called."""
    dtype: type = float
    """Of its vectors."""
    cleansing = 1
    """Times that OP takes what is infinite out of a vector by being applied."""
    most = sys.maxsize
    """Eigenvalues in a disc at which it is called crowded."""
    plan = NO_SLICES
    """When a search ends with the eigenvalues nearest to the shift."""
    reached: float | None = None
    """Radius about the shift to which it then came."""
    around: InvariantSubspace | None = None
    confirmed = False
    """Whether other random vectors, beside all that was found, saw in the end that it was all."""

    def __init__(
        self,
        rows: int,
        finite: int,
        shift: complex,
        comm: Any,
        *,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
    ) -> None:
        self.size, self.finite, self.shift, self.comm = rows, finite, shift, comm
        self.tolerance, self.max_restarts = tolerance, max_restarts
        self._timer = timer
        self.farthest = np.inf

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

        It ends when every eigenvalue of the space inside the disc has converged and the first one
        outside lies clearly outside, or when the space is exhausted.

        Parameters
        ----------
        known
            An invariant subspace found before, at any shift.
        radius
            Radius of the disc about the shift.
        seed
            Of the random start vectors.
        both_ends
            Whether the far end of the spectrum is to be seen too, and nothing taken from around
            the disc: far from the shift digits are lost to it. With ties, whose infinite
            eigenvalues are the farthest, OP is applied to the start vectors first; that hides
            finite ones too beyond some 1e10 times the shift.
        surrounded
            Whether what is known was ``around`` the disc after a search before: what is missing
            shows sooner.
        outside
            What of the disc is not wanted: it need not converge, and is not among what is found
            where it lies farther from the shift than all that is wanted.
        fresh
            Whether other random vectors take part in the last steps: see ``confirmed``.

        Raises
        ------
        ConvergenceError
            When the disc does not become full; ``best`` is the invariant subspace known so far.
        CrowdedError
            When it holds more than ``most`` eigenvalues.
        """
        with self._timer("krylov"):
            run = KrylovRun(
                self,
                known,
                radius,
                seed,
                both_ends=both_ends,
                surrounded=surrounded,
                outside=outside,
                fresh=fresh,
            )
            known = run.complete()
            self.farthest, self.reached, self.around = run.farthest, run.reached, run.around
            self.confirmed = run.confirmed
            return known

    @abstractmethod
    def apply(self, block: NDArray[Any], image: NDArray[Any]) -> NDArray[Any]:
        """OP on a block whose image is given."""

    @abstractmethod
    def image(self, block: NDArray[Any]) -> NDArray[Any]:
        """A block times the matrix of the inner product."""

    def inner(self, left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
        """Inner products of every column of one block with every column of another."""
        return self.comm.allreduce(inner(left, right))


class BlockKrylov(BlockSearch):
    """Searches of K x = kappa M x.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    factors
        The pencil factorised at the shift.
    tolerance, max_restarts, timer, plan
        Those of :class:`BlockSearch`.
    transposed
        Whether eigenvectors of K^T are searched: left ones, of conjugate eigenvalues.
    """

    def __init__(
        self,
        matrices: Matrices,
        factors: Shifted,
        *,
        tolerance: float,
        max_restarts: int,
        timer: StageTimer,
        plan: Plan = NO_SLICES,
        transposed: bool = False,
    ) -> None:
        super().__init__(
            matrices.size,
            matrices.size - matrices.tied,
            factors.kappa,
            matrices.mass.comm.tompi4py(),
            tolerance=tolerance,
            max_restarts=max_restarts,
            timer=timer,
        )
        self.plan = plan
        self._mass, self._factors, self._transposed = matrices.mass, factors, transposed

    def apply(self, block: NDArray[Any], image: NDArray[Any]) -> NDArray[Any]:
        """OP on a block whose product with M is given."""
        return self._factors.solve_block(image, transposed=self._transposed)

    def image(self, block: NDArray[Any]) -> NDArray[Any]:
        """M times a block."""
        return image_of(self._mass, block)
