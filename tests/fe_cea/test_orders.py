"""Lagrange bodies of every cell, degree 1 to 4, in space and in the plane, on curved meshes."""

from itertools import product

import numpy as np
import pytest
from bodies import FLAT, ROUND, body_of, lagrange_body, shape_body
from bodies import PLASTIC as MATERIAL
from scipy.sparse.linalg import spsolve

from cea.mesh import DIMENSION
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from meshes.breaks import breaks_of
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Ring
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
    """Surface that tries every facet for every point."""

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
        slow = Surface.locate(EveryPair(surface), x[part], aim[part], 0.1)
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


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_estimated_errors_of_facets_bound_their_distance(order):
    """From the true surface, where that is not known; one estimate in the middle of each."""
    ring = Ring(0.05, 0.08)
    mesh = shape_mesh(ring, "quadrilateral", order, breaks=breaks_of(ring, (1, 12)))
    unknown, known = (
        lagrange_body("part", mesh, degree=order, material=MATERIAL, **options).surfaces["outer"]
        for options in ({}, {"true_surfaces": true_surfaces(ring)})
    )
    points = known.gauss_points(8)
    distance = np.abs(known.offset(points.at, points.normal)).max()
    found = unknown.geometry_error(unknown.gauss_points(1).at)
    assert (distance < found).all()
    assert (found < {1: 1.1, 2: 5, 3: 8, 4: 15}[order] * distance).all()
    assert (known.geometry_error(points.at) == 0).all()
