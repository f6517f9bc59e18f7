"""NURBS bodies of the plane: rigid motions, curves, traces, location, statics."""

import numpy as np
import pytest
from iga_data import STEEL, TURNED, body, scipy_of
from scipy.sparse.linalg import spsolve

from cea.body import Body
from cea.errors import InputError
from cea.supports.boundary import Pressure, Spring
from cea.surface_points import Status
from meshes.placement import Placement
from meshes.shapes import Rectangle, Ring, RingSector

INNER, OUTER, START, END = 0.8, 1.7, 20.0, 110.0
RECTANGLE = Rectangle((2.0, 1.0), (0.3, -0.2))
RING = Ring(INNER, OUTER)
SECTOR = RingSector(INNER, OUTER, START, END)
SHAPES = [RECTANGLE, RING, SECTOR]
RNG = np.random.default_rng(5)


def part_of(shape, placement: Placement = TURNED, **options) -> Body:
    return body(shape, (3, 8), (2, 4), placement, **options)


def length_of(shape, name: str) -> float:
    if isinstance(shape, Rectangle):
        return {"x": 1.0, "y": 2.0}[name[0]]
    turn = 2 * np.pi if isinstance(shape, Ring) else np.deg2rad(END - START)
    return {"inner": INNER * turn, "outer": OUTER * turn}.get(name, OUTER - INNER)


def normal_of(name: str, x: np.ndarray) -> np.ndarray:
    """Outward normal at points of a shape that has not been placed."""
    if name in ("inner", "outer"):
        return x / np.linalg.norm(x, axis=1)[:, None] * (1 if name == "outer" else -1)
    angle = np.deg2rad({"start": START - 90, "end": END + 90, "x_min": 180, "x_max": 0,
                        "y_min": -90, "y_max": 90}[name])  # fmt: skip
    return np.tile([np.cos(angle), np.sin(angle)], (len(x), 1))


def test_quarters_of_a_ring_are_joined() -> None:
    part = body(RING, (3, 8), (2, 3))
    assert part.num_scalar_dofs == (3 + 2) * 4 * (2 + 2)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.shape)
def test_curves(shape) -> None:
    """Lengths, weights, outward normals, traces and gradients of a linear field."""
    part = part_of(shape)
    assert tuple(part.surfaces) == shape.surfaces
    for name, curve in part.surfaces.items():
        assert curve.area == pytest.approx(length_of(shape, name), rel=1e-13)
        gauss = curve.gauss_points(6)
        assert gauss.weight.sum() == pytest.approx(length_of(shape, name), rel=1e-10)
        for points in (gauss, curve.abscissae("greville"), curve.grid(5)):
            assert points.weight.min() > 0
            assert points.weight.sum() == pytest.approx(curve.area, rel=1e-6)
            original = (points.x - TURNED.translation[:2]) @ TURNED.rotation[:2, :2]
            expected = normal_of(name, original) @ TURNED.rotation[:2, :2].T
            assert np.abs(points.normal - expected).max() < 1e-13
            trace, gradient = curve.trace(points.at), curve.gradient(points.at)
            assert np.abs(trace @ part.dof_positions - points.x).max() < 2e-15
            linear = part.dof_positions @ [0.3, -0.7]
            for slope, along in zip((0.3, -0.7), gradient, strict=True):
                assert np.abs(along @ linear - slope).max() < 1e-12


def test_numbers_of_points_on_a_ring() -> None:
    outer = part_of(RING).surfaces["outer"]
    assert len(outer.gauss_points(3)) == 24
    assert len(outer.abscissae("greville")) == len(outer.dofs) == 4 * 5
    assert len(outer.grid(4)) == 4 * 3


@pytest.mark.parametrize(("name", "radius"), [("outer", OUTER), ("inner", INNER)])
def test_location_on_circles(name: str, radius: float) -> None:
    """Oblique lines against the roots of a quadratic; past the reach they are missed."""
    count, reach = 2000, 0.3
    part = part_of(RING, Placement())
    angle = RNG.uniform(0, 2 * np.pi, count)
    outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    x = outward * (radius + RNG.uniform(-0.4, 0.4, count))[:, None]
    direction = outward + RNG.uniform(-0.7, 0.7, (count, 2))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    b, c = (x * direction).sum(axis=1), (x**2).sum(axis=1) - radius**2
    root = np.sqrt(np.maximum(b**2 - c, 0))
    roots = np.stack([-b - root, -b + root])
    exact = np.take_along_axis(roots, np.abs(roots).argmin(axis=0)[None], axis=0)[0]
    hit = (b**2 >= c) & (np.abs(exact) <= reach)
    found = part.surfaces[name].locate(x, direction, reach)
    assert 500 < hit.sum() < count - 200
    np.testing.assert_array_equal(found.missed, ~hit)
    assert np.abs(found.distance[hit] - exact[hit]).max() < 1e-9


def test_location_at_the_ends_of_a_straight_side() -> None:
    x_max = body(RECTANGLE, (2, 3), (2, 2), Placement()).surfaces["x_max"]
    x = np.stack([np.full(5, 2.4), [-0.21, -0.2, 0.3, 0.8, 0.81]], axis=1)
    found = x_max.locate(x, np.tile([1.0, 0.0], (5, 1)), 0.5)
    missed, edge, inside = Status.MISSED, Status.EDGE, Status.INSIDE
    np.testing.assert_array_equal(found.status, [missed, edge, inside, edge, missed])
    np.testing.assert_allclose(found.distance[1:4], -0.1, atol=1e-14)


def static(part: Body) -> np.ndarray:
    x = spsolve(scipy_of(part.stiffness()).tocsc(), part.load().getArray())
    return (scipy_of(part.expansion) @ x).reshape(-1, 2)


def test_ring_under_pressure_against_lame() -> None:
    """Radial displacement of a thick ring in plane strain; a soft foundation holds its place."""
    part = body(
        RING,
        (6, 24),
        (4, 4),
        Placement(),
        springs=[Spring("outer", (1e-9, 1e-9))],
        pressures=[Pressure("inner", 0.7)],
    )
    points = part.surfaces["inner"].gauss_points(3)
    moved = part.surfaces["inner"].trace(points.at) @ static(part)
    E, nu, ratio = STEEL.E, STEEL.nu, (OUTER / INNER) ** 2
    radial = 0.7 * INNER * (1 + nu) / E * ((1 - 2 * nu) + ratio) / (ratio - 1)
    drift = moved.mean(axis=0)  # what rounding leaves of the resultant moves the foundation
    assert np.abs(drift).max() < 1e-5 * radial
    np.testing.assert_allclose(moved - drift, -radial * points.normal, atol=1e-6 * radial)


def test_wrong_dimensions_are_refused() -> None:
    with pytest.raises(InputError, match=r"degree = \(2, 2, 2\): 2 whole numbers"):
        body(RING, (2, 8), (2, 2, 2), TURNED)
    with pytest.raises(InputError, match=r"springs\[0\].stiffness"):
        body(RING, (2, 8), (2, 2), springs=[Spring("inner", (1.0, 1.0, 1.0))])
