"""Lagrange bodies of every cell, degree 1 to 4, in space and in the plane, on curved meshes."""

from itertools import permutations, product
from math import factorial

import basix.ufl
import dolfinx
import numpy as np
import pytest
from bodies import dolfinx_body, shape_body
from covering import covering
from lagrange_bodies import DIMENSION, FLAT, MATERIAL, PLANE, ROUND, SPACE, body_of
from mpi4py import MPI
from petsc_matrices import to_scipy
from scipy.sparse.linalg import spsolve

from cea.location import locate_along
from cea.surface_points import Status, SurfaceCoordinates
from meshes.placement import Placement
from meshes.shapes import Box

every_element = pytest.mark.parametrize(("cell", "degree"), list(product(DIMENSION, (1, 2, 3, 4))))


def interpolate(body, degree, field):
    """Values at all scalar dofs of a field in the space, found from a sample that fixes them."""
    sample = body.space.volume_cells()
    return spsolve(sample.values.tocsc(), field(sample.points))


def polynomial(degree, dim):
    """A scalar polynomial of the full degree that depends on every direction, and its gradient."""
    slope = np.array([0.7, -0.4, 0.5])[:dim]

    def value(x):
        return (x @ slope + 0.3) ** degree

    def gradient(x):
        return degree * (x @ slope + 0.3)[:, None] ** (degree - 1) * slope

    return value, gradient


@every_element
def test_polynomials_of_the_degree_are_exact(cell, degree):
    """Their energies, values on and gradients at the surface, and values within each cell.

    Dofs that cells put on a shared edge or face in different orders would spoil all of them.
    """
    body = body_of(FLAT, cell, degree, order=1, elements=(2, 1, 2))
    value, gradient = polynomial(degree, body.dim)
    u = interpolate(body, degree, value)
    rng = np.random.default_rng(0)
    for surface in body.surfaces.values():
        n = surface.num_elements
        at = SurfaceCoordinates(rng.integers(0, n, 40), rng.uniform(0.02, 0.48, (40, body.dim - 1)))
        x = surface.position(at)
        np.testing.assert_allclose(surface.trace(at) @ u, value(x), atol=1e-12)
        found = np.column_stack([g @ u for g in surface.gradient(at)])
        np.testing.assert_allclose(found, gradient(x), atol=1e-11)
    moved = np.zeros((len(u), body.dim))
    moved[:, 0] = u
    lam, mu = MATERIAL.lame
    # With v = (s.x + c)^q and u = v e0: energy density ((lam + mu) s0^2 + mu s.s) (v'/|s|)^2.
    slope = np.array([0.7, -0.4, 0.5])[: body.dim]
    density = ((lam + mu) * slope[0] ** 2 + mu * slope @ slope) / (slope @ slope)
    gradient_squared = integral(body, lambda x: (gradient(x) ** 2).sum(axis=1), 2 * degree)
    energy = moved.ravel() @ (to_scipy(body.stiffness()) @ moved.ravel())
    assert energy == pytest.approx(density * gradient_squared, rel=1e-11)
    kinetic = moved.ravel() @ (to_scipy(body.mass()) @ moved.ravel())
    squared = integral(body, lambda x: value(x) ** 2, 2 * degree)
    assert kinetic == pytest.approx(MATERIAL.rho * squared, rel=1e-11)


