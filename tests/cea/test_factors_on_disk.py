"""Folders of factors: those in use stay, those that killed programs left behind go."""

import os
import signal
import subprocess
import sys
import tempfile
from time import time

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array, kronsum

from cea.eigen.mumps import Mumps, factors_on_disk, folder_of_factors
from cea.errors import ConvergenceError
from cea.matrices import distributed
from cea.petsc import MPI, PETSc

HOLDS = """
from time import sleep
from cea.eigen.mumps import factors_on_disk
with factors_on_disk() as folder:
    (folder / "factors").write_bytes(b"0" * 1000)
    print(folder, flush=True)
    sleep(60)
"""


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return tmp_path


def grown_old(folder):
    """Make the lock of a folder as old as that of a long run."""
    before = time() - 3600
    os.utime(folder / "in_use", (before, before))


def test_a_folder_goes_when_factors_are_freed(own_folder):
    with factors_on_disk() as folder:
        assert folder_of_factors() == folder
        assert folder.parent == own_folder
    assert folder_of_factors() is None
    assert not folder.exists()


def test_what_a_killed_program_left_behind_is_removed_and_what_is_in_use_is_not(own_folder):
    started = subprocess.Popen([sys.executable, "-c", HOLDS], stdout=subprocess.PIPE, text=True)
    theirs = own_folder / started.stdout.readline().strip()
    grown_old(theirs)
    with factors_on_disk():
        assert (theirs / "factors").exists()
    started.send_signal(signal.SIGKILL)
    started.wait()
    started.stdout.close()
    with factors_on_disk():
        assert not theirs.exists()


def test_lack_of_memory_is_not_told_as_a_singular_matrix():
    """MUMPS is allowed a megabyte for factors that take ten times as much."""
    steps = diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(220, 220))
    plate = csr_array(kronsum(steps, steps))
    PETSc.Options().setValue("mat_mumps_icntl_23", 1)
    try:
        with pytest.raises(MemoryError, match="MUMPS"):
            Mumps(distributed(plate, plate.shape, MPI.COMM_SELF), symmetric=False)
    finally:
        PETSc.Options().delValue("mat_mumps_icntl_23")
    nothing = csr_array(np.diag([1.0, 0.0, 2.0]))
    with pytest.raises(ConvergenceError, match="singular"):
        Mumps(distributed(nothing, nothing.shape, MPI.COMM_SELF), symmetric=False)
