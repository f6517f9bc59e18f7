"""NURBS bodies of the plane: rigid motions, curves, traces, location, statics."""

import numpy as np
import pytest
from iga_data import STEEL, TURNED, body, scipy_of
from scipy.sparse.linalg import spsolve

from cea.body import Body
from cea.errors import InputError
from cea.supports.boundary import Pressure, Spring
from meshes.placement import Placement
from meshes.shapes import Ring

INNER, OUTER, START, END = 0.8, 1.7, 20.0, 110.0
RING = Ring(INNER, OUTER)
RNG = np.random.default_rng(5)


def part_of(shape, placement: Placement = TURNED, **options) -> Body:
    return body(shape, (3, 8), (2, 4), placement, **options)


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
