"""Direct factorisations: all that a driver needs of MUMPS, set up in one place.

What is factorised inside of :func:`factors_on_disk` is written to files of a temporary folder, each
rank's to its own, and read again at every solve; the system keeps as much of them in memory as is
left. A folder is locked while it is in use: those that killed programs left behind are removed.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from fcntl import LOCK_EX, LOCK_NB, flock
from functools import partial
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory, gettempdir
from time import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.blocks import by_parts
from cea.errors import ConvergenceError
from cea.matrices import dense, destroy
from cea.petsc import PETSc

_ROOM = (20, 200, 1000)
"""Room (per cent) for pivots that are delayed beyond what is foreseen: more where it runs out."""
_NO_ROOM: Any = PETSc.PC.FailedReason.FACTOR_OUTMEMORY
_LACKS_MEMORY = (-7, -8, -9, -11, -12, -13, -14, -15, -17, -19, -20)
"""Values of INFOG(1) with which MUMPS ends for lack of memory."""
_FOLDER = "mat_mumps_ooc_tmpdir"
"""Option of PETSc that names the folder of factors on disk."""
_LARGE = 10_000
"""Unknowns from which on inertia is found in panels."""
_FOLDER_OF_FACTORS: ContextVar[Path | None] = ContextVar("folder of factors", default=None)
_PREFIX, _LOCK = "factors-", "in_use"
_NEW = 60.0
"""Age (s) up to which a folder may be about to be locked."""


class SingularError(ConvergenceError):
    """A matrix that is singular, or so nearly that solutions lose their digits."""


class Mumps:
    """LU, or LDL^T of a symmetric matrix, PETSc AIJ, by MUMPS; the matrix is destroyed with it.

    With ``inertia`` its negative eigenvalues may be asked for: null pivots are counted rather than
    failed on, and with any of them systems should not be solved. SingularError when the matrix is
    singular, or the factorisation fails, MemoryError when there is no memory for the factors.
    """

    def __init__(self, matrix: Any, *, symmetric: bool, inertia: bool = False) -> None:
        self.matrix = matrix
        self._symmetric, self._inertia = symmetric, inertia
        if symmetric:
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        for room in _ROOM:
            self._pc = self._prepared(room)
            self._set_up()
            if room == _ROOM[-1] or self._pc.getFailedReason() != _NO_ROOM:
                break
            destroy(self._pc)
        if self._pc.getFailedReason() != PETSc.PC.FailedReason.NOERROR:
            rows = matrix_size(self.matrix)
            code = self._pc.getFactorMatrix().getMumpsInfog(1)
            self.free()
            if code in _LACKS_MEMORY:
                raise MemoryError(f"factors of {rows} rows: MUMPS ends with INFOG(1) = {code}")
            raise SingularError(f"a matrix of {rows} rows is singular")

    def _set_up(self) -> None:
        """Factorise; PETSc reads the folder of factors from its options, and only then."""
        options: Any = PETSc.Options()
        if (folder := folder_of_factors()) is None:
            self._pc.setUp()
            return
        options.setValue(_FOLDER, str(folder))
        try:
            self._pc.setUp()
        finally:
            options.delValue(_FOLDER)

    def _prepared(self, room: int) -> Any:
        """PETSc preconditioner, set up but for the factors."""
        pc: Any = PETSc.PC().create(self.matrix.comm)
        pc.setOperators(self.matrix)
        pc.setType(PETSc.PC.Type.CHOLESKY if self._symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        pc.setFactorSetUpSolverType()
        factor = pc.getFactorMatrix()
        factor.setMumpsIcntl(14, room)
        factor.setMumpsIcntl(22, int(folder_of_factors() is not None))
        if self._inertia:
            factor.setMumpsIcntl(13, 1)  # a parallel root hides its inertia
            factor.setMumpsIcntl(24, 1)
            if matrix_size(self.matrix) >= _LARGE:  # none of which is compressed
                factor.setMumpsIcntl(35, 2)
                factor.setMumpsCntl(7, 0.0)
        elif not self._symmetric:
            factor.setMumpsIcntl(33, 1)  # its determinant
        return pc

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Solve for every column of b, the first rows of this rank: those that follow are zero.

        The result has all rows of this rank, shape (n_local, columns), real or complex.
        """
        return by_parts(partial(self._solve, transposed=transposed), b)

    def _solve(self, b: Floats, *, transposed: bool) -> Floats:
        layout, comm = self.matrix.getSizes()[0], self.matrix.comm
        solution = np.zeros((layout[0], b.shape[1]), order="F")
        if not b.shape[1]:  # which MUMPS refuses: an empty window has no eigenvectors
            return solution
        if len(b) < layout[0]:
            whole = np.zeros_like(solution)
            whole[: len(b)] = b
            b = whole
        right, left = dense(b, layout, comm), dense(solution, layout, comm)
        (self._pc.matApplyTranspose if transposed else self._pc.matApply)(right, left)
        destroy(right, left)
        return solution

    def inertia(self) -> tuple[int, int]:
        """Numbers of negative eigenvalues of a symmetric A, and of pivots that count as zero."""
        negative, null, _ = self._pc.getFactorMatrix().getInertia()
        return int(negative), int(null)

    def sign(self) -> int:
        """Sign of the determinant of an unsymmetric A."""
        return int(np.sign(self._pc.getFactorMatrix().getMumpsRinfog(12)))

    def free(self) -> None:
        """Free the factors and the matrix."""
        destroy(self._pc, self.matrix)


def inertia(matrix: Any) -> tuple[int, int]:
    """The inertia of a symmetric matrix, as of its factors; the matrix is destroyed."""
    factors = Mumps(matrix, symmetric=True, inertia=True)
    found = factors.inertia()
    factors.free()
    return found


def matrix_size(matrix: Any) -> int:
    """Number of rows over all ranks."""
    return int(matrix.getSize()[0])


def folder_of_factors() -> Path | None:
    """Where factors are written now; None where they stay in memory."""
    return _FOLDER_OF_FACTORS.get()


@contextmanager
def factors_on_disk() -> Iterator[Path]:
    """Keep factors on disk while this lasts; they must be freed before it ends."""
    _remove_left_behind(Path(gettempdir()))
    with TemporaryDirectory(prefix=_PREFIX) as name, (Path(name) / _LOCK).open("w") as lock:
        flock(lock, LOCK_EX)
        token = _FOLDER_OF_FACTORS.set(Path(name))
        try:
            yield Path(name)
        finally:
            _FOLDER_OF_FACTORS.reset(token)


def _remove_left_behind(parent: Path) -> None:
    """Remove folders of factors that no program uses any more."""
    for path in parent.glob(f"{_PREFIX}*/{_LOCK}"):
        with suppress(OSError):  # in use, of somebody else, or just removed
            if time() - path.stat().st_mtime > _NEW:
                with path.open() as lock:
                    flock(lock, LOCK_EX | LOCK_NB)
                    rmtree(path.parent)
