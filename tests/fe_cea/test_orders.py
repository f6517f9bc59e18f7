"""Lagrange bodies of every cell, degree 1 to 4, in space and in the plane, on curved meshes."""

from itertools import product

import numpy as np
import pytest
from bodies import FLAT, ROUND, body_of, lagrange_body, shape_body
from bodies import PLASTIC as MATERIAL
from scipy.sparse.linalg import spsolve

from cea.location import Chart
from cea.mesh import DIMENSION
from cea.surface_points import Status, SurfaceCoordinates
from meshes.breaks import breaks_of
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box, Ring
from meshes.true_surfaces import true_surfaces

SLOPE, SHIFT = np.array([0.7, -0.4, 0.5]), 0.3
"""Of (s.x + c)^q, a polynomial of the full degree that depends on every direction."""


def value(x, degree):
    return (x @ SLOPE[: x.shape[1]] + SHIFT) ** degree


def interpolate(body, degree):
    """The polynomial's values at all scalar dofs, found from a sample that fixes them."""
    sample = body.space.volume_cells()
    return spsolve(sample.values.tocsc(), value(sample.points, degree))


def random_points(surface, rng, count):
    """Points in elements of a surface, whether simplices or boxes."""
    xi = rng.uniform(0.02, 0.48, (count, surface.dim - 1))
    return SurfaceCoordinates(rng.integers(0, surface.num_elements, count), xi)


@pytest.mark.parametrize(("cell", "degree"), list(product(DIMENSION, (1, 2, 3, 4))))
def test_polynomials_of_the_degree_are_exact(cell, degree):
    """Their values on and gradients at the surface, and values within each cell.

    Dofs that cells put on a shared edge or face in different orders would spoil all of them.
    """
    body = body_of(FLAT, cell, degree, order=1, elements=(2, 1, 2))
    u, slope = interpolate(body, degree), SLOPE[: body.dim]
    rng = np.random.default_rng(0)
    for surface in body.surfaces.values():
        at = random_points(surface, rng, 40)
        x = surface.position(at)
        np.testing.assert_allclose(surface.trace(at) @ u, value(x, degree), atol=1e-12)
        found = np.column_stack([g @ u for g in surface.gradient(at)])
        expected = degree * value(x, 1)[:, None] ** (degree - 1) * slope
        np.testing.assert_allclose(found, expected, atol=1e-11)


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


@pytest.mark.parametrize("count", [1000, pytest.param(25_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("cell", "name"), list(product(DIMENSION, ("inner", "outer"))))
def test_location_agrees_with_brute_force_on_curved_surfaces(cell, name, count):
    """Points off a turned and shifted surface, some beyond its rim or reach, aims aslant.

    The slow run puts 200 000 points through all cases.
    """
    surface = body_of(ROUND, cell, 3).surfaces[name]
    rng = np.random.default_rng(6)
    at = random_points(surface, rng, count)
    x = surface.position(at) + rng.normal(0, 0.08, (count, surface.dim))
    aim = surface.normal(at) + rng.normal(0, 0.2, (count, surface.dim))
    aim /= np.linalg.norm(aim, axis=1, keepdims=True)
    found = surface.locate(x, aim, 0.1)
    assert 0.05 * count < found.missed.sum() < 0.9 * count
    for part in np.split(np.arange(count), range(2000, count, 2000)):
        slow = Chart.locate(EveryPair(surface), x[part], aim[part], 0.1)
        assert np.array_equal(found.status[part], slow.status)
        hit = ~slow.missed
        np.testing.assert_allclose(found.distance[part][hit], slow.distance[hit], atol=1e-8)


@pytest.mark.parametrize(("cell", "mesh"), [("tetrahedron", 0.6), ("hexahedron", (1, 4, 1))])
def test_a_short_reach_finds_points_on_the_bulge_of_a_curved_facet(cell, mesh):
    """Facets of a quarter circle leave the boxes of their corners by far more than the reach."""
    body = shape_body(ROUND[3], cell, 2, mesh, placement=Placement(angle=45.0))
    for name in ("inner", "outer"):
        surface = body.surfaces[name]
        points = surface.gauss_points(8)
        found = surface.locate(points.x, points.normal, reach=1e-6)
        assert not found.missed.any()
        np.testing.assert_allclose(surface.position(found.at), points.x, atol=1e-8)


def surface_of(mesh, name, **options):
    body = lagrange_body("part", mesh, degree=mesh.order, material=MATERIAL, **options)
    return body.surfaces[name]


def estimate(mesh, name):
    """Estimated errors in the middle of the facets (m), one for each."""
    surface = surface_of(mesh, name)
    return surface.geometry_error(surface.gauss_points(1).at)


def meshed(shape, cell, order, elements):
    return shape_mesh(shape, cell, order, breaks=breaks_of(shape, elements))


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_of_facets_it_bounds_their_distance(order):
    ring = Ring(0.05, 0.08)
    mesh = meshed(ring, "quadrilateral", order, (1, 12))
    known = surface_of(mesh, "outer", true_surfaces=true_surfaces(ring))
    points = known.gauss_points(8)
    distance = np.abs(known.offset(points.at, points.normal)).max()
    found = estimate(mesh, "outer")
    assert (distance < found).all()
    assert (found < {1: 1.1, 2: 5, 3: 8, 4: 15}[order] * distance).all()
    assert (known.geometry_error(points.at) == 0).all()


SHAPE = np.array([9, 7])
"""Elements of the surface z = 0, which are squares."""
STEP = 0.3
UP = np.array([0.0, 0.0, 1.0])


def plane():
    """The surface, and the numbers of its elements by their place."""
    plate = Box((*(STEP * SHAPE), 0.2), (0.0, 0.0, -0.2))
    surface = shape_body(plate, "hexahedron", 2, (*SHAPE.tolist(), 1)).surfaces["z_max"]
    middles = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in SHAPE), indexing="ij"), axis=-1)
    element = located(surface, middles.reshape(-1, 2), np.zeros(SHAPE.prod())).at.element
    return surface, element.reshape(SHAPE)


def located(surface, place, distance):
    """Points at distances above places on the surface."""
    x = np.column_stack([STEP * place, -distance])
    return surface.locate(x, np.tile(UP, (len(x), 1)), reach=0.06)


def test_shared_edges_and_corners_go_to_the_lowest_element():
    """Whatever the order of points, and with rounding either way."""
    surface, numbers = plane()
    rng = np.random.default_rng(6)
    lines = rng.integers(1, SHAPE, (3000, 2))
    on_line = np.repeat([[True, False], [False, True], [True, True]], 1000, axis=0)
    place = np.where(on_line, lines, lines + rng.uniform(0.1, 0.9, (3000, 2)))
    distance = rng.uniform(-0.05, 0.05, len(place))
    found = located(surface, place, distance)
    assert (found.status == Status.EDGE).all()
    sharing = [numbers[*(lines - on_line * [i, j]).T] for i in (0, 1) for j in (0, 1)]
    np.testing.assert_array_equal(found.at.element, np.min(sharing, axis=0))
    np.testing.assert_allclose(found.distance, distance, atol=1e-9)
    order = rng.permutation(3000)
    again = located(surface, place[order], distance[order])
    np.testing.assert_array_equal(again.at.element, found.at.element[order])