def integral(body, field, degree):
    """Integral over a placed block by Gauss points of the block, no mesh involved."""
    shape, placement = FLAT[body.dim], SPACE if body.dim == 3 else PLANE
    nodes, weights = np.polynomial.legendre.leggauss(degree // 2 + 1)
    grid = np.stack(np.meshgrid(*[(nodes + 1) / 2] * body.dim, indexing="ij"), axis=-1)
    weight = np.prod(np.meshgrid(*[weights / 2] * body.dim, indexing="ij"), axis=0)
    x = placement.apply(grid.reshape(-1, body.dim) * shape.size)
    return np.prod(shape.size) * (weight.ravel() @ field(x))


@pytest.mark.parametrize(("dim", "degree"), covering((2, 3), (4, 3), strength=1))
def test_cells_that_number_a_shared_facet_differently_agree_on_it(dim, degree):
    """Two simplices on one facet, the second with its vertices in every order."""
    corners = np.vstack([np.zeros(dim), np.eye(dim), np.full(dim, 0.9)])
    name = {2: "triangle", 3: "tetrahedron"}[dim]
    value, _ = polynomial(degree, dim)
    for second in permutations(range(1, dim + 2)):
        mesh = dolfinx.mesh.create_mesh(
            MPI.COMM_SELF,
            np.array([list(range(dim + 1)), list(second)]),
            basix.ufl.element("Lagrange", name, 1, shape=(dim,)),
            corners,
        )
        mesh.topology.create_connectivity(dim - 1, dim)
        facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
        tags = dolfinx.mesh.meshtags(mesh, dim - 1, facets, np.ones(len(facets), dtype=np.int32))
        body = dolfinx_body("pair", mesh, tags, {"all": 1}, degree=degree, material=MATERIAL)
        shared = factorial(degree + dim - 1) // factorial(degree) // factorial(dim - 1)
        one = factorial(degree + dim) // factorial(degree) // factorial(dim)
        assert body.num_scalar_dofs == 2 * one - shared
        u = interpolate(body, degree, value)
        points = body.surfaces["all"].gauss_points(degree)
        traced = body.surfaces["all"].trace(points.at) @ u
        np.testing.assert_allclose(traced, value(points.x), atol=1e-12)


class EveryPair:
    """Chart that tries every facet for every point."""

    def __init__(self, surface):
        self._surface = surface

    def __getattr__(self, name):
        return getattr(self._surface, name)

    def candidates(self, x, direction, reach):
        """Every point with every facet."""
        count = self._surface.num_elements
        point = np.repeat(np.arange(len(x)), count)
        start = np.full((len(point), self._surface.dim - 1), 0.3)
        return point, np.tile(np.arange(count), len(x)), start


@pytest.mark.parametrize(
    "count", [1000, pytest.param(25_000, marks=pytest.mark.slow)], ids=["quick", "slow"]
)
@pytest.mark.parametrize(("cell", "name"), list(product(DIMENSION, ("inner", "outer"))))
def test_location_agrees_with_brute_force_on_curved_surfaces(cell, name, count):
    """Points off a turned and shifted surface, some beyond its rim or reach, aims aslant.

    The slow run puts 200 000 points through all cases.
    """
    surface = body_of(ROUND, cell, 3).surfaces[name]
    dim, rng = surface.dim, np.random.default_rng(6)
    at = SurfaceCoordinates(
        rng.integers(0, surface.num_elements, count), rng.uniform(0.02, 0.48, (count, dim - 1))
    )
    normal = surface.normal(at)
    x = surface.position(at) + rng.normal(0, 0.08, (count, dim))
    aim = normal + rng.normal(0, 0.2, (count, dim))
    aim /= np.linalg.norm(aim, axis=1, keepdims=True)
    found = surface.locate(x, aim, 0.1)
    parts = [
        locate_along(EveryPair(surface), x[i : i + 2000], aim[i : i + 2000], 0.1)
        for i in range(0, count, 2000)
    ]
    status = np.concatenate([part.status for part in parts])
    distance = np.concatenate([part.distance for part in parts])
    assert 0.05 * count < found.missed.sum() < 0.9 * count
    assert np.array_equal(found.status, status)
    hit = ~found.missed
    np.testing.assert_allclose(found.distance[hit], distance[hit], atol=1e-8)


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize(("cell", "mesh"), [("tetrahedron", 0.4), ("hexahedron", (3, 16, 2))])
@pytest.mark.parametrize("name", ["z_max", "top"])
def test_grid_has_shared_points_once(name, cell, mesh, degree):
    surface = shape_body((ROUND if name == "top" else FLAT)[3], cell, degree, mesh).surfaces[name]
    corners = len(surface.grid(2))
    for n in (3, 5):
        points = surface.grid(n)
        assert len(np.unique(np.round(points.x, 9), axis=0)) == len(points)
        facets = surface.num_elements
        # Euler: V - E + F is 0 for a ring, 1 for a disc.
        edges = corners + facets - (0 if name == "top" else 1)
        inner = (n - 2) * (n - 3) // 2 if cell == "tetrahedron" else (n - 2) ** 2
        assert len(points) == corners + edges * (n - 2) + facets * inner


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_a_short_reach_finds_points_on_the_bulge_of_a_curved_facet(cell):
    """Facets of a quarter circle leave the boxes of their corners by far more than the reach."""
    mesh = 0.6 if cell == "tetrahedron" else (1, 4, 1)
    body = shape_body(ROUND[3], cell, 2, mesh, placement=Placement(angle=45.0))
    for name in ("inner", "outer"):
        surface = body.surfaces[name]
        points = surface.gauss_points(8)
        found = surface.locate(points.x, points.normal, reach=1e-6)
        assert not found.missed.any()
        np.testing.assert_allclose(surface.position(found.at), points.x, atol=1e-8)


@pytest.mark.parametrize(("cell", "degree"), list(product(("tetrahedron", "hexahedron"), (1, 2))))
def test_points_beyond_the_rim_or_reach_are_missed(cell, degree):
    box = Box((2.0, 1.0, 0.5), origin=(0.1, -0.3, 0.2))
    mesh = 0.4 if cell == "tetrahedron" else (4, 3, 2)
    surface = shape_body(box, cell, degree, mesh).surfaces["z_max"]
    (x0, x1), (y0, y1), (_, z1) = box.extent
    up = np.tile([0.0, 0.0, 1.0], (5, 1))
    size = surface.mesh_size
    x = np.array(
        [
            [x1 + 1e-6 * size, 0.0, z1],
            [x0 - 1e-3, y0 - 1e-3, z1],
            [x1 + 5.0, y1 + 7.0, z1],
            [x0 + 0.31, 0.03, z1 + 0.11],
            [x0 + 0.31, 0.03, z1 + 0.09],
        ]
    )
    found = surface.locate(x, up, reach=0.1)
    assert found.status[:4].tolist() == [Status.MISSED] * 4
    assert found.status[4] in (Status.INSIDE, Status.EDGE)
    assert found.distance[4] == pytest.approx(-0.09, abs=1e-12)
    # Clamped in reference coordinates, a point on a slanted triangle is not quite the nearest.
    nearest = np.array([1e-6 * size, np.sqrt(2) * 1e-3])
    assert (found.miss[:2] > (1 - 1e-6) * nearest).all()
    assert (found.miss[:2] < (1.5 if cell == "tetrahedron" else 1 + 1e-6) * nearest).all()
    assert np.isinf(found.miss[2])
    assert found.at.element[2] == -1
