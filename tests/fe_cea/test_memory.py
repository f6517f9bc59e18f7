"""Memory that assembly takes at most, beside the matrices it leaves."""

import subprocess
import sys

import pytest
from peak_memory import PEAK

PROGRAM = (
    PEAK
    + """
import sys

import cea.petsc  # noqa: F401
import dolfinx
import numpy as np
from mpi4py import MPI

from cea.supports.boundary import Support
from cea.material import IsotropicMaterial

mesh = dolfinx.mesh.create_unit_cube(MPI.COMM_SELF, 17, 17, 17, dolfinx.mesh.CellType.hexahedron)
mesh.topology.create_connectivity(2, 3)
facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
tags = dolfinx.mesh.meshtags(mesh, 2, facets, np.ones(len(facets), dtype=np.int32))
material = IsotropicMaterial(1.0, 0.3, 1.0)
supports = [Support("all", (0,))] if sys.argv[1] == "held" else []
body = dolfinx_body("cube", mesh, tags, {"all": 1}, degree=2, material=material, supports=supports)
body.expansion
before = peak()
matrices = body.stiffness(), body.mass()
taken = peak() - before
print(taken, sum(12 * matrix.getInfo()["nz_used"] for matrix in matrices))
"""
)


@pytest.mark.slow
@pytest.mark.parametrize("supports", ["free", "held"])
def test_assembly_takes_at_most_twice_its_matrices(supports):
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM, supports],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    taken, kept = map(float, run.stdout.split())
    assert kept > 250e6
    assert taken < 2 * kept, taken / kept
