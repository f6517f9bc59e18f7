"""MPI, PETSc and SLEPc, imported in the order that they require.

The wheel `dolfinx_solver` must be imported before petsc4py, slepc4py, mpi4py and dolfinx. Other
modules import all of them from here, and import this module before dolfinx.

Malloc trimming is disabled: freed pages are reused instead of returned to the system, which would
clear them page by page when they are allocated again, a tenth of the time of a large run.
"""

import ctypes

import dolfinx_solver  # noqa: F401  (must come first)
from mpi4py import MPI
from petsc4py import PETSc
from slepc4py import SLEPc

from cea.files import ignore_closed_pipes

_TRIM_THRESHOLD, _MMAP_MAX = -1, -4
"""Options of mallopt: allocate large blocks on the heap, and never trim the heap."""

ignore_closed_pipes()
_C = ctypes.CDLL(None)
if hasattr(_C, "mallopt"):
    _C.mallopt(_MMAP_MAX, 0)
    _C.mallopt(_TRIM_THRESHOLD, -1)


def give_back() -> None:
    """Return freed memory to the system."""
    if hasattr(_C, "malloc_trim"):
        _C.malloc_trim(0)


Mat = PETSc.Mat
"""A distributed matrix."""
Vec = PETSc.Vec
"""A distributed vector."""

__all__ = ["MPI", "Mat", "PETSc", "SLEPc", "Vec", "give_back"]
