"""Lagrange bodies: matrices against closed forms and slow independent assembly; refusals."""

import dolfinx
import numpy as np
import pytest
import scipy.sparse as sp
from bodies import dolfinx_body, lagrange_body
from fe_shapes import (
    ANNULUS,
    BOX,
    ELEMENTS,
    MATERIAL,
    PLACEMENT,
    annulus,
    body_of,
    box,
    coordinates,
    exact_measures,
)
from lagrange_bodies import csr
from mpi4py import MPI
from scipy.sparse.linalg import spsolve

from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.mesh import reference_nodes
from cea.supports.boundary import Pressure, Spring, Support
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Sector

every_element = pytest.mark.parametrize(("cell", "degree"), ELEMENTS)


def quadratic(at, place):
    """Quadratic function of the node of a place, at barycentric coordinates."""
    corner = at[place.argmax()]
    return corner * (2 * corner - 1) if place.max() == 2 else 4 * at[place == 1].prod()


def test_another_quadrature_of_the_mass_has_its_points():
    """Four points of degree 2 in each tetrahedron, by hand; the default is exact."""
    mesh = shape_mesh(BOX, "tetrahedron", 2, size=1.5)
    a, b = (5 - np.sqrt(5)) / 20, (5 + 3 * np.sqrt(5)) / 20
    barycentric = np.full((4, 4), a) + (b - a) * np.eye(4)
    places = np.rint(2 * reference_nodes("tetrahedron", 2)).astype(int)
    weights = np.column_stack([2 - places.sum(axis=1), places])
    shapes = np.array([[quadratic(at, w) for w in weights] for at in barycentric])
    corners = [int(np.flatnonzero(weights[:, i] == 2)[0]) for i in range(4)]
    expected = np.zeros((len(mesh.points),) * 2)
    for cell in mesh.cells:
        x = mesh.points[cell[corners]]
        volume = abs(np.linalg.det(x[1:] - x[0])) / 6
        expected[np.ix_(cell, cell)] += MATERIAL.rho * volume / 4 * shapes.T @ shapes
    masses = {
        degree: csr(
            lagrange_body("part", mesh, degree=2, material=MATERIAL, mass_quadrature=degree).mass()
        )
        for degree in (None, 2, 4)
    }
    assert np.linalg.eigvalsh(masses[2].toarray()[::3, ::3]) == pytest.approx(
        np.linalg.eigvalsh(expected), abs=1e-14
    )
    assert abs(masses[4] - masses[None]).max() < 1e-14 < 1e-4 < abs(masses[2] - masses[None]).max()
    assert masses[2].sum() == pytest.approx(masses[None].sum())
    with pytest.raises(InputError, match="mass_quadrature"):
        lagrange_body("part", mesh, degree=2, material=MATERIAL, mass_quadrature=-1)


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_volume_and_areas_of_a_ring_converge_with_the_order_of_its_geometry(cell):
    exact = exact_measures(ANNULUS)
    for degree, rate in ((1, 2), (2, 4)):
        errors = []
        for n in (1, 2):
            body = body_of(ANNULUS, cell, degree, elements=((n, 12 * n, n),), size=0.3 / n)
            ones = body.expansion.createVecRight()
            ones.set(1.0)
            measured = {name: surface.area for name, surface in body.surfaces.items()}
            measured["volume"] = ones.dot(body.mass() * ones) / 3 / MATERIAL.rho
            errors.append([abs(measured[name] / exact[name] - 1) for name in ("volume", "outer")])
            for name in exact:
                assert measured[name] == pytest.approx(
                    exact[name], rel={1: 0.05, 2: 5e-4}[degree] / n**rate
                )
        if cell == "hexahedron":
            np.testing.assert_allclose(np.log2(np.divide(*errors)), rate, atol=0.1)


