"""A damped or rotating pencil factorised at a real or complex shift: s^2 M + s (C + Y) + K.

Scalars are real. At a complex s this P(s) is factorised as a real matrix of twice its rows,

    [ Re P  -Im P ] [ Re x ]   [ Re b ]
    [ Im P   Re P ] [ Im x ] = [ Im b ],

real and imaginary part of an unknown one after the other, so that the order of elimination is that
of P. There are four times the factors of a real shift, and a solve takes twice the time. Factors of
Re P with steps of GMRES instead take some thirty steps a solve and are slower by far. Contact
forces that are unknowns stand beside the displacements (:mod:`cea.eigen.shifted`).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, kron

from cea.body import Floats
from cea.eigen.factorisation import Mumps
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import bordered, force_scale
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
        self._symmetric = matrices.symmetric and matrices.gyroscopic is None and not self._complex
        self._forces = matrices.multipliers
        self._scale: Any | None = None
        operator = self._operator()
        self._rows = operator.getLocalSize()[0]
        if self._complex:
            operator = self._doubled(operator)
        self._factors = Mumps(operator, symmetric=self._symmetric)

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
        solution = self._solved(b, transposed=transposed)
        end = self._local
        if self._scale is None:
            return solution, solution[end:]
        scale = self._scale.array_r[:, None]
        return solution[:end], solution[end : end + len(scale)] * scale

    def _solved(self, b: NDArray[Any], *, transposed: bool) -> NDArray[Any]:
        n = b.shape[1]
        if self._complex:
            # The transposed of the real matrix is that of the conjugate transposed of P.
            b = b.conj() if transposed else b
            whole = np.zeros((2 * self._rows, n), order="F")
            whole[0 : 2 * self._local : 2] = b.real
            whole[1 : 2 * self._local : 2] = b.imag
            solution = self._factors.solve_block(whole, transposed=transposed)
            result = solution[0::2] + 1j * solution[1::2]
            return result.conj() if transposed else result
        parts = np.hstack([b.real, b.imag]) if np.iscomplexobj(b) else b
        whole = parts
        if self._rows > self._local:
            whole = np.zeros((self._rows, parts.shape[1]), order="F")
            whole[: self._local] = parts
        solution = self._factors.solve_block(whole, transposed=transposed)
        return solution[:, :n] + 1j * solution[:, n:] if np.iscomplexobj(b) else solution

    def parity(self) -> int | None:
        """Whether the number of real eigenvalues beyond a real shift is odd (1) or even (0).

        The determinant of P(s) with m contact forces has the sign of (-1)^m far to the right, and
        changes it at each real eigenvalue. None where that is not known: for symmetric matrices,
        complex shifts, forces without compliance.
        """
        if self._symmetric or self._complex:
            return None
        count = 0
        if self._forces is not None:
            if self._forces.tied:
                return None
            count = self._forces.size
        return int(self._factors.sign() != (-1) ** count)

    def free(self) -> None:
        """Free the factors."""
        self._factors.free()
        if self._scale is not None:
            destroy(self._scale)


class Damping:
    """D = C + Y, what multiplies lambda.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    """

    def __init__(self, matrices: Matrices) -> None:
        pieces = [m for m in (matrices.damping, matrices.gyroscopic) if m is not None]
        self.matrix = scaled_total([(1.0, piece) for piece in pieces]) if pieces else None

    def free(self) -> None:
        """Free the matrix."""
        if self.matrix is not None:
            destroy(self.matrix)


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
