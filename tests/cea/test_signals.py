"""Libraries leave a closed pipe to Python, where it is an error that can be caught."""

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


@pytest.mark.parametrize(
    "begin",
    ["import cea.petsc", MESHED, f"import cea.petsc\n{MESHED}", f"{MESHED}\nimport cea.petsc"],
    ids=["petsc", "gmsh", "petsc, gmsh", "gmsh, petsc"],
)
def test_a_write_to_a_closed_pipe_raises(begin):
    program = CLOSED_PIPE.format(begin=begin)
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "raised", "")
