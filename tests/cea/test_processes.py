"""Files, folders of factors, memory, faults on ranks: what programs leave and tell."""

import resource
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from time import sleep

import numpy as np
import pytest
from mpi import on_ranks
from scipy.sparse import csr_array, diags_array, kronsum

from cea.eigen.mumps import Mumps, factors_on_disk, folder_of_factors
from cea.errors import ConvergenceError, InputError, WriteError
from cea.files import write_whole
from cea.matrices import distributed
from cea.petsc import MPI, PETSc
from cea.ranks import agreed
from scenes.spec.problems import SceneError


@contextmanager
def full_disk(size):
    """Files cannot grow beyond a size (bytes), as on a disk with no more room."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def names(folder):
    return sorted(each.name for each in folder.iterdir())


def test_a_full_disk_leaves_a_file_as_it_was(tmp_path):
    file = write_whole(b"1", tmp_path / "modes.vtu")
    with full_disk(1000), pytest.raises(WriteError, match=r"cannot be written: File too l"):
        write_whole(b"x" * 5000, file)
    assert file.read_bytes() == b"1"
    assert names(tmp_path) == ["modes.vtu"]


WRITER = """
import sys
from pathlib import Path
from cea.files import write_whole
out = Path(sys.argv[1])
write_whole(b"0" * 10**6, out)
print("begun", flush=True)
for i in range(10**6):
    write_whole(str(i % 10).encode() * 10**6, out)
"""


def test_a_killed_process_leaves_a_whole_file(tmp_path):
    file = tmp_path / "r.bin"
    program = [sys.executable, "-c", WRITER, str(file)]
    with subprocess.Popen(program, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        sleep(0.03)
        process.kill()
    content = file.read_bytes()
    assert len(content) == 10**6
    assert len(set(content)) == 1


def test_folders_of_factors_go_when_freed(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    with factors_on_disk() as folder:
        assert folder_of_factors() == folder
        assert folder.parent == tmp_path
    assert folder_of_factors() is None
    assert not folder.exists()


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


CLOSED_PIPE = """
import os, sys
read, write = os.pipe()
os.close(read)
try:
    os.write(write, b"nobody reads this")
except BrokenPipeError:
    sys.stdout.write("raised")
"""
PETSC = "import cea.petsc\n"
MESHED = "from meshes.unstructured import gmsh_session\nwith gmsh_session():\n    pass\n"
GMSH_FIRST = pytest.param(MESHED + PETSC, marks=pytest.mark.slow)


@pytest.mark.parametrize("begin", [PETSC + MESHED, GMSH_FIRST], ids=["PETSc", "gmsh"])
def test_a_write_to_a_closed_pipe_raises(begin):
    program = [sys.executable, "-c", begin + CLOSED_PIPE]
    done = subprocess.run(program, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("raised", "")


class UnpackableError(Exception):
    """A fault that cannot travel."""

    def __init__(self, first, second):
        super().__init__(first + second)


FAULTS = {
    "InputError": InputError("mu", -1.0, "zero or positive"),
    "SceneError": SceneError([InputError("mu", -1.0, "zero or positive")]),
    "ConvergenceError": ConvergenceError("none", best=lambda: None),
    "ZeroDivisionError": ZeroDivisionError("by zero"),
    "MemoryError": MemoryError(),
    "UnpackableError": UnpackableError("a", "b"),
}


def names_of_faults():
    """Names of the errors that each rank hears, by kind of the fault."""
    comm = MPI.COMM_WORLD
    return {kind: comm.allgather(heard(fault, comm)) for kind, fault in FAULTS.items()}


def heard(fault, comm):
    try:
        with agreed(comm):
            if comm.rank == comm.size - 1:
                raise fault
    except Exception as error:
        return type(error).__name__
    return None


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3])
def test_every_rank_hears_of_a_fault_on_one(ranks):
    for kind, errors in on_ranks(ranks, names_of_faults).items():
        expected = "FaultOnRankError" if kind == "UnpackableError" else kind
        assert set(errors[:-1]) == {expected}
        assert errors[-1] == kind
