"""A damped or rotating pencil factorised at a real or complex shift: s^2 M + s (C + Y) + K.

Scalars are real. At a complex s this P(s) is factorised as a real matrix of twice its rows,

    [ Re P  -Im P ] [ Re x ]   [ Re b ]
    [ Im P   Re P ] [ Im x ] = [ Im b ],

real and imaginary part of an unknown one after the other, so that the order of elimination is that
of P. There are four times the factors of a real shift, and a solve takes twice the time. Factors of
Re P with steps of GMRES instead take some thirty steps a solve and are slower by far. Contact
forces that are unknowns stand beside the displacements (:mod:`cea.eigen.shifted`). Pieces of C of
low rank stay out of the factors (:mod:`cea.eigen.low_rank_update`), and so do circulatory pieces of
K where they are small (:mod:`cea.eigen.neumann`); otherwise they are unknowns beside the forces.
Windows are searched about real shifts, single eigenvalues about complex ones.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, kron

from cea.arrays import Floats
from cea.eigen.blocks import image_of, transposed_times
from cea.eigen.circulatory import CirculatorySum
from cea.eigen.low_rank_update import LowRankUpdate, Solver
from cea.eigen.multipliers import with_circulatory
from cea.eigen.mumps import Mumps
from cea.eigen.neumann import NeumannSeries
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import bordered, force_scale
from cea.errors import ConvergenceError
from cea.matrices import destroy, distributed, local_part, scaled_total

_ROTATION = np.array([[0.0, -1.0], [1.0, 0.0]])
"""i, on real and imaginary part."""


class QuadraticShifted:
    """P(s) factorised; what a driver solves for displacements with.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    shift
        s (1/s), real or complex.

    Raises
    ------
    ConvergenceError
        When P(s) is singular.
    """

    def __init__(self, matrices: Matrices, shift: complex) -> None:
        self.matrices, self.shift = matrices, shift
        self._local = matrices.stiffness.getLocalSize()[0]
        self._complex = isinstance(shift, complex) and shift.imag != 0
        symmetric = matrices.symmetric and matrices.gyroscopic is None
        self._symmetric = symmetric and not self._complex
        self._forces = matrices.multipliers
        self._scale: Any | None = None
        self._factors: _Factors | None = None
        self._update: LowRankUpdate | None = None
        circulatory = matrices.circulatory
        if circulatory is None or not self._is_small(circulatory):
            if circulatory is not None:
                self._forces = with_circulatory(matrices.multipliers, circulatory)
            self._solver: Solver = self._factorised()

    def _is_small(self, circulatory: CirculatorySum) -> bool:
        """Whether circulatory pieces are small beside the rest, whose factors serve then."""
        try:
            self._solver = NeumannSeries(
                self._factorised(),
                circulatory,
                rows=self._rows,
                local=self._local,
                comm=self.matrices.stiffness.comm,
            )
        except ConvergenceError:
            self._free_factors()
            return False
        return True

    def _factorised(self) -> Solver:
        """Factors with the forces, and what solves with the pieces of low rank too."""
        operator = self._operator()
        self._rows = operator.getLocalSize()[0]
        if self._complex:
            operator = self._doubled(operator)
        factors = self._factors = _Factors(operator, self._rows, symmetric=self._symmetric)
        if self.matrices.low_rank is None:
            return factors
        try:
            self._update = LowRankUpdate(
                factors,
                self.matrices.low_rank.root(),
                self.shift,
                rows=self._rows,
                symmetric=self.matrices.symmetric and self.matrices.gyroscopic is None,
                comm=self.matrices.stiffness.comm,
            )
        except ConvergenceError:
            self.free()
            raise
        return self._update

    def _operator(self) -> Any:
        """Re P(s), with the contact forces."""
        square, linear = complex(self.shift**2).real, complex(self.shift).real
        operator = _sum_of(self.matrices, square, linear, stiffness=True)
        if self._forces is None:
            return operator
        self._scale = force_scale(operator, self._forces)
        whole = bordered(operator, self._forces, self._scale, symmetric=self._symmetric)
        destroy(operator)
        return whole

    def _doubled(self, real: Any) -> Any:
        """The real matrix of twice the rows; forces have no imaginary part of their own."""
        own = _sum_of(
            self.matrices, (self.shift**2).imag, complex(self.shift).imag, stiffness=False
        )
        first, second = _twice(local_part(real), np.eye(2)), _twice(local_part(own), _ROTATION)
        columns = real.getSizes()[1]
        offsets = _offsets(own, real)
        ends = np.pad(second.indptr, (0, first.shape[0] - second.shape[0]), mode="edge")
        moved = csr_array((second.data, offsets[second.indices], ends), shape=first.shape)
        total = csr_array(first + moved)
        matrix = distributed(total, (2 * columns[0], 2 * columns[1]), real.comm)
        destroy(real, own)
        return matrix

    def solve_with_forces(
        self, b: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Displacements and contact forces for every column of forces, the rows of this rank.

        Columns may be complex; results are where they or the shift are.

        Returns
        -------
        tuple
            Shapes (n_local, columns) and (multipliers of this rank, columns).
        """
        whole = b
        if self._rows > self._local:
            whole = np.zeros((self._rows, b.shape[1]), dtype=b.dtype, order="F")
            whole[: self._local] = b
        solution = self._solver.solve(whole, transposed=transposed)
        end, forces = self._local, self.matrices.multipliers
        if self._scale is None or forces is None:
            return solution[:end], solution[end:end]
        scale = self._scale.array_r[: forces.compliance.getLocalSize()[0], None]
        return solution[:end], solution[end : end + len(scale)] * scale

    def parity(self) -> int | None:
        """Whether the number of real eigenvalues beyond a real shift is odd (1) or even (0).

        The determinant of P(s) with m contact forces has the sign of (-1)^m far to the right, and
        changes it at each real eigenvalue. Pieces that a Neumann series brings in do not change it:
        with any part of them the matrix is regular. None where it is not known: for symmetric
        matrices, complex shifts, forces without compliance.
        """
        if self._symmetric or complex(self.shift).imag:
            return None
        count = 0
        if self._forces is not None:
            if self._forces.tied:
                return None
            count = self._forces.size
        assert self._factors is not None
        sign = self._factors.sign() * (1 if self._update is None else self._update.sign())
        return int(sign != (-1) ** count)

    def free(self) -> None:
        """Free the factors."""
        self._free_factors()
        if self._forces is not None and self._forces is not self.matrices.multipliers:
            self._forces.free()

    def _free_factors(self) -> None:
        if self._factors is not None:
            self._factors.free()
        if self._scale is not None:
            destroy(self._scale)
        self._factors = self._update = self._scale = None