def test_a_sector_has_its_volume_and_areas():
    shape = Sector(0.5, 1.0, -20.0, 70.0, 0.1, 0.4)
    body = body_of(shape, "hexahedron", 2, elements=((2, 8, 1),))
    areas = {name: surface.area for name, surface in body.surfaces.items()}
    quarter = {name: area / 4 for name, area in exact_measures(shape).items()}
    assert csr(body.mass()).sum() == pytest.approx(3 * MATERIAL.rho * quarter.pop("volume"), 1e-5)
    assert areas == pytest.approx(quarter | {"start": 0.15, "end": 0.15}, rel=1e-5)


@every_element
def test_a_rotated_body_has_rotated_matrices(cell, degree):
    here, there = annulus(cell, degree), annulus(cell, degree, placement=PLACEMENT)
    turn = sp.kron(sp.eye_array(here.num_scalar_dofs), PLACEMENT.rotation).tocsr()
    for a, b in ((here.stiffness(), there.stiffness()), (here.mass(), there.mass())):
        a, b = csr(a), csr(b)
        assert abs(turn @ a @ turn.T - b).max() < 1e-12 * abs(a).max()


def test_linear_tetrahedra_agree_with_assembly_by_hand():
    body = body_of(BOX, "tetrahedron", 1, size=0.7, placement=PLACEMENT)
    x, cells = coordinates(body, 1), body.volume_sample(1)
    dofs = np.rint(cells.values @ np.arange(body.num_scalar_dofs)).astype(int)[cells.cells]
    lam, mu = MATERIAL.lame
    n = 3 * body.num_scalar_dofs
    K, M = np.zeros((n, n)), np.zeros((n, n))
    for dof in dofs:
        corner = np.column_stack([np.ones(4), x[dof]])
        volume = abs(np.linalg.det(corner)) / 6
        gradient = np.linalg.inv(corner)[1:]
        for i, a in enumerate(dof):
            for j, b in enumerate(dof):
                gi, gj = gradient[:, i], gradient[:, j]
                block = lam * np.outer(gi, gj) + mu * (np.outer(gj, gi) + gi @ gj * np.eye(3))
                K[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += volume * block
                mass = MATERIAL.rho * volume * (1 + (i == j)) / 20
                M[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += mass * np.eye(3)
    np.testing.assert_allclose(csr(body.stiffness()).toarray(), K, atol=1e-13)
    np.testing.assert_allclose(csr(body.mass()).toarray(), M, atol=1e-15)


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_energies_of_a_quadratic_field_are_exact(cell):
    """With u = (y z, 0, 0): two shears z, y of strain energy, and kinetic energy of y z."""
    body = box(cell, 2)
    x, y, z = coordinates(body, 2).T
    u = np.column_stack([y * z, 0 * x, 0 * x]).ravel()
    lx = BOX.size[0]
    _, (y0, y1), (z0, z1) = BOX.extent
    y2, z2 = (y1**3 - y0**3) / 3, (z1**3 - z0**3) / 3
    _, mu = MATERIAL.lame
    shear = mu * lx * ((y1 - y0) * z2 + (z1 - z0) * y2)
    assert u @ (csr(body.stiffness()) @ u) == pytest.approx(shear, rel=1e-12)
    assert u @ (csr(body.mass()) @ u) == pytest.approx(MATERIAL.rho * lx * y2 * z2, rel=1e-12)


@every_element
def test_volume_sample_fills_the_body(cell, degree):
    body = box(cell, degree)
    x = coordinates(body, degree)
    for n in (1, 3):
        sample = body.volume_sample(n)
        np.testing.assert_allclose(sample.values @ x, sample.points, atol=1e-13)
        distinct = np.unique(np.round(sample.points, 9), axis=0)
        assert len(distinct) == len(sample.points)
        assert np.array_equal(np.unique(sample.cells), np.arange(len(sample.points)))
        corners = sample.points[sample.cells]
        # In VTK order corners 1, 3, 4 of a box and 1, 2, 3 of a tetrahedron are right-handed.
        along = [1, 3, 4] if cell == "hexahedron" else [1, 2, 3]
        volume = np.linalg.det(corners[:, along] - corners[:, :1])
        assert volume.min() > 0
        whole = volume.sum() / (1 if cell == "hexahedron" else 6)
        assert whole == pytest.approx(np.prod(BOX.size), rel=1e-12)
        assert len(sample.cells) == n**3 * len(body.volume_sample(1).cells)


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_two_dimensions(cell):
    """Plane strain patch test of a body in the plane."""
    mesh = dolfinx.mesh.create_rectangle(
        MPI.COMM_WORLD, [[0.0, 0.0], [2.0, 1.0]], [3, 2], dolfinx.mesh.CellType[cell]
    )
    mesh.topology.create_connectivity(1, 2)
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    x = dolfinx.mesh.compute_midpoints(mesh, 1, facets)
    values = np.select([x[:, 0] < 1e-9, x[:, 1] < 1e-9, x[:, 1] > 1 - 1e-9], [1, 2, 3], 4)
    tags = dolfinx.mesh.meshtags(mesh, 1, facets, values.astype(np.int32))
    body = dolfinx_body(
        "plate",
        mesh,
        tags,
        {"left": 1, "bottom": 2, "top": 3},
        degree=2,
        material=MATERIAL,
        supports=[Support("left", (0,)), Support("bottom", (1,))],
        pressures=[Pressure("top", 0.1)],
    )
    u = csr(body.expansion) @ spsolve(csr(body.stiffness()).tocsc(), body.load().getArray())
    sample = body.volume_sample(1)
    E, nu = MATERIAL.E / (1 - MATERIAL.nu**2), MATERIAL.nu / (1 - MATERIAL.nu)
    exact = 0.1 / E * sample.points * [nu, -1.0]
    np.testing.assert_allclose(sample.values @ u.reshape(-1, 2), exact, atol=1e-13)
    corners = sample.points[sample.cells]
    last = 2 if cell == "triangle" else 3
    areas = np.linalg.det(corners[:, [1, last]] - corners[:, :1])
    assert areas.min() > 0


@pytest.mark.parametrize(
    ("field", "options"),
    [
        ("bodies.part.degree", {"degree": 5}),
        ("bodies.part.supports[0].surface", {"supports": [Support("lid", (0,))]}),
        ("bodies.part.springs[0].surface", {"springs": [Spring("lid", (1.0, 1.0, 1.0))]}),
        ("bodies.part.pressures[0].surface", {"pressures": [Pressure("lid", 1.0)]}),
        ("bodies.part.springs[0].stiffness", {"springs": [Spring("top", (1.0, 1.0))]}),
    ],
)
def test_wrong_input_is_refused_by_name(field, options):
    options = {"degree": 1, "material": MATERIAL} | options
    made = shape_mesh(ANNULUS, "tetrahedron", 1, size=0.5)
    with pytest.raises(InputError) as refused:
        lagrange_body("part", made, **options)
    assert refused.value.field == field
    if field.endswith("surface"):
        assert all(name in refused.value.allowed for name in ANNULUS.surfaces)


def test_a_tag_without_facets_is_refused():
    mesh = dolfinx.mesh.create_unit_cube(MPI.COMM_WORLD, 1, 1, 1)
    mesh.topology.create_connectivity(2, 3)
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    tags = dolfinx.mesh.meshtags(mesh, 2, facets, np.ones(len(facets), dtype=np.int32))
    with pytest.raises(InputError, match=r"bodies\.cube\.surfaces\.lid = 2"):
        dolfinx_body("cube", mesh, tags, {"all": 1, "lid": 2}, degree=1, material=MATERIAL)


def test_mass_needs_a_density():
    body = box("hexahedron", 1, material=IsotropicMaterial(1.0, 0.3))
    with pytest.raises(InputError, match=r"bodies\.part\.material\.rho = None: a density"):
        body.mass()
