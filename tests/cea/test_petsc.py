"""What bringing in PETSc sets: closed pipes raise, freed memory stays until it is given back."""

import subprocess
import sys

import pytest

CLOSED_PIPE = """
import os, sys
{begin}
read, write = os.pipe()
os.close(read)
try:
    os.write(write, b"nobody reads this")
except BrokenPipeError:
    sys.stdout.write("raised")
"""
MESHED = """
from meshes.unstructured import gmsh_session
with gmsh_session():
    pass
"""


@pytest.mark.parametrize("begin", [f"import cea.petsc\n{MESHED}", f"{MESHED}\nimport cea.petsc"])
def test_a_write_to_a_closed_pipe_raises(begin):
    program = CLOSED_PIPE.format(begin=begin)
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "raised", "")


LARGE = 300_000_000
HELD = f"""
import numpy as np
from cea.petsc import give_back
def resident():
    lines = open("/proc/self/status").read().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmRSS"))
before = resident()
np.ones({LARGE} // 8)
freed = resident() - before
give_back()
print(freed, resident() - before)
"""


def test_freed_memory_stays_until_it_is_given_back():
    told = subprocess.run([sys.executable, "-c", HELD], capture_output=True, text=True, check=True)
    freed, left = map(int, told.stdout.split())
    assert freed > 0.9 * LARGE
    assert left < 0.1 * LARGE
