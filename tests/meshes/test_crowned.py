"""Crowned faces: paraboloids to round-off in NURBS and quadratic cells, all else where it was."""

import numpy as np
import pytest
from bodies import lagrange_body, nurbs_body
from iga_data import STEEL

from cea.errors import InputError
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box, Crowned, Rectangle, Sector

BOX = Box((0.3, 0.2, 0.1), origin=(-0.1, 0.05, 0.02))
SECTOR = Sector(0.1, 0.14, 25.0, 65.0, 0.01, 0.03)
RECTANGLE = Rectangle((0.3, 0.2), origin=(-0.1, 0.05))
CROWNED = {
    "rectangle": Crowned(RECTANGLE, "y_min", {"x": 1.5}),
    "rectangle, off its middle": Crowned(RECTANGLE, "x_max", {"y": 0.8}, {"y": 0.05}),
    "box": Crowned(BOX, "z_min", {"x": 2.0, "y": 0.7}, {"x": -0.1}),
    "box, one way": Crowned(BOX, "y_max", {"z": 0.7}),
    "sector": Crowned(SECTOR, "bottom", {"theta": 0.3}),
    "sector, both ways": Crowned(SECTOR, "top", {"theta": 0.3, "r": 0.5}, {"theta": 30.0}),
}
ELEMENTS = {"rectangle": (3, 2), "box": (3, 2, 2), "sector": (2, 5, 2)}
PLACEMENT = Placement(axis=(0.0, 0.0, 1.0), angle=50.0, translation=(0.3, 0.1, 0.0))


def body_of(shape, kind, placement=PLACEMENT):
    breaks = breaks_of(shape, ELEMENTS[shape.base.shape])
    if kind == "iga":
        data = nurbs_shape(shape, breaks, placement)
        degree = (2,) * len(shape.directions)
        return nurbs_body("part", data.patches, data.faces, degree, material=STEEL)
    flat = len(shape.directions) == 2
    boxes, simplices = ("quadrilateral", "triangle") if flat else ("hexahedron", "tetrahedron")
    cell = boxes if kind == "boxes" else simplices
    where = {"size": 0.02} if kind == "unstructured" else {"breaks": breaks}
    mesh = shape_mesh(shape, cell, 2, placement=placement, **where)
    return lagrange_body("part", mesh, degree=2, material=STEEL)


def native(x, placement=PLACEMENT):
    """Points of a placed shape before it was placed."""
    dim = x.shape[1]
    return (x - np.array(placement.translation)[:dim]) @ placement.rotation[:dim, :dim]


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


@pytest.mark.parametrize("kind", ["iga", "boxes", "simplices", "unstructured"])
@pytest.mark.parametrize("name", CROWNED)
def test_the_face_is_the_paraboloid(name, kind):
    """To round-off on NURBS and straight bases; on sectors as h^3, quadratic interpolation."""
    shape = CROWNED[name]
    body = body_of(shape, kind)
    across = shape.across
    low, high = shape.extent[across]
    face = body.surfaces[shape.surface]
    x = native(face.gauss_points(5).x)
    inwards, end = (-1.0, high) if shape.at_high_end else (1.0, low)
    found = inwards * (x[:, across] - end)
    rounded = kind != "iga" and shape.base.shape == "sector"
    third_derivative = sum(1 / radius for radius in shape.radii.values()) / shape.extent[0][0]
    allowed = face.mesh_size**3 / (9 * 3**0.5) * third_derivative if rounded else 1e-14
    np.testing.assert_allclose(found, depth_of(shape, x), rtol=0, atol=allowed)
    assert found.max() > 0.3 * shape.fall > 0
    opposite = shape.surfaces[2 * across + (not shape.at_high_end)]
    x = native(body.surfaces[opposite].gauss_points(3).x)
    np.testing.assert_allclose(x[:, across], low + high - end, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ((BOX, "bottom", {"x": 1.0}), "surface"),
        ((SECTOR, "outer", {"theta": 1.0}), "surface"),
        ((BOX, "z_min", {}), "radii"),
        ((BOX, "z_min", {"z": 1.0}), "radii"),
        ((BOX, "z_min", {"x": 0.0}), "radii[x]"),
        ((BOX, "z_min", {"x": float("nan")}), "radii[x]"),
        ((BOX, "z_min", {"x": 0.1}), "radii"),
        ((BOX, "z_min", {"x": 1.0}, {"y": 0.1}), "apex"),
        ((BOX, "z_min", {"x": 1.0}, {"x": 0.3}), "apex[x]"),
    ],
)
def test_what_is_no_crown_is_refused(arguments, field):
    with pytest.raises(InputError) as caught:
        Crowned(*arguments)
    assert caught.value.field == field