class _Factors:
    """A real or complex matrix factorised as a real one.

    Parameters
    ----------
    matrix
        The real one, PETSc AIJ: of so many rows on this rank, or of twice as many where the matrix
        is complex.
    rows
        Rows of the real or complex matrix on this rank.
    symmetric
        Whether the real one is symmetric.

    Raises
    ------
    ConvergenceError
        When it is singular.
    """

    def __init__(self, matrix: Any, rows: int, *, symmetric: bool) -> None:
        self._doubled = matrix.getLocalSize()[0] > rows
        self._mumps = Mumps(matrix, symmetric=symmetric)

    def solve(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Solutions for every column of b, which may be complex, shape (rows, columns)."""
        return self._real(self._mumps.solve_block, b, transposed=transposed)

    def times(self, x: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """The matrix, or its transposed, times every column of x, shape (rows, columns)."""
        return self._real(self._product, x, transposed=transposed)

    def _product(self, x: Floats, *, transposed: bool) -> Floats:
        if transposed:
            return transposed_times(self._mumps.matrix, x.astype(complex)).real
        return image_of(self._mumps.matrix, x)

    def _real(
        self, act: Callable[..., Floats], b: NDArray[Any], *, transposed: bool
    ) -> NDArray[Any]:
        """What the real matrix does to columns of the real or complex one."""
        if self._doubled:
            # The transposed of the real matrix is that of the conjugate transposed of P.
            b = b.conj() if transposed else b
            whole = np.empty((2 * len(b), b.shape[1]), order="F")
            whole[0::2], whole[1::2] = b.real, b.imag
            image = act(whole, transposed=transposed)
            result = image[0::2] + 1j * image[1::2]
            return result.conj() if transposed else result
        if not np.iscomplexobj(b):
            return act(b, transposed=transposed)
        n = b.shape[1]
        image = act(np.hstack([b.real, b.imag]), transposed=transposed)
        return image[:, :n] + 1j * image[:, n:]

    def sign(self) -> int:
        """Sign of the determinant of an unsymmetric real matrix."""
        return self._mumps.sign()

    def free(self) -> None:
        """Free the factors."""
        self._mumps.free()


def _sum_of(matrices: Matrices, square: float, linear: float, *, stiffness: bool) -> Any:
    """A sum of M and C + Y, and of K where it is asked for: a new PETSc AIJ matrix."""
    parts = [(square, matrices.mass)]
    if stiffness:
        parts = [(1.0, matrices.stiffness), *parts]
        if matrices.unsymmetric is not None:
            parts.append((1.0, matrices.unsymmetric))
    parts += [(linear, m) for m in (matrices.damping, matrices.gyroscopic) if m is not None]
    return scaled_total(parts)


def _twice(rows: csr_array, small: Floats) -> csr_array:
    """Rows with each entry a times a small matrix in its place."""
    return csr_array(kron(rows, small, format="csr"))


def _offsets(own: Any, whole: Any) -> NDArray[np.int64]:
    """Columns of the doubled displacements among the doubled unknowns, on all ranks."""
    comm = own.comm.tompi4py()
    mine, all_rows = own.getLocalSize()[1], comm.allgather(whole.getLocalSize()[1])
    counts = comm.allgather(mine)
    starts = np.cumsum([0, *all_rows[:-1]])
    places = [start + np.arange(count) for start, count in zip(starts, counts, strict=True)]
    columns = np.concatenate(places)
    return np.stack([2 * columns, 2 * columns + 1], axis=1).ravel()
