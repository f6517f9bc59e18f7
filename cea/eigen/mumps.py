"""Direct factorisations by MUMPS.

Inside :func:`factors_on_disk` MUMPS writes factors to files of a temporary folder, one set for each
rank, and reads them at every solve; the operating system caches them in free memory.
"""

import resource
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.block_products import by_parts, times, transposed_times
from cea.errors import ConvergenceError
from cea.matrices import dense, destroy
from cea.petsc import MPI, PETSc, give_back

_ROOM = (20, 200, 1000)
"""Workspace beyond the estimate (per cent, ICNTL(14)), tried in turn while MUMPS runs out of it."""
_NO_ROOM: Any = PETSc.PC.FailedReason.FACTOR_OUTMEMORY
_LACKS_MEMORY = (-7, -8, -9, -11, -12, -13, -14, -15, -17, -19, -20)
"""Values of INFOG(1) by which MUMPS reports lack of memory."""
_ACCURATE = 1e-10
"""Relative change by a step of iterative refinement above which every solve is refined."""
_PART = 0.9
"""Fraction of the free memory that factors may take."""
_FILL, _ENTRY, _MEGABYTE = 100.0, 12, 1e6
"""Upper bound of the fill ratio (memory of factors over matrix), bytes per entry, and per MB."""
_FOLDER = "mat_mumps_ooc_tmpdir"
"""PETSc option that names the folder of factors on disk."""
_FOLDER_OF_FACTORS: ContextVar[Path | None] = ContextVar("folder of factors", default=None)


class SingularError(ConvergenceError):
    """The matrix is singular, or so nearly singular that solutions lose their digits."""


class NoRoomError(MemoryError):
    """The factors exceed the free memory by the estimate of MUMPS.

    In bytes of all ranks: ``memory`` of the factorisation, ``with_files`` the same with factors on
    disk, ``files`` the size of these, and ``free`` the free memory.
    """

    def __init__(self, message: str, memory: float, with_files: float, files: float, free: float):
        self.memory, self.with_files, self.files, self.free = memory, with_files, files, free
        super().__init__(message)


