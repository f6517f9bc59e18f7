"""What both backends share: contact algebra, coupled matrices, eigenvalue drivers.

Importing this package costs nothing: :mod:`cea.petsc` brings in PETSc, where it is used.
"""

__version__ = "0.1.0"
