"""What is estimated of the distance between facets and a surface that nobody told."""

from dataclasses import replace

import numpy as np
import pytest
from bodies import lagrange_body

from cea.material import IsotropicMaterial
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box, Ring
from meshes.true_surfaces import true_surfaces

MATERIAL = IsotropicMaterial(1.0, 0.3)
BOX = Box((0.2, 0.2, 0.1))


def surface_of(mesh, name, **options):
    body = lagrange_body("part", mesh, degree=mesh.order, material=MATERIAL, **options)
    return body.surfaces[name]


def estimate(mesh, name):
    """Estimated errors in the middle of the facets (m), one for each."""
    surface = surface_of(mesh, name)
    return surface.geometry_error(surface.gauss_points(1).at)


def meshed(shape, cell, order, elements):
    return shape_mesh(shape, cell, order, breaks=breaks_of(shape, elements))


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
@pytest.mark.parametrize("count", [8, 24])
def test_of_chords_it_is_the_sagitta(cell, count):
    ring = Ring(0.05, 0.08)
    for name, radius in (("inner", 0.05), ("outer", 0.08)):
        sagitta = radius * (1 - np.cos(np.pi / count))
        found = estimate(meshed(ring, cell, 1, (1, count)), name)
        np.testing.assert_allclose(found, sagitta, rtol=3 / count**2)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_of_a_cylinder_it_does_not_depend_on_the_length_of_its_elements(cell):
    annulus = Annulus(0.05, 0.08, 0.0, 0.2)
    found = estimate(meshed(annulus, cell, 1, (1, 24, 2)), "outer")
    np.testing.assert_allclose(found, 0.08 * (1 - np.cos(np.pi / 24)), rtol=5e-3)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_of_curved_facets_it_bounds_their_distance(order):
    ring = Ring(0.05, 0.08)
    mesh = meshed(ring, "quadrilateral", order, (1, 12))
    known = surface_of(mesh, "outer", true_surfaces=true_surfaces(ring))
    points = known.gauss_points(8)
    distance = np.abs(known.offset(points.at, points.normal)).max()
    found = estimate(mesh, "outer")
    assert (distance < found).all()
    assert (found < {2: 5, 3: 8, 4: 15}[order] * distance).all()
    assert (known.geometry_error(points.at) == 0).all()


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("order", [1, 2])
def test_of_flat_faces_and_at_edges_of_bodies_it_is_zero(cell, order):
    """Also of a surface that goes round an edge of a box."""
    mesh = meshed(BOX, cell, order, (3, 3, 2))
    both = np.concatenate([mesh.surfaces["x_max"], mesh.surfaces["z_max"]])
    found = estimate(replace(mesh, surfaces={"both": both}), "both")
    assert found.max() < 1e-15