class Mumps:
    """LU factors, or LDL^T of a symmetric matrix, by MUMPS; they own the matrix, PETSc AIJ.

    With ``inertia`` null pivots are counted instead of causing failure, as :meth:`inertia` needs;
    if there are any, systems must not be solved. SingularError when the matrix is singular or the
    factorisation fails, NoRoomError when the factors exceed the free memory.
    """

    def __init__(self, matrix: Any, *, symmetric: bool, inertia: bool = False) -> None:
        self.matrix = matrix
        self._symmetric, self._inertia = symmetric, inertia
        self._refine: bool | None = None  # None until the first solve
        if symmetric:
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        limit = self._limit()
        for room in _ROOM:
            self._pc = self._prepared(room, limit)
            self.factorise()
            if room == _ROOM[-1] or self._pc.getFailedReason() != _NO_ROOM:
                break
            destroy(self._pc)
        if self._pc.getFailedReason() != PETSc.PC.FailedReason.NOERROR:
            self._fail()

    def _limit(self) -> int:
        """Return the memory (MB) that factors may take on each rank; 0 where it surely suffices.

        With a limit MUMPS allocates all of it as one array.
        """
        comm = self.matrix.comm.tompi4py()
        entries = self.matrix.getInfo(PETSc.Mat.InfoType.GLOBAL_MAX)["nz_used"]
        if _FILL * _ENTRY * entries < free_memory(comm):
            return 0
        give_back()
        return max(1, int(free_memory(comm) / _MEGABYTE))

    def _infog(self, number: int) -> int:
        return int(self._pc.getFactorMatrix().getMumpsInfog(number))

    def _fail(self) -> None:
        """Free the factors and raise the error that ended the factorisation."""
        free = self.matrix.comm.getSize() * free_memory(self.matrix.comm.tompi4py())
        rows, code, entries = self.matrix.getSize()[0], self._infog(1), self._infog(3)
        memory, with_files = (_MEGABYTE * self._infog(number) for number in (17, 27))
        files = 8.0 * (entries if entries >= 0 else -1e6 * entries)
        self.free()
        if code not in _LACKS_MEMORY:
            raise SingularError(f"a matrix of {rows} rows is singular")
        needed, less, there = (f"{each / 1e9:.3g} GB" for each in (memory, with_files, free))
        message = f"the factors of {rows} unknowns take {needed} of memory, or {less} with factors "
        message += f"on disk; {there} are free (MUMPS, INFOG(1) = {code})"
        raise NoRoomError(message, memory, with_files, files, free)

    def factorise(self) -> None:
        """Factorise if the matrix has changed."""
        options: Any = PETSc.Options()  # of the folder of factors
        if (folder := folder_of_factors()) is None:
            self._pc.setUp()
            return
        options.setValue(_FOLDER, str(folder))
        try:
            self._pc.setUp()
        finally:
            options.delValue(_FOLDER)

    def _prepared(self, room: int, limit: int) -> Any:
        """Return a PETSc preconditioner with all options set, not yet factorised."""
        pc: Any = PETSc.PC().create(self.matrix.comm)
        pc.setOperators(self.matrix)
        pc.setType(PETSc.PC.Type.CHOLESKY if self._symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        pc.setFactorSetUpSolverType()
        factor = pc.getFactorMatrix()
        factor.setMumpsIcntl(14, room)
        factor.setMumpsIcntl(22, int(folder_of_factors() is not None))
        if limit:
            factor.setMumpsIcntl(23, limit)
        if self._inertia:
            factor.setMumpsIcntl(13, 1)  # a parallel root hides its inertia
            factor.setMumpsIcntl(24, 1)
        elif not self._symmetric:
            factor.setMumpsIcntl(33, 1)  # its determinant
        return pc

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Solve for every column of b, which holds the first rows of this rank; the rest is zero.

        The result has all rows of this rank, shape (n_local, columns), real or complex. If the
        first solve lost digits, as with nearly dependent constraints, every solve takes a step of
        iterative refinement.
        """
        return by_parts(partial(self._refined, transposed=transposed), b)

    def _refined(self, b: Floats, *, transposed: bool) -> Floats:
        solution = self._solve(b, transposed=transposed)
        if self._refine is False or not b.shape[1]:
            return solution
        residual = -(transposed_times if transposed else times)(self.matrix, solution)
        residual[: len(b)] += b
        change = self._solve(residual, transposed=transposed)
        if self._refine is None:
            both = np.array([np.vdot(each, each) for each in (change, solution)])
            moved, whole = self.matrix.comm.tompi4py().allreduce(both)
            if whole > 0:
                self._refine = bool(moved > _ACCURATE**2 * whole)
        return solution + change

    def _solve(self, b: Floats, *, transposed: bool) -> Floats:
        layout, comm = self.matrix.getSizes()[0], self.matrix.comm
        solution = np.zeros((layout[0], b.shape[1]), order="F")
        if not b.shape[1]:  # MUMPS rejects it: an empty window has no eigenvectors
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
        """Return the numbers of negative eigenvalues of a symmetric A, and of null pivots."""
        negative, null, _ = self._pc.getFactorMatrix().getInertia()
        return int(negative), int(null)

    def sign(self) -> int:
        """Return the sign of the determinant of an unsymmetric A."""
        return int(np.sign(self._pc.getFactorMatrix().getMumpsRinfog(12)))

    def free(self) -> None:
        """Free the factors and the matrix."""
        destroy(self._pc, self.matrix)


def free_memory(comm: Any) -> float:
    """Return the share of free memory (bytes) that each rank may use; collective.

    Limits of the process and of its control group count where they are lower.
    """
    page = resource.getpagesize()
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()
    size, resident = (page * int(number) for number in pages[:2])
    lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    free = [1024 * float(line.split()[1]) for line in lines if line.startswith("MemAvailable:")]
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    if soft != resource.RLIM_INFINITY:
        free.append(soft - size)
    for file in ("memory.max", "memory/memory.limit_in_bytes"):
        with suppress(OSError, ValueError):  # no such group, or no limit
            free.append(float((Path("/sys/fs/cgroup") / file).read_text()) - resident)
    neighbours = comm.Split_type(MPI.COMM_TYPE_SHARED)
    own = _PART * max(0.0, min(free)) / neighbours.size
    neighbours.Free()
    return float(comm.allreduce(own, MPI.MIN))


def inertia(matrix: Any) -> tuple[int, int]:
    """Return the inertia of a symmetric matrix (:meth:`Mumps.inertia`), which is destroyed."""
    factors = Mumps(matrix, symmetric=True, inertia=True)
    found = factors.inertia()
    factors.free()
    return found


def folder_of_factors() -> Path | None:
    """Return the folder to which factors are written; None where they stay in memory."""
    return _FOLDER_OF_FACTORS.get()


@contextmanager
def factors_on_disk() -> Iterator[Path]:
    """Keep factors on disk inside the context; they must be freed before it ends."""
    with TemporaryDirectory(prefix="factors-") as name:
        token = _FOLDER_OF_FACTORS.set(Path(name))
        try:
            yield Path(name)
        finally:
            _FOLDER_OF_FACTORS.reset(token)
