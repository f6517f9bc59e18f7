"""Lagrange surfaces: nodes and grids once each, points beyond the rim, bulges between corners."""

import numpy as np
import pytest
from bodies import shape_body

from cea.surface_points import SurfaceCoordinates
from meshes.placement import Placement
from meshes.shapes import Annulus, Box

ELEMENTS = [("tetrahedron", 1), ("tetrahedron", 2), ("hexahedron", 1), ("hexahedron", 2)]
BOX = Box((2.0, 1.0, 0.5), origin=(0.1, -0.3, 0.2))
ANNULUS = Annulus(0.5, 1.0, 0.0, 0.3)
MESHES = {
    "box": (BOX, (3, 3, 2), 0.4),
    "annulus": (ANNULUS, (2, 16, 1), 0.25),
}

every_element = pytest.mark.parametrize(("cell", "degree"), ELEMENTS)


def make(kind, cell, degree):
    shape, elements, size = MESHES[kind]
    return shape_body(shape, cell, degree, size if cell == "tetrahedron" else elements)


def scattered(surface, n, seed=1):
    """Random points of a surface, away from the edges of its facets."""
    rng = np.random.default_rng(seed)
    return SurfaceCoordinates(
        rng.integers(0, surface.num_elements, n), rng.uniform(0.02, 0.48, (n, 2))
    )


@every_element
def test_abscissae_are_the_nodes_of_the_surface(cell, degree):
    body = make("annulus", cell, degree)
    for surface in body.surfaces.values():
        points = surface.abscissae("nodes")
        trace = surface.trace(points.at)
        values = trace.toarray()
        assert np.array_equal(np.rint(values).sum(axis=1), np.ones(len(points)))
        np.testing.assert_allclose(values, np.rint(values), atol=1e-14)
        # As many points as basis functions that live on the surface, each picked once.
        alive = np.unique(surface.trace(scattered(surface, 4000)).indices)
        assert np.array_equal(np.unique(values.argmax(axis=1)), alive)
        assert len(points) == len(alive)


@every_element
@pytest.mark.parametrize("kind", MESHES)
def test_grid_has_shared_points_once(kind, cell, degree):
    surface = make(kind, cell, degree).surfaces["top" if kind == "annulus" else "z_max"]
    corners = len(surface.grid(2))
    for n in (3, 5):
        points = surface.grid(n)
        assert len(np.unique(np.round(points.x, 9), axis=0)) == len(points)
        facets = surface.num_elements
        # Euler: V - E + F is 0 for a ring, 1 for a disc.
        edges = corners + facets - (0 if kind == "annulus" else 1)
        inner = (n - 2) * (n - 3) // 2 if cell == "tetrahedron" else (n - 2) ** 2
        assert len(points) == corners + edges * (n - 2) + facets * inner


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_a_short_reach_finds_points_on_the_bulge_of_a_curved_facet(cell):
    """Facets of a quarter circle leave the boxes of their corners by far more than the reach."""
    mesh = 0.6 if cell == "tetrahedron" else (1, 4, 1)
    body = shape_body(ANNULUS, cell, 2, mesh, placement=Placement(angle=45.0))
    for name in ("inner", "outer"):
        surface = body.surfaces[name]
        points = surface.gauss_points(8)
        found = surface.locate(points.x, points.normal, reach=1e-6)
        assert not found.missed.any()
        np.testing.assert_allclose(surface.position(found.at), points.x, atol=1e-8)
