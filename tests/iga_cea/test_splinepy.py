"""Evaluation, derivatives, knot insertion and degree elevation against splinepy."""

import numpy as np
import pytest

from iga_cea.patch import Patch, refine
from iga_cea.splines import basis_functions, elevation_matrix, insertion_matrix
from meshes.nurbs_shapes import NurbsPatch

splinepy = pytest.importorskip("splinepy", reason="splinepy, the oracle, is not installed")
RNG = np.random.default_rng(17)


def knots_of(degree: int) -> np.ndarray:
    """Uneven, an inner knot as often as continuity 0 allows."""
    inner = np.concatenate([[0.2], np.repeat(0.55, degree), [0.8]])
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def net_of(degrees: tuple[int, ...]) -> NurbsPatch:
    """A regular, curved patch with uneven weights."""
    knots = tuple(knots_of(p) for p in degrees)
    counts = [len(k) - p - 1 for k, p in zip(knots, degrees, strict=True)]
    grid = np.stack(np.meshgrid(*(np.linspace(0, 1, n) for n in counts), indexing="ij"), axis=-1)
    points = grid + 0.02 * RNG.random(grid.shape)
    breaks = tuple(np.array([0.0, 0.3, 1.0]) for _ in degrees)
    return NurbsPatch(degrees, knots, points, 0.5 + RNG.random(counts), breaks)


def oracle(patch: NurbsPatch | Patch):
    """The same NURBS in splinepy, whose control points run fastest along the first parameter."""
    dim = len(patch.degrees)
    return splinepy.NURBS(
        degrees=list(patch.degrees),
        knot_vectors=[k.tolist() for k in patch.knots],
        control_points=patch.control_points.transpose(*range(dim)[::-1], dim).reshape(-1, dim),
        weights=patch.weights.T.reshape(-1, 1),
    )


def control_points(spline, patch: Patch) -> np.ndarray:
    """Control points of an oracle in the order of a patch."""
    dim = patch.dim
    net = np.asarray(spline.control_points).reshape(*patch.shape[::-1], dim)
    return net.transpose(*range(dim)[::-1], dim)


@pytest.mark.parametrize("degree", range(1, 9))
def test_basis_and_derivatives(degree: int) -> None:
    knots = knots_of(degree)
    n = len(knots) - degree - 1
    x = RNG.random((50, 1))
    spline = splinepy.BSpline([degree], [knots.tolist()], np.eye(n))
    first, values = basis_functions(knots, degree, x[:, 0], derivatives=3)
    for k in range(4):
        ours = np.zeros((len(x), n))
        np.put_along_axis(ours, first[:, None] + np.arange(degree + 1), values[k], axis=1)
        exact = spline.derivative(x, [k]) if k else spline.evaluate(x)
        assert np.abs(ours - exact).max() <= 1e-11 * max(1.0, np.abs(exact).max())


@pytest.mark.parametrize("degree", range(1, 9))
def test_knot_insertion(degree: int) -> None:
    knots = knots_of(degree)
    points = RNG.random((len(knots) - degree - 1, 2))
    inserted = [0.1, 0.31, 0.31, 0.8][: 4 if degree > 1 else 2]
    spline = splinepy.BSpline([degree], [knots.tolist()], points)
    spline.insert_knots(0, inserted)
    refined = np.sort(np.concatenate([knots, inserted]))
    ours = insertion_matrix(knots, degree, refined) @ points
    assert np.abs(ours - spline.control_points).max() < 1e-14


@pytest.mark.parametrize("degree", range(1, 8))
def test_degree_elevation(degree: int) -> None:
    """The oracle leaves a knot more than needed at times: ours are inserted up to its knots."""
    knots = knots_of(degree)
    points = RNG.random((len(knots) - degree - 1, 2))
    spline = splinepy.BSpline([degree], [knots.tolist()], points)
    for target in range(degree + 1, 9):
        spline.elevate_degrees([0])
        elevated, matrix = elevation_matrix(knots, degree, target)
        theirs = np.asarray(spline.knot_vectors[0])
        assert len(theirs) - len(elevated) in (0, 1)
        ours = insertion_matrix(elevated, target, theirs) @ matrix @ points
        assert np.abs(ours - spline.control_points).max() < 1e-12


@pytest.mark.parametrize("degrees", [(2, 1), (1, 3), (2, 1, 2)])
def test_refined_patches(degrees: tuple[int, ...]) -> None:
    """Elevation, then insertion: the oracle's own refinement gives the same control points."""
    geometry = net_of(degrees)
    target = tuple(p + 1 for p in degrees)
    patch = refine(geometry, target, tuple(q - 1 for q in target))
    spline = oracle(geometry)
    for axis in range(len(degrees)):
        spline.elevate_degrees([axis])
        spline.insert_knots(axis, [0.3])
    assert np.abs(control_points(spline, patch) - patch.control_points).max() < 1e-12
    x = RNG.random((20, len(degrees)))
    ours = np.concatenate(
        [
            patch.basis_on_grid(list(point[:, None])) @ patch.control_points.reshape(-1, patch.dim)
            for point in x
        ]
    )
    assert np.abs(ours - oracle(geometry).evaluate(x)).max() < 1e-13
