"""Stiffness and mass against dolfinx's own assembly of the weak forms, cell by cell."""

import basix
import dolfinx
import numpy as np
import pytest
import ufl
from bodies import dolfinx_body
from covering import covering
from dolfinx.fem.petsc import assemble_matrix

from cea.material import IsotropicMaterial
from cea.matrices import local_part
from cea.petsc import MPI
from cea.supports.boundary import Spring, Support
from cea.supports.frames import SurfaceNormal

CELLS = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")
MATERIAL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.7)
RNG = np.random.default_rng(5)


def distorted(cell, order):
    """A few cells of an order of geometry, their nodes moved at random."""
    corners = basix.geometry(basix.CellType[cell])
    dim = corners.shape[1]
    kind = dolfinx.mesh.CellType[cell]
    if dim == 2:
        straight = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, [[0, 0], [1, 2]], [2, 2], kind)
    else:
        box = [[0, 0, 0], [1, 2, 1.5]]
        straight = dolfinx.mesh.create_box(MPI.COMM_SELF, box, [2, 1, 1], kind)
    element = basix.ufl.element("Lagrange", cell, order, shape=(dim,))
    nodes = dolfinx.fem.functionspace(straight, element)
    x = nodes.tabulate_dof_coordinates()[:, :dim].copy()
    x += 0.08 * RNG.random(x.shape) / order
    mesh = dolfinx.mesh.create_mesh(MPI.COMM_SELF, nodes.dofmap.list.astype(np.int64), element, x)
    mesh.topology.create_connectivity(dim - 1, dim)
    return mesh


def sides(mesh):
    """Facet tags: 1 on the facets of least x of their midpoints, no others."""
    dim = mesh.topology.dim
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    middle = dolfinx.mesh.compute_midpoints(mesh, dim - 1, facets)[:, 0]
    chosen = np.sort(facets[middle < 0.15])
    return dolfinx.mesh.meshtags(mesh, dim - 1, chosen, np.ones(len(chosen), dtype=np.int32))


def independent(mesh, degree, springs=()):
    """Dense stiffness and mass of all dofs from weak forms."""
    dim = mesh.geometry.dim
    V = dolfinx.fem.functionspace(mesh, ("Lagrange", degree, (dim,)))
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    lam, mu = MATERIAL.lame
    stress = lam * ufl.div(u) * ufl.Identity(dim) + 2 * mu * ufl.sym(ufl.grad(u))
    q = max(degree, mesh.geometry.cmaps[0].degree)
    simplex = mesh.basix_cell().name in ("triangle", "tetrahedron")
    of_gradients = {"quadrature_degree": 2 * (q - 1) if simplex else 2 * q}
    stiffness = ufl.inner(stress, ufl.sym(ufl.grad(v))) * ufl.dx(metadata=of_gradients)
    ds = ufl.Measure("ds", mesh, subdomain_data=sides(mesh))
    for spring in springs:
        k = ufl.as_vector(spring.stiffness)
        stiffness += sum(k[i] * u[i] * v[i] for i in range(dim)) * ds(
            1, degree=2 * q + 1, scheme="Gauss-Jacobi"
        )
    mass = MATERIAL.rho * ufl.inner(u, v) * ufl.dx(metadata={"quadrature_degree": 2 * q})
    found = []
    for expression in (stiffness, mass):
        matrix = assemble_matrix(dolfinx.fem.form(expression))
        matrix.assemble()
        found.append(local_part(matrix).toarray())
    return found


def body(mesh, degree, **properties):
    return dolfinx_body(
        "body", mesh, sides(mesh), {"side": 1}, degree=degree, material=MATERIAL, **properties
    )


def compared(made, references):
    """Matrices of a body are those references restricted, symmetric to the last bit."""
    Z = local_part(made.expansion).toarray()
    for matrix, full in zip((made.stiffness(), made.mass()), references, strict=True):
        found, expected = local_part(matrix).toarray(), Z.T @ full @ Z
        assert len(found) > 0
        np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())
        np.testing.assert_array_equal(found, found.T)


@pytest.mark.parametrize(("cell", "degree"), covering(CELLS, (1, 2, 3, 4), strength=1))
def test_matrices_are_those_of_weak_forms(cell, degree):
    mesh = distorted(cell, order=1)
    compared(body(mesh, degree), independent(mesh, degree))


@pytest.mark.parametrize(("degrees", "cell"), covering(((1, 2), (2, 3)), CELLS, strength=1))
def test_so_they_are_on_curved_cells(cell, degrees):
    degree, order = degrees
    mesh = distorted(cell, order)
    compared(body(mesh, degree), independent(mesh, degree))


HELD = {
    "one component": (Support("side", (1,)),),
    "all components": (Support("side"),),
    "normals": (Support("side", frame=SurfaceNormal()),),
}


@pytest.mark.parametrize(("cell", "held"), covering(CELLS, tuple(HELD), strength=1))
def test_held_dofs_and_springs_change_them_as_they_would_afterwards(cell, held):
    # On bent triangles no rule is exact, and rules differ; on flat ones all are.
    mesh = distorted(cell, order=1 if cell == "tetrahedron" else 2)
    springs = [Spring("side", (3.0, 4.0, 5.0)[: mesh.geometry.dim])]
    made = body(mesh, 2, springs=springs, supports=HELD[held])
    references = independent(mesh, 2, springs)
    assert made.expansion.getSizes()[1][1] < len(references[0])
    compared(made, references)
    full = local_part(made.full_stiffness()).toarray()
    np.testing.assert_allclose(full, references[0], atol=1e-13 * np.abs(full).max())
