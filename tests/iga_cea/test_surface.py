"""Surfaces of NURBS bodies: handedness, derivatives along the normal, edges; point location."""

import numpy as np
import pytest
from bodies import PLASTIC, nurbs_body
from iga_data import TILTED, basis_on_grid, body

from cea.surface_points import Status
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Sector

INNER, OUTER, BOTTOM, TOP = 0.8, 1.7, -0.1, 0.2
START, END = 20.0, 110.0
ANNULUS = Annulus(INNER, OUTER, BOTTOM, TOP)
SECTOR = Sector(INNER, OUTER, START, END, BOTTOM, TOP)
BOX = Box((2.0, 1.0, 0.5), (0.1, 0.2, 0.3))


def test_normals_point_outward_and_cells_are_not_inverted_whatever_the_handedness():
    """A box whose first parameter runs backward."""
    patch = nurbs_shape(BOX, breaks_of(BOX, (2, 2, 2)))[0][0]
    mirrored = NurbsPatch(
        patch.degrees, patch.knots, patch.control_points[::-1], patch.weights, patch.breaks
    )
    faces = {"x_max": [(0, 0, 0)], "x_min": [(0, 0, 1)], "z_max": [(0, 2, 1)]}
    part = nurbs_body("part", [mirrored], faces, (2, 2, 2), material=PLASTIC)
    for name, surface in part.surfaces.items():
        points = surface.gauss_points(2)
        outward = np.eye(3)["xyz".index(name[0])] * (1 if name.endswith("max") else -1)
        np.testing.assert_allclose(points.normal, np.tile(outward, (len(points), 1)), atol=1e-14)
    assert (part.stiffness().getDiagonal().getArray() > 0).all()
    cells = part.space.volume_cells().straight()
    corners = cells.points[cells.cells]
    assert np.linalg.det(corners[:, [4, 2, 1]] - corners[:, :1]).min() > 0


def test_gradient_agrees_with_finite_differences_of_the_volume():
    """A rough field: its derivative along the normal needs the layer behind the face."""
    part = body(SECTOR, (1, 2, 1), (2, 3, 2))
    (patch,) = part.space.multipatch.patches
    field = np.random.default_rng(11).random(part.num_scalar_dofs)
    sampled = np.column_stack(
        [field[part.space.multipatch.dofs[0].ravel()], patch.control_points.reshape(-1, 3)]
    )
    one_sided, step = np.array([-1.5, 2.0, -0.5]), 1e-6
    ends = [(axis, side) for axis in range(3) for side in (0, 1)]
    for (name, surface), (axis, side) in zip(part.surfaces.items(), ends, strict=True):
        at = surface.gauss_points(1).at
        gradient = np.stack([g @ field for g in surface.gradient(at)], axis=1)
        for row, xi in enumerate(at.xi):
            inward = (1 - 2 * side) * step * np.eye(3)[axis]
            places = np.insert(xi, axis, side) + np.outer(range(3), inward)
            values = [basis_on_grid(patch, list(place[:, None])) @ sampled for place in places]
            change, *tangent = one_sided @ np.array(values)[:, 0]
            assert gradient[row] @ tangent == pytest.approx(change, abs=1e-9), name


def test_location_of_edges_and_joints():
    angle = np.concatenate([np.linspace(0, 2 * np.pi, 33), [0, np.pi / 2, np.pi]])
    radius = np.concatenate([np.tile([INNER, OUTER], 17)[:33], [1.0, 1.1, 1.2]])
    x = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(36, TOP + 0.05)], 1)
    top = body(ANNULUS, (1, 16, 2), (2, 3, 2), placement=Placement()).surfaces["top"]
    found = top.locate(x, np.tile([0.0, 0.0, 1.0], (36, 1)), 0.1)
    assert (found.status == Status.EDGE).all()
    assert np.abs(found.distance + 0.05).max() < 1e-14


def nearest_root(x, direction, radius, low, high, reach):
    """Signed distance to the nearest point of a cylinder about z between heights; NaN for none."""
    a = (direction[:, :2] ** 2).sum(axis=1)
    b = (x[:, :2] * direction[:, :2]).sum(axis=1)
    c = (x[:, :2] ** 2).sum(axis=1) - radius**2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b**2 - a * c)
    s = np.stack([-b - root, -b + root]) / a
    z = x[:, 2] + s * direction[:, 2]
    s = np.where((z >= low) & (z <= high) & (np.abs(s) <= reach), s, np.inf)
    nearest = np.take_along_axis(s, np.abs(s).argmin(axis=0)[None], axis=0)[0]
    return np.where(np.isfinite(nearest), nearest, np.nan)


def test_oblique_lines_meet_a_cylinder_where_they_should():
    """Lines from points offset to either side, rotated; also past the rims."""
    radius, low, high = INNER, BOTTOM, TOP
    rng, count = np.random.default_rng(2), 1000
    angle, z = rng.uniform(0, 2 * np.pi, count), rng.uniform(low - 0.1, high + 0.1, count)
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    x = outward * (radius * (1 + rng.uniform(-0.3, 0.3, count)))[:, None]
    x[:, 2] = z
    direction = outward + 0.6 * rng.uniform(-1, 1, (count, 3))
    direction *= (rng.choice([-1, 1], count) / np.linalg.norm(direction, axis=1))[:, None]
    reach = 0.5 * radius
    exact = nearest_root(x, direction, radius, low, high, reach)
    surface = body(ANNULUS, (1, 16, 3), (2, 3, 2)).surfaces["inner"]
    found = surface.locate(TILTED.apply(x), direction @ TILTED.rotation.T, reach)
    hit = ~np.isnan(exact)
    assert 0.4 * count < hit.sum() < 0.9 * count
    np.testing.assert_array_equal(found.missed, ~hit)
    assert np.abs(found.distance[hit] - exact[hit]).max() < 1e-8


@pytest.mark.parametrize("height", [0.001, 0.02, -0.02, -0.03, -0.049, -0.06])
def test_the_nearer_side_of_a_plate_is_met(height):
    """Whether it lies close by, or as far as both are looked for."""
    plate = Box((2.7, 2.1, 0.05), (0.0, 0.0, -0.05))
    patches, faces = nurbs_shape(plate, breaks_of(plate, (9, 7, 1)))[0], [(0, 2, 0), (0, 2, 1)]
    part = nurbs_body("plate", patches, {"both": faces}, (2, 2, 2), material=PLASTIC)
    surface = part.surfaces["both"]
    x = np.full((500, 3), height)
    x[:, :2] = np.random.default_rng(3).uniform((0.1, 0.1), (2.6, 2.0), (500, 2))
    found = surface.locate(x, np.tile([0.0, 0.0, 1.0], (500, 1)), reach=0.2)
    assert not found.missed.any()
    nearest = min((-height, -0.05 - height), key=abs)
    np.testing.assert_allclose(found.distance, nearest, atol=1e-12)
