"""Input checks shared by scenes, meshes and the API."""

import dolfinx
import numpy as np
import pytest
from bodies import dolfinx_body
from mpi4py import MPI

from cea import checks
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


@pytest.mark.parametrize(
    "knots", [[0, 0, 1, 1, 1], [0, 0, 0, 0.6, 0.4, 1, 1, 1], [0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1]]
)
def test_knots_must_rise_and_join(knots):
    with pytest.raises(InputError, match=r"patch.knots\[0\] = .*rising knots"):
        checks.check_knots(np.array(knots, dtype=float), 2, len(knots) - 3, "patch.knots[0]")


@pytest.mark.parametrize("weight", [0.0, -1.0, np.nan])
def test_weights_must_be_positive(weight):
    with pytest.raises(InputError, match="positive"):
        checks.check_weights(np.array([1.0, weight]), "patch.weights")


def test_a_cell_may_be_mirrored_but_not_folded():
    checks.check_jacobians(np.array([[1.0, 2.0], [-1.0, -0.5]]), "mesh")
    with pytest.raises(InputError, match="mesh = '1 of 2 cells'"):
        checks.check_jacobians(np.array([[1.0, 2.0], [1.0, -0.1]]), "mesh")


def test_points_that_miss_nothing_are_not_said_to():
    """Strong weights of a spline bend a rule so far that its weights miss the area of the side."""
    words = {"field": "contacts.c", "sides": "a.top on b.bottom", "reach": "0.1 m"}
    with pytest.raises(InputError, match="12 % of the area of side a has no points"):
        checks.check_coverage(0, 9, 0.12, 0.0, **words)
    with pytest.raises(InputError, match=r"2 of 9 points .* find nothing"):
        checks.check_coverage(2, 9, 0.12, 0.0, **words)
