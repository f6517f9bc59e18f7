"""Options of the eigenvalue search."""

from dataclasses import dataclass


@dataclass(frozen=True)
class KrylovOptions:
    """Options of the block Krylov-Schur method and of the search of a window.

    Parameters
    ----------
    block
        Columns of a block.
    tolerance
        Residual relative to theta below which a wanted eigenvalue has converged.
    loose
        The same of eigenvalues in a disc that are not wanted, and at which random vectors are
        appended.
    random_columns, random_steps
        Random vectors appended to the last block to verify that nothing is missing, and least
        block steps with them.
    first_check
        Blocks of a Krylov space before its Ritz values are looked at.
    growth
        Most growth of the space between two Ritz checks.
    restart
        Size of the space, relative to the Ritz values in the disc, at which it is restarted.
    max_restarts
        Restarts before a search is given up.
    max_discs
        Most discs beyond the first.
    dense_limit
        Most rows of an operator whose eigenvalues LAPACK computes.
    """

    block: int = 8
    tolerance: float = 1e-13
    loose: float = 1e-6
    random_columns: int = 4
    random_steps: int = 4
    first_check: int = 6
    growth: float = 1.3
    restart: float = 3.5
    max_restarts: int = 200
    max_discs: int = 3
    dense_limit: int = 1000
