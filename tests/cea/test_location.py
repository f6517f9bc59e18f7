"""Point location on flat surfaces: shared edges, and the nearer of two sides."""

import numpy as np
import pytest
from bodies import PLASTIC, nurbs_body, shape_body

from cea.surface_points import Status
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.shapes import Box

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


@pytest.mark.parametrize("height", [0.001, 0.02, -0.02, -0.03, -0.049, -0.06])
def test_the_nearer_side_of_a_plate_is_met(height):
    """Whether it lies close by, or as far as both are looked for."""
    plate = Box((2.7, 2.1, 0.05), (0.0, 0.0, -0.05))
    patches, faces = nurbs_shape(plate, breaks_of(plate, (9, 7, 1))).patches, [(0, 2, 0), (0, 2, 1)]
    body = nurbs_body("plate", patches, {"both": faces}, (2, 2, 2), material=PLASTIC)
    surface = body.surfaces["both"]
    x = np.full((500, 3), height)
    x[:, :2] = np.random.default_rng(3).uniform((0.1, 0.1), (2.6, 2.0), (500, 2))
    found = surface.locate(x, np.tile(UP, (500, 1)), reach=0.2)
    assert not found.missed.any()
    nearest = min((-height, -0.05 - height), key=abs)
    np.testing.assert_allclose(found.distance, nearest, atol=1e-12)
