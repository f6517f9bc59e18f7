"""Point location alone against closed forms: curved, rotated and offset surfaces."""

import numpy as np
import pytest
from iga_data import TILTED, body

from cea.surface_points import Status
from meshes.patches import GivenPatch, Patches
from meshes.shapes import Annulus, Box, Hub

SLOW = pytest.mark.slow
UNITS_BEYOND = 0.15


def wavy_slab() -> Patches:
    """Slab under the graph of a bicubic polynomial: x = u, y = v, top at z = f(u, v)."""
    line, cubic = (0.0, 0.0, 1.0, 1.0), (0.0,) * 4 + (1.0,) * 4
    u, v = np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 4), indexing="ij")
    points = np.empty((4, 4, 2, 3))
    points[..., 0], points[..., 1] = u[..., None], v[..., None]
    points[..., 0, 2], points[..., 1, 2] = -0.5, HEIGHTS
    patch = GivenPatch((3, 3, 1), (cubic, cubic, line), points.tolist())
    return Patches((patch,), {"top": ((0, 2, 1),)})


HEIGHTS = np.array(
    [[0.0, 0.3, -0.2, 0.1], [0.4, -0.3, 0.2, 0.0], [-0.1, 0.5, -0.4, 0.3], [0.2, 0.0, 0.1, -0.2]]
)


def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """f(u, v) in Bernstein's form."""
    bernstein = [
        np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3]) for t in (x, y)
    ]
    return np.einsum("in,ij,jn->n", bernstein[0], HEIGHTS, bernstein[1])


@pytest.mark.parametrize("gap", [0.05, *(pytest.param(g, marks=SLOW) for g in (0.0, -0.08))])
def test_graph_of_a_polynomial(gap: float) -> None:
    """Along z there is one answer, and none beside the slab."""
    rng, count = np.random.default_rng(1), 10_000
    top = body(wavy_slab(), (5, 4, 1), (3, 4, 1)).surfaces["top"]
    x, y = rng.uniform(-UNITS_BEYOND, 1 + UNITS_BEYOND, (2, count))
    edge = rng.random(count) < 0.05
    x[edge] = np.round(x[edge])
    inside = (x >= 0) & (x <= 1) & (y >= 0) & (y <= 1)
    foot = np.stack([x, y, np.where(inside, height(*np.clip([x, y], 0, 1)), 0.0)], axis=1)
    points = foot + np.array([0.0, 0.0, gap])
    up = np.broadcast_to(TILTED.rotation[:, 2], points.shape)
    found = top.locate(TILTED.apply(points), up, 1.0)
    np.testing.assert_array_equal(found.missed, ~inside)
    on_edge = inside & ((x == 0) | (x == 1))
    assert (found.status[on_edge] == Status.EDGE).all()
    assert (found.status[inside & ~on_edge] == Status.INSIDE).all()
    assert np.abs(found.distance[inside] + gap).max() < 1e-9
    assert np.abs(top.position(found.at[inside]) - TILTED.apply(foot[inside])).max() < 1e-8


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
        (Annulus(0.8, 1.7, -0.1, 0.2), "inner", 0.8, -0.1, 0.2),
        pytest.param(
            Hub(0.3, 0.5, 1.0, -0.1, 0.15, -0.3, 0.15), "bore", 0.3, -0.3, 0.15, marks=SLOW
        ),
    ],
)
def test_cylinders(shape, name: str, radius: float, low: float, high: float) -> None:
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
    surface = body(shape, (2, 16, 3), (2, 3, 2)).surfaces[name]
    found = surface.locate(TILTED.apply(x), direction @ TILTED.rotation.T, reach)
    hit = ~np.isnan(exact)
    assert 0.4 * count < hit.sum() < 0.9 * count
    np.testing.assert_array_equal(found.missed, ~hit)
    assert np.abs(found.distance[hit] - exact[hit]).max() < 1e-8


def test_flat_faces_are_taken_for_what_they_are() -> None:
    """Sides of a turned box as affine maps and by their splines; no flat side of a ring is one."""
    sides = [body(Box((2.0, 1.0, 0.5)), (5, 4, 2), (2, 3, 2)).surfaces["y_max"] for _ in range(2)]
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
    for name in ("top", "outer"):
        ring = body(Annulus(0.8, 1.7, -0.1, 0.2), (2, 8, 1), (2, 2, 2)).surfaces[name]
        assert all(face.affine is None for face in ring.faces)
