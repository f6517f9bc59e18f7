"""Factors on disk solve as those in memory do, and lack of memory is told as what it is."""

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array, kronsum

from cea.eigen.mumps import Mumps, factors_on_disk
from cea.errors import ConvergenceError
from cea.matrices import distributed
from cea.petsc import MPI, PETSc


def plate():
    """A plate of 220 x 220 unknowns."""
    steps = diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(220, 220))
    matrix = csr_array(kronsum(steps, steps))
    return distributed(matrix, matrix.shape, MPI.COMM_SELF)


def test_factors_are_in_a_folder_that_goes_with_them():
    b = np.asfortranarray(np.random.default_rng(0).normal(size=(220**2, 2)))
    in_memory = Mumps(plate(), symmetric=False)
    with factors_on_disk() as folder:
        on_disk = Mumps(plate(), symmetric=False)
        assert sum(path.stat().st_size for path in folder.iterdir()) > 8 * 220**2
        assert on_disk.solve_block(b) == pytest.approx(in_memory.solve_block(b), rel=1e-12)
        on_disk.free()
    in_memory.free()
    assert not folder.exists()


def test_lack_of_memory_is_not_told_as_a_singular_matrix():
    """MUMPS is allowed a megabyte for factors that take ten times as much."""
    PETSc.Options().setValue("mat_mumps_icntl_23", 1)
    try:
        with pytest.raises(MemoryError, match="MUMPS"):
            Mumps(plate(), symmetric=False)
    finally:
        PETSc.Options().delValue("mat_mumps_icntl_23")
    nothing = csr_array(np.diag([1.0, 0.0, 2.0]))
    with pytest.raises(ConvergenceError, match="singular"):
        Mumps(distributed(nothing, nothing.shape, MPI.COMM_SELF), symmetric=False)
