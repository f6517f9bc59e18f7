"""Inverted elements are refused."""

import dolfinx
import numpy as np
import pytest
from bodies import dolfinx_body
from mpi4py import MPI

from cea.errors import InputError
from cea.material import IsotropicMaterial

MATERIAL = IsotropicMaterial(1.0, 0.3, 1.0)


def cube():
    mesh = dolfinx.mesh.create_unit_cube(MPI.COMM_SELF, 3, 3, 3, dolfinx.mesh.CellType.hexahedron)
    mesh.topology.create_connectivity(2, 3)
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    tags = dolfinx.mesh.meshtags(mesh, 2, facets, np.ones(len(facets), dtype=np.int32))
    return mesh, tags


def test_inverted_elements_are_refused():
    mesh, tags = cube()
    dolfinx_body("cube", mesh, tags, {"all": 1}, degree=1, material=MATERIAL)
    inner = np.argmin(np.linalg.norm(mesh.geometry.x - 1 / 3, axis=1))
    mesh.geometry.x[inner] = 0.9
    with pytest.raises(InputError, match=r"bodies.cube.mesh = .* of 27 cells"):
        dolfinx_body("cube", mesh, tags, {"all": 1}, degree=1, material=MATERIAL)
