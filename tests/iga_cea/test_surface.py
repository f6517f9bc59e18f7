"""Surfaces of NURBS bodies: handedness, derivatives along the normal, edges; point location."""

import numpy as np
import pytest
from bodies import PLASTIC, nurbs_body, shape_body
from iga_data import TILTED, basis_on_grid
from scipy.interpolate import BPoly

from cea.surface_points import Status
from iga_cea.splines import grid_points
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Hub, Sector

INNER, OUTER, BOTTOM, TOP = 0.8, 1.7, -0.1, 0.2
START, END = 20.0, 110.0
ANNULUS = Annulus(INNER, OUTER, BOTTOM, TOP)
SECTOR = Sector(INNER, OUTER, START, END, BOTTOM, TOP)
BOX = Box((2.0, 1.0, 0.5), (0.1, 0.2, 0.3))
SLOW = pytest.mark.slow


def body(shape, elements=(2, 8, 2), degree=(2, 3, 2), placement=TILTED):
    return shape_body(shape, None, degree, elements, placement=placement)


def test_normals_point_outward_whatever_the_handedness():
    """A box whose first parameter runs backward."""
    patch = nurbs_shape(BOX, breaks_of(BOX, (2, 2, 2))).patches[0]
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


def test_gradient_agrees_with_finite_differences_of_the_volume():
    """A rough field: its derivative along the normal needs the layer behind the face."""
    part = body(SECTOR, (1, 2, 1))
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
    top = body(ANNULUS, placement=Placement()).surfaces["top"]
    found = top.locate(x, np.tile([0.0, 0.0, 1.0], (36, 1)), 0.1)
    assert (found.status == Status.EDGE).all()
    assert np.abs(found.distance + 0.05).max() < 1e-14


def test_faces_go_on_beyond_their_edges_whatever_their_outermost_spans_are():
    tiny = np.array([0.0, 1e-5, 1e-3, 0.1, 0.5, 0.9, 1 - 1e-3, 1 - 1e-5, 1.0])
    ends = ((INNER, OUTER), (START, END), (BOTTOM, TOP))
    refined, plain = (
        nurbs_body("part", data.patches, data.faces, degree, material=PLASTIC).surfaces["top"]
        for data, degree in (
            (nurbs_shape(SECTOR, [a + (b - a) * tiny for a, b in ends], TILTED), (5, 5, 5)),
            (nurbs_shape(SECTOR, breaks_of(SECTOR, (1, 1, 1)), TILTED), (2, 2, 2)),
        )
    )
    parts = np.array([-0.5, -0.01, 0.3, 1.01, 1.5])
    xi = grid_points(tuple(k[0] + (k[-1] - k[0]) * parts for k in refined.faces[0].knots))
    element = np.zeros(len(xi), dtype=np.int64)
    for found, exact in zip(
        refined.tangents(element, xi), plain.tangents(element, xi), strict=True
    ):
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-12 * np.abs(exact).max())


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


@pytest.mark.parametrize(
    ("shape", "name", "radius", "low", "high"),
    [
        (ANNULUS, "inner", 0.8, -0.1, 0.2),
        pytest.param(
            Hub(0.3, 0.5, 1.0, -0.1, 0.15, -0.3, 0.15), "bore", 0.3, -0.3, 0.15, marks=SLOW
        ),
    ],
)
def test_cylinders(shape, name, radius, low, high):
    """Oblique lines from points offset to either side, rotated; also past the rims."""
    rng, count = np.random.default_rng(2), 10_000
    angle, z = rng.uniform(0, 2 * np.pi, count), rng.uniform(low - 0.1, high + 0.1, count)
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    x = outward * (radius * (1 + rng.uniform(-0.3, 0.3, count)))[:, None]
    x[:, 2] = z
    direction = outward + 0.6 * rng.uniform(-1, 1, (count, 3))
    direction *= (rng.choice([-1, 1], count) / np.linalg.norm(direction, axis=1))[:, None]
    reach = 0.5 * radius
    exact = nearest_root(x, direction, radius, low, high, reach)
    surface = body(shape, (2, 16, 3)).surfaces[name]
    found = surface.locate(TILTED.apply(x), direction @ TILTED.rotation.T, reach)
    hit = ~np.isnan(exact)
    assert 0.4 * count < hit.sum() < 0.9 * count
    np.testing.assert_array_equal(found.missed, ~hit)
    assert np.abs(found.distance[hit] - exact[hit]).max() < 1e-8


