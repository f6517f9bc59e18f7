"""Scenes, runs, comparisons and reports: the room that knows all others."""

import cea  # noqa: F401  (brings the PETSc stack into a safe order ahead of mpi4py)
