"""What both backends share: contact algebra, coupled matrices, the eigenvalue driver.

Importing this package brings the PETSc stack into a safe order, once, for every other module.
"""

import dolfinx_solver  # noqa: F401  (orders MPI ahead of petsc4py, slepc4py and dolfinx)
