"""Surfaces of shapes as they are: nodes of meshes lie on them, chords leave them by a sagitta."""

import numpy as np
import pytest

from meshes.breaks import breaks_of
from meshes.crowned import Crowned
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import (
    Annulus,
    Box,
    Disc,
    Hub,
    Rectangle,
    Ring,
    RingSector,
    Sector,
    VentilatedDisc,
)
from meshes.true_surfaces import true_surfaces

BOX = Box((0.3, 0.2, 0.1), (0.05, 0.0, -0.02))
SECTOR = Sector(0.09, 0.14, 25.0, 65.0, 0.0, 0.02)
SHAPES = [
    (BOX, (2, 2, 2)),
    (Rectangle((0.3, 0.2)), (3, 2)),
    (Ring(0.05, 0.08), (2, 12)),
    (RingSector(0.05, 0.08, 20.0, 110.0), (2, 5)),
    (Annulus(0.05, 0.08, 0.0, 0.02), (2, 12, 2)),
    (SECTOR, (2, 3, 1)),
    (Disc(0.1, 0.0, 0.02), (3, 12, 1)),
    (Hub(0.02, 0.04, 0.1, 0.0, 0.01, -0.01, 0.03), (3, 12, 4)),
    (Crowned(BOX, "z_max", {"x": 2.0, "y": 3.0}, {"x": 0.1}), (3, 3, 1)),
    (Crowned(BOX, "x_min", {"y": 1.0}), (1, 3, 3)),
    (Crowned(Rectangle((0.3, 0.2)), "y_min", {"x": 2.0}), (4, 1)),
    (Crowned(SECTOR, "bottom", {"theta": 0.5}), (2, 3, 1)),
    (Crowned(SECTOR, "top", {"r": 0.4, "theta": 0.7}, {"theta": 40.0}), (2, 3, 1)),
    (VentilatedDisc(), None),
]
PLACED = Placement((1.0, -2.0, 0.5), 50.0, (0.3, -0.1, 2.0))
IN_PLANE = Placement((0.0, 0.0, 1.0), 50.0, (0.3, -0.1, 0.0))
RNG = np.random.default_rng(7)


def straight_mesh(shape, elements, placement):
    """Mesh of straight facets: all its nodes are nodes of the shape."""
    if elements is None:
        return shape_mesh(shape, "tetrahedron", 1, size=0.02, placement=placement)
    cell = "quadrilateral" if len(shape.directions) == 2 else "hexahedron"
    return shape_mesh(shape, cell, 1, breaks=breaks_of(shape, elements), placement=placement)


def outwards(mesh, facets):
    """Roughly the normals of facets: away from the middle of their cells, at each facet."""
    x = mesh.points[facets]
    if mesh.dim == 2:
        along = x[:, 1] - x[:, 0]
        normal = np.column_stack([along[:, 1], -along[:, 0]])
    else:
        normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    return normal / np.linalg.norm(normal, axis=1)[:, None]


@pytest.mark.parametrize(("shape", "elements"), SHAPES)
def test_nodes_of_meshes_lie_on_the_surfaces_and_normals_are_gradients(shape, elements):
    """Along a direction n, the distance s of x obeys ds = - v.dx / v.n with the normal v."""
    placement = IN_PLANE if len(shape.directions) == 2 else PLACED
    mesh = straight_mesh(shape, elements, placement)
    found = true_surfaces(shape, placement)
    assert found.keys() == set(shape.surfaces)
    for name, facets in mesh.surfaces.items():
        surface, n = found[name], outwards(mesh, facets)
        for corner in facets.T:
            distance = surface.distance(mesh.points[corner], n)
            assert np.abs(distance).max() < (1e-9 if elements is None else 1e-14), name
        if elements is None:
            continue
        x = mesh.points[facets[:, 0]]
        v = surface.normal(x, n)
        np.testing.assert_allclose(np.linalg.norm(v, axis=1), 1, rtol=1e-14)
        assert (np.einsum("ij,ij->i", v, n) > 0).all()
        if np.abs(surface.distance(x + 1e-3 * n, n)).max() == 0:
            continue  # flat: facets lie on it, and their normals are its own
        for step in 1e-6 * np.eye(mesh.dim):
            change = surface.distance(x + step, n) - surface.distance(x - step, n)
            expected = -2 * (v @ step) / np.einsum("ij,ij->i", v, n)
            np.testing.assert_allclose(change, expected, atol=1e-11)
