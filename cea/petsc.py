"""MPI, PETSc and SLEPc: the one place that brings them in, in the order they need.

The wheel `dolfinx_solver` must be imported ahead of petsc4py, slepc4py, mpi4py and dolfinx. Other
modules take all of them from here, and import this module before they import dolfinx.
"""

import dolfinx_solver  # noqa: F401  (must come first)
from mpi4py import MPI
from petsc4py import PETSc
from slepc4py import SLEPc

from cea.heap import keep_freed_memory
from cea.signals import ignore_closed_pipes

ignore_closed_pipes()
keep_freed_memory()

Mat = PETSc.Mat
"""A distributed matrix."""
Vec = PETSc.Vec
"""A distributed vector."""

__all__ = ["MPI", "Mat", "PETSc", "SLEPc", "Vec"]