HEIGHTS = np.array(
    [[0.0, 0.3, -0.2, 0.1], [0.4, -0.3, 0.2, 0.0], [-0.1, 0.5, -0.4, 0.3], [0.2, 0.0, 0.1, -0.2]]
)


@pytest.mark.parametrize("gap", [0.05, *(pytest.param(g, marks=SLOW) for g in (0.0, -0.08))])
def test_graph_of_a_polynomial(gap):
    """The top of a slab at z = f(x, y): along z there is one answer, and none beside the slab."""
    rng, count, cubic = np.random.default_rng(1), 10_000, np.repeat([0.0, 1.0], 4)
    net = np.stack([*np.mgrid[0:1:4j, 0:1:4j, -0.5:0:2j]], axis=-1)
    net[:, :, 1, 2] = HEIGHTS
    ends = np.array([0.0, 1.0])
    slab = NurbsPatch((3, 3, 1), (cubic, cubic, np.repeat(ends, 2)), net, np.ones((4, 4, 2)),
                      (np.linspace(0, 1, 6), np.linspace(0, 1, 5), ends))  # fmt: skip
    top = nurbs_body("slab", [slab], {"top": [(0, 2, 1)]}, (3, 4, 1), material=PLASTIC)
    x = rng.uniform(-0.15, 1.15, (count, 3))
    edge = rng.random(count) < 0.05
    x[edge, 0] = np.round(x[edge, 0])
    inside = ((x[:, :2] >= 0) & (x[:, :2] <= 1)).all(axis=1)
    u, v = (BPoly(np.eye(4)[:, None], ends)(np.clip(x[:, k], 0, 1)) for k in (0, 1))
    x[:, 2] = np.einsum("ni,ij,nj->n", u, HEIGHTS, v)
    up = np.tile([0.0, 0.0, 1.0], (count, 1))
    surface = top.surfaces["top"]
    found = surface.locate(x + gap * up, up, 1.0)
    rim = np.isin(x[:, 0], ends)
    expected = np.where(inside, np.where(rim, Status.EDGE, Status.INSIDE), Status.MISSED)
    np.testing.assert_array_equal(found.status, expected)
    assert np.abs(found.distance[inside] + gap).max() < 1e-9
    assert np.abs(surface.position(found.at[inside]) - x[inside]).max() < 1e-8


def test_flat_faces_are_taken_for_what_they_are():
    """Sides of a turned box as affine maps and by their splines; no flat side of a ring is one."""
    sides = [body(BOX, (5, 4, 2)).surfaces["y_max"] for _ in range(2)]
    flat, general = sides
    for face in general.faces:
        face.__dict__["affine"] = None
    assert all(face.affine is not None for face in flat.faces)
    assert general.area == pytest.approx(flat.area, rel=1e-14)
    given, same = flat.gauss_points(3), general.gauss_points(3)
    for found, expected in ((given.x, same.x), (given.normal, same.normal)):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(given.weight, same.weight, rtol=1e-13)
    rng = np.random.default_rng(8)
    x = given.x[rng.integers(0, len(given), 2000)] + rng.normal(0, 0.15, (2000, 3))
    direction = given.normal[0] + rng.normal(0, 0.2, (2000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    found, expected = (side.locate(x, direction, 0.15) for side in sides)
    assert 200 < found.missed.sum() < 1800
    assert np.array_equal(found.status, expected.status)
    hit = ~found.missed
    np.testing.assert_allclose(found.distance[hit], expected.distance[hit], rtol=0, atol=1e-13)
    np.testing.assert_allclose(found.at.xi[hit], expected.at.xi[hit], rtol=0, atol=1e-13)
    ring = body(ANNULUS, (2, 8, 1), (2, 2, 2)).surfaces
    assert all(face.affine is None for name in ("top", "outer") for face in ring[name].faces)
