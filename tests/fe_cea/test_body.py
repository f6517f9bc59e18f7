"""Lagrange bodies: matrices of weak forms, other meshes, location in cells; refusals."""

import doctest

import basix
import dolfinx
import gmsh
import numpy as np
import pytest
import ufl
from bodies import FLAT, dolfinx_body, lagrange_body
from bodies import PLASTIC as MATERIAL
from covering import covering
from dolfinx.fem.petsc import assemble_matrix
from mpi4py import MPI
from petsc_matrices import to_numpy

import cea.body
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.mesh import DIMENSION, Mesh
from cea.supports.boundary import Spring, Support
from cea.timing import StageTimer
from fe_cea.cell_location import Cells
from meshes.shape_mesh import shape_mesh
from meshes.unstructured import gmsh_session, read_gmsh
from scenes.building.build import build_bodies
from scenes.spec.reading import load_scene
from scenes.spec.refinement import Resolution, refined

RNG = np.random.default_rng(5)


def distorted(cell, order):
    """A few cells of an order of geometry, their nodes moved at random."""
    kind, dim = dolfinx.mesh.CellType[cell], DIMENSION[cell]
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


def independent(mesh, degree, springs, mass_quadrature):
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
    of_mass = {"quadrature_degree": mass_quadrature or 2 * q}
    mass = MATERIAL.rho * ufl.inner(u, v) * ufl.dx(metadata=of_mass)
    for expression in (stiffness, mass):
        matrix = assemble_matrix(dolfinx.fem.form(expression))
        matrix.assemble()
        yield to_numpy(matrix)


HELD = {
    "one component": (Support("side", ("y",)),),
    "all components": (Support("side"),),
    "normals": (Support("side", ("normal",)),),
}


WAYS = [
    (2, 1, None, 2),
    *((degree, degree + 1, None, None) for degree in (2, 1)),
    *((2, 2, held, None) for held in HELD),
    *((degree, 1, None, None) for degree in (1, 2, 3, 4)),
]
"""Degrees of functions and of cells, what is held, and the degree of the rule of the mass."""


@pytest.mark.parametrize(
    ("way", "cell"),
    covering(WAYS, ("quadrilateral", "hexahedron", "tetrahedron", "triangle"), strength=1),
)
def test_matrices_are_those_of_weak_forms(way, cell):
    """Also on curved cells, and with springs and held dofs as if those came afterwards."""
    degree, order, held, mass_quadrature = way
    if held and cell == "tetrahedron":
        order = 1  # on bent facets no rule is exact, and rules differ; on flat ones all are
    mesh = distorted(cell, order)
    springs = [Spring("side", (3.0, 4.0, 5.0)[: mesh.geometry.dim])] if held else []
    options = {"springs": springs, "supports": HELD.get(held, ()), "material": MATERIAL}
    options |= {"degree": degree, "mass_quadrature": mass_quadrature}
    made = dolfinx_body("body", mesh, sides(mesh), {"side": 1}, **options)
    stiffness, mass = independent(mesh, degree, springs, mass_quadrature)
    Z = to_numpy(made.expansion)
    assert (Z.shape[1] < len(Z)) == bool(held)
    for matrix, expected in (
        (made.stiffness(), Z.T @ stiffness @ Z),
        (made.mass(), Z.T @ mass @ Z),
    ):
        found = to_numpy(matrix)
        np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())
        np.testing.assert_array_equal(found, found.T)


def body_of(mesh, degree=1, material=MATERIAL, **options):
    return lagrange_body("part", mesh, degree=degree, material=material, **options)


def test_a_tag_without_facets_is_refused():
    mesh = dolfinx.mesh.create_unit_cube(MPI.COMM_WORLD, 1, 1, 1)
    mesh.topology.create_connectivity(2, 3)
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    tags = dolfinx.mesh.meshtags(mesh, 2, facets, np.ones(len(facets), dtype=np.int32))
    with pytest.raises(InputError, match=r"bodies\.cube\.surfaces\.lid = 2"):
        dolfinx_body("cube", mesh, tags, {"all": 1, "lid": 2}, degree=1, material=MATERIAL)


def test_mass_needs_a_density():
    mesh = shape_mesh(FLAT[3], "tetrahedron", 1, size=1.0)
    with pytest.raises(InputError, match=r"bodies\.part\.material\.rho = None: a density"):
        body_of(mesh, material=IsotropicMaterial(1.0, 0.3)).mass()


def test_models_that_are_no_mesh_of_one_kind_are_refused():
    with gmsh_session():
        gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
        gmsh.model.occ.synchronize()
        with pytest.raises(InputError, match="no nodes"):
            read_gmsh(gmsh.model)
        gmsh.model.mesh.generate(2)
        assert read_gmsh(gmsh.model).surfaces == {}
        nodes = gmsh.model.mesh.getNodes()[0][:4]
        quadrangle = gmsh.model.mesh.getElementType("Quadrangle", 1)
        gmsh.model.mesh.addElementsByType(1, quadrangle, [], nodes)
        with pytest.raises(InputError, match=r"of one kind.*Quadrilateral 4, Triangle 3"):
            read_gmsh(gmsh.model)


def test_the_example_of_the_docstring_runs():
    results = doctest.testmod(cea.body)
    assert results.failed == 0 < 4 < results.attempted


def test_no_mesh_and_inverted_cells_are_refused():
    square = [[0, 0], [1, 0], [0, 1], [1, 1]]
    crossed = Mesh("quadrilateral", 1, square, [[0, 1, 3, 2]], {})
    for mesh, told in ((None, "None"), (crossed, "'1 of 1 cells'")):
        with pytest.raises(InputError, match=rf"^bodies\.part\.mesh = {told}"):
            body_of(mesh, comm=MPI.COMM_SELF)


def test_points_inside_and_on_common_facets_are_found():
    """Of curved cells of a disc with three layers towards its edges, of very different sizes."""
    scene = load_scene("disc_pad", backend="fe")
    disc = build_bodies(refined(scene, "fe", Resolution(2, 0.3, 3)), StageTimer())["disc"]
    layered = Cells.of(disc.space.scalar)
    assert layered.sizes.max() > 5 * layered.sizes.min()
    rng = np.random.default_rng(5)
    own, xi = rng.integers(0, len(layered.nodes), 300), rng.uniform(0.02, 0.98, (300, 3))
    xi[150:, 0] = rng.integers(0, 2, 150)  # on a facet
    x = layered.positions(own, xi)
    cell, found, miss = layered.locate(x)
    assert (cell[:150] == own[:150]).all()
    assert miss.max() <= 1e-12
    assert layered.positions(cell, found) == pytest.approx(x, abs=1e-13)
    assert found[:150] == pytest.approx(xi[:150], abs=1e-9)


def test_points_of_no_cell_are_left_aside():
    square = [[0, 0], [77.0, 0], [1, 0], [0, 1], [1, 1]]
    mesh = Mesh("quadrilateral", 1, square, [[0, 3, 2, 4]], {"low": [[0, 2]]})
    body = body_of(mesh, 2, comm=MPI.COMM_SELF)
    assert body.num_scalar_dofs == 9
    assert body.surfaces["low"].area == pytest.approx(1.0)
