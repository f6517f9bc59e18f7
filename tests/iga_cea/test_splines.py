"""Splines of one parameter against scipy and closed forms; refinement keeps the geometry."""

import numpy as np
import pytest
from iga_data import TILTED, basis_on_grid
from scipy.interpolate import BSpline

from iga_cea.patch import refine
from iga_cea.splines import basis_functions
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.shapes import Annulus, Box, Sector

DEGREES = range(1, 9)
RNG = np.random.default_rng(7)


def open_knots(degree: int) -> np.ndarray:
    """Open, uneven, with an inner knot repeated as often as continuity 0 allows."""
    inner = np.concatenate([[0.1, 0.35], np.repeat(0.6, degree), [0.85]])
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def points(knots: np.ndarray) -> np.ndarray:
    return np.unique(np.concatenate([RNG.random(60), knots]))


@pytest.mark.parametrize("degree", DEGREES)
def test_basis_and_slopes_agree_with_scipy(degree: int) -> None:
    knots = open_knots(degree)
    x = points(knots)
    first, values = basis_functions(knots, degree, x, slopes=True)
    n = len(knots) - degree - 1
    for k in (0, 1):
        ours = np.zeros((len(x), n))
        np.put_along_axis(ours, first[:, None] + np.arange(degree + 1), values[k], axis=1)
        exact = BSpline(knots, np.eye(n), degree)(x, nu=k)
        assert np.abs(ours - exact).max() <= 1e-13 * max(1.0, np.abs(exact).max())


SHAPES = [
    Box((1.0, 2.0, 0.5), (0.1, 0.2, 0.3)),
    Annulus(0.8, 1.7, -0.1, 0.2),
    Sector(0.8, 1.7, 20.0, 130.0, -0.1, 0.2),
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.shape)
@pytest.mark.parametrize("degree", [(1, 2, 1), (2, 3, 4), (6, 6, 6), (8, 8, 8)])
def test_refinement_keeps_the_geometry(shape, degree: tuple[int, int, int]) -> None:
    coarse = nurbs_shape(shape, breaks_of(shape, (2, 8, 3)), TILTED)
    grid = [np.linspace(0, 1, 6)] * 3
    for geometry in coarse.patches:
        before = refine(geometry, geometry.degrees, tuple(p - 1 for p in geometry.degrees))
        after = refine(geometry, np.maximum(degree, geometry.degrees), (0, 1, 0))
        x = basis_on_grid(before, grid) @ before.control_points.reshape(-1, 3)
        y = basis_on_grid(after, grid) @ after.control_points.reshape(-1, 3)
        assert np.abs(x - y).max() < 1e-14
        assert after.spans == tuple(len(b) - 1 for b in geometry.breaks)


def test_breaks_that_do_not_fit_are_refused() -> None:
    annulus = SHAPES[1]
    r, _, z = breaks_of(annulus, (1, 4, 1))
    with pytest.raises(ValueError, match="theta"):
        nurbs_shape(annulus, (r, np.array([0.0, 90.0, 180.0, 360.0]), z))
    with pytest.raises(ValueError, match="breaks of r"):
        nurbs_shape(annulus, (r[::-1], np.array([0.0, 90.0, 180.0, 270.0, 360.0]), z))
