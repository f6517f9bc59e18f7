"""Code shared by both backends: contact algebra, coupled matrices, eigenvalue drivers.

Importing this package is cheap: PETSc is imported by :mod:`cea.petsc` only.
"""

__version__ = "0.1.0"
