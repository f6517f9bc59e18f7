"""Systems with A + s B B^T + E by factors of A: E is small, B has few columns.

With Z = A^-1 B (Sherman, Morrison and Woodbury)

    (A + s B B^T)^-1 = A^-1 - s Z (1 + s B^T Z)^-1 B^T A^-1.

Steps of iterative refinement, x + (A + s B B^T)^-1 (b - (A + s B B^T + E) x), bring back the digits
that cancel where A is nearly singular and the sum is not, and are a Neumann series of E. How many
it takes is measured once, on a solution of A in which what is nearly singular stands out.
"""

from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve

from cea.arrays import Floats
from cea.eigen.blocks import column_blocks, norms, times, transposed_times
from cea.eigen.mumps import Mumps, SingularError
from cea.eigen.unformed import CirculatorySum

_MOST_STEPS = 8
"""Most steps of refinement."""
_WORTH, _EXACT = 3.0, 1e-13
"""Factor by which more steps must lessen an error to be taken, and one that is small enough."""
_UNSOLVED, _SLOW = 1e-2, 1e-10
"""Errors beyond which the sum counts as singular, and a series of E as too slow."""


class UpdatedFactors:
    """A + s B B^T + E, solved by means of A factorised.

    B (``root``, m x r) and E (``rest``) are on the first rows of this rank, of which A may have
    more. ``symmetric`` says that A is, and that there is no E. SingularError when A or the sum is
    singular, or as good as that, or E is too large.
    """

    def __init__(
        self,
        matrix: Mumps,
        root: Floats,
        shift: float,
        rest: CirculatorySum | None = None,
        *,
        symmetric: bool,
    ) -> None:
        self._matrix, self._root, self._shift, self._rest = matrix, root, shift, rest
        self._rows, self._comm = matrix.matrix.getLocalSize()[0], matrix.matrix.comm
        self._symmetric = symmetric
        self._small: dict[bool, tuple[Floats, Any]] = {}
        self._steps: dict[bool, int] = {}
        for transposed in (False,) if rest is None else (False, True):
            self._prepare(transposed)

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Solutions for every column of b, the first rows of this rank, as of :class:`Mumps`."""
        b = np.vstack([b, np.zeros((self._rows - len(b), b.shape[1]))])
        transposed = transposed and not self._symmetric
        self._prepare(transposed)
        x = self._once(b, transposed)
        for _ in range(self._steps[transposed]):
            x = x + self._once(b - self._times(x, transposed), transposed)
        return x

    def sign(self) -> int:
        """Sign of det(A + s B B^T) / det A; that of E, along which it is regular, is one."""
        factors, pivots = self._small[False][1]
        swaps = int((pivots != np.arange(len(pivots))).sum())
        return int(np.prod(np.sign(np.diag(factors)))) * (-1) ** swaps

    def _prepare(self, transposed: bool) -> None:
        """Find Z, 1 + s B^T Z and the steps; with the Z of A the formula for A^T is unstable."""
        if transposed in self._steps:
            return
        image = np.zeros((self._rows, self._root.shape[1]), order="F")
        for each in column_blocks(image.shape[1]):
            image[:, each] = self._matrix.solve_block(self._root[:, each], transposed=transposed)
        small = np.eye(image.shape[1]) + self._shift * self._inner(image)
        if not np.isfinite(small).all():
            raise SingularError("a matrix is singular without a piece of low rank")
        with catch_warnings():
            simplefilter("ignore", LinAlgWarning)  # a singular one solves nothing below
            self._small[transposed] = image, lu_factor(small, check_finite=False)
        self._steps[transposed] = self._needed(transposed)

    def _needed(self, transposed: bool) -> int:
        """Steps of refinement that lessen the error of a known solution."""
        rng = np.random.default_rng([1, self._comm.rank])
        start = rng.standard_normal((self._rows, 1))
        known = self._matrix.solve_block(start, transposed=transposed)
        known = np.asfortranarray(known / norms(known, self._comm))
        b, x, errors = self._times(known, transposed), np.zeros_like(known), []
        for _ in range(_MOST_STEPS + 1):
            x = x + self._once(b - self._times(x, transposed), transposed)
            errors.append(float(np.nan_to_num(norms(x - known, self._comm)[0], nan=np.inf)))
        least = min(errors)
        if not least <= (_UNSOLVED if self._rest is None else _SLOW):
            raise SingularError(f"a matrix with updates is singular, or far from one ({least})")
        steps = next(i for i, each in enumerate(errors) if each <= max(_WORTH * least, _EXACT))
        if self._rest is not None and steps == _MOST_STEPS and least > _EXACT:
            raise SingularError("a series that converges slowly")
        return steps

    def _once(self, b: NDArray[Any], transposed: bool) -> NDArray[Any]:
        """Solutions without E and refinement."""
        x = self._matrix.solve_block(b, transposed=transposed)
        if not self._root.shape[1]:
            return x
        image, small = self._small[transposed]
        return x - image @ (self._shift * lu_solve(small, self._inner(x), check_finite=False))

    def _times(self, x: NDArray[Any], transposed: bool) -> NDArray[Any]:
        """(A + s B B^T + E) x, or its transpose."""
        own = slice(len(self._root))
        result = (transposed_times if transposed else times)(self._matrix.matrix, x)
        result[own] += self._shift * (self._root @ self._inner(x))
        if self._rest is not None:
            result[own] += self._rest.times(x[own], transposed=transposed)
        return result

    def _inner(self, x: NDArray[Any]) -> NDArray[Any]:
        """B^T x, the same on every rank."""
        return np.asarray(self._comm.tompi4py().allreduce(self._root.T @ x[: len(self._root)]))
