"""Surfaces of shapes as they are: nodes of meshes lie on them; crowned faces are paraboloids."""

import numpy as np
import pytest
from bodies import shape_body

from cea.errors import InputError
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

BOX = Box((0.3, 0.2, 0.1), origin=(-0.1, 0.05, 0.02))
RECTANGLE = Rectangle((0.3, 0.2), origin=(-0.1, 0.05))
SECTOR = Sector(0.1, 0.14, 25.0, 65.0, 0.01, 0.03)
CROWNED = {
    "rectangle": (Crowned(RECTANGLE, "y_min", {"x": 1.5}), (3, 2)),
    "rectangle, off its middle": (Crowned(RECTANGLE, "x_max", {"y": 0.8}, {"y": 0.05}), (3, 2)),
    "box": (Crowned(BOX, "z_min", {"x": 2.0, "y": 0.7}, {"x": -0.1}), (3, 2, 2)),
    "sector": (Crowned(SECTOR, "bottom", {"theta": 0.3}), (2, 5, 2)),
    "sector, both ways": (
        Crowned(SECTOR, "top", {"theta": 0.3, "r": 0.5}, {"theta": 30.0}),
        (2, 5, 2),
    ),
}
"""Shapes and their numbers of elements."""
SHAPES = [
    (BOX, (2, 2, 2)),
    (RECTANGLE, (3, 2)),
    (Ring(0.05, 0.08), (2, 12)),
    (RingSector(0.05, 0.08, 20.0, 110.0), (2, 5)),
    (Annulus(0.05, 0.08, 0.0, 0.02), (2, 12, 2)),
    (SECTOR, (2, 3, 1)),
    (Disc(0.1, 0.0, 0.02), (3, 12, 1)),
    (Hub(0.02, 0.04, 0.1, 0.0, 0.01, -0.01, 0.03), (3, 12, 4)),
    pytest.param(VentilatedDisc(), None, marks=pytest.mark.slow),
    *CROWNED.values(),
    (Crowned(BOX, "x_min", {"y": 1.0}), (1, 3, 3)),
]
SPACE = Placement((1.0, -2.0, 0.5), 50.0, (0.3, -0.1, 2.0))
PLANE = Placement((0.0, 0.0, 1.0), 50.0, (0.3, 0.1, 0.0))


def straight_mesh(shape, elements, placement):
    """Mesh of straight facets: all its nodes are nodes of the shape."""
    if elements is None:
        return shape_mesh(shape, "tetrahedron", 1, size=0.02, placement=placement)
    cell = "quadrilateral" if len(shape.directions) == 2 else "hexahedron"
    return shape_mesh(shape, cell, 1, breaks=breaks_of(shape, elements), placement=placement)


def outwards(mesh, facets):
    """Normals of straight facets."""
    x = mesh.points[facets]
    normal = x[:, 1] - x[:, 0]
    if mesh.dim == 2:
        normal = np.column_stack([normal[:, 1], -normal[:, 0]])
    else:
        normal = np.cross(normal, x[:, 2] - x[:, 0])
    return normal / np.linalg.norm(normal, axis=1)[:, None]


@pytest.mark.parametrize(("shape", "elements"), SHAPES)
def test_nodes_of_meshes_lie_on_the_surfaces_and_normals_are_gradients(shape, elements):
    """Along a direction n, the distance s of x obeys ds = - v.dx / v.n with the normal v."""
    placement = PLANE if len(shape.directions) == 2 else SPACE
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


def depth_of(shape, x):
    """Depth of the face in its own words: polar coordinates, angles."""
    depth = np.zeros(len(x))
    for name, radius in shape.radii.items():
        low, high = dict(zip(shape.directions, shape.extent, strict=True))[name]
        apex = shape.apex.get(name, (low + high) / 2)
        r, theta = np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], x[:, 0])
        if name == "theta":
            distance = 2 * r * np.sin((theta - np.deg2rad(apex)) / 2)
        else:
            distance = {"x": x[:, 0], "y": x[:, 1], "z": x[:, -1], "r": r}[name] - apex
        depth += distance**2 / (2 * radius)
    return depth


CELLS = {"iga": (None, None), "boxes": ("quadrilateral", "hexahedron")}
CELLS["simplices"] = CELLS["unstructured"] = "triangle", "tetrahedron"


@pytest.mark.parametrize("kind", CELLS)
@pytest.mark.parametrize("name", CROWNED)
def test_a_crowned_face_is_the_paraboloid(name, kind):
    """To round-off on NURBS and straight bases; on sectors as h^3, quadratic interpolation."""
    shape, elements = CROWNED[name]
    dim, across = len(elements), shape.across
    mesh = 0.02 if kind == "unstructured" else elements
    body = shape_body(shape, CELLS[kind][dim - 2], 2, mesh, placement=PLANE)
    low, high = shape.extent[across]
    end = high if shape.at_high_end else low

    def before_placement(x):
        return (x - np.array(PLANE.translation)[:dim]) @ PLANE.rotation[:dim, :dim]

    face = body.surfaces[shape.surface]
    x = before_placement(face.gauss_points(5).x)
    found = (x[:, across] - end) * (-1.0 if shape.at_high_end else 1.0)
    rounded = kind != "iga" and shape.base.shape == "sector"
    third_derivative = sum(1 / radius for radius in shape.radii.values()) / shape.extent[0][0]
    allowed = face.mesh_size**3 / (9 * 3**0.5) * third_derivative if rounded else 1e-14
    np.testing.assert_allclose(found, depth_of(shape, x), rtol=0, atol=allowed)
    assert found.max() > 0.3 * shape.fall > 0
    opposite = shape.surfaces[2 * across + (not shape.at_high_end)]
    x = before_placement(body.surfaces[opposite].gauss_points(3).x)
    np.testing.assert_allclose(x[:, across], low + high - end, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ((BOX, "z_min", {"z": 1.0}), "radii"),
        ((BOX, "z_min", {"x": 0.1}), "radii"),
        ((BOX, "z_min", {"x": 1.0}, {"y": 0.1}), "apex"),
        ((BOX, "z_min", {"x": 1.0}, {"x": 0.3}), "apex[x]"),
    ],
)
def test_what_is_no_crown_is_refused(arguments, field):
    with pytest.raises(InputError) as caught:
        Crowned(*arguments)
    assert caught.value.field == field
