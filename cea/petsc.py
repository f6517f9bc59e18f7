"""MPI, PETSc and SLEPc: the one place that brings them in, in the order they need.

The wheel `dolfinx_solver` must be imported ahead of petsc4py, slepc4py, mpi4py and dolfinx. Other
modules take all of them from here, and import this module before they import dolfinx.

Memory that is freed stays with the process: the C library would hand large blocks back, and the
system clears them page by page when they are asked for again, a tenth of the time of a large run.
"""

import ctypes

import dolfinx_solver  # noqa: F401  (must come first)
from mpi4py import MPI
from petsc4py import PETSc
from slepc4py import SLEPc

from cea.files import ignore_closed_pipes

_TRIM_THRESHOLD, _MMAP_MAX = -1, -4
"""Options of mallopt: large blocks come from the heap, which is never trimmed."""

ignore_closed_pipes()
_C = ctypes.CDLL(None)
if hasattr(_C, "mallopt"):
    _C.mallopt(_MMAP_MAX, 0)
    _C.mallopt(_TRIM_THRESHOLD, -1)


def give_back() -> None:
    """Give the memory that was freed back to the system."""
    if hasattr(_C, "malloc_trim"):
        _C.malloc_trim(0)


Mat = PETSc.Mat
"""A distributed matrix."""
Vec = PETSc.Vec
"""A distributed vector."""

__all__ = ["MPI", "Mat", "PETSc", "SLEPc", "Vec", "give_back"]
