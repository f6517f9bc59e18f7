"""Collocation points and their weights: Greville, Botella and nodes; equal and shared by area."""

import numpy as np
import pytest
from bodies import shape_body
from covering import covering
from scipy.interpolate import BSpline
from scipy.optimize import minimize_scalar

from iga_cea.splines import botella, knots_with_breaks
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Disc, Rectangle, Ring

TILTED = Placement(axis=(1.0, 2.0, -0.5), angle=37.0, translation=(0.3, -0.2, 0.7))
BOX, ANNULUS = Box((2.0, 1.0, 0.5), (0.1, -0.3, 0.2)), Annulus(0.5, 1.0, 0.0, 0.3)
RECTANGLE, RING = Rectangle((2.0, 1.0)), Ring(0.5, 1.0)
MESHED = [(BOX, (3, 3, 2)), (ANNULUS, (1, 16, 1)), (Disc(1.0, 0.0, 0.2), (1, 8, 1))]
MESHED += [(RECTANGLE, (3, 2)), (RING, (2, 16))]


def surfaces_of(shape, cell, mesh, degree, **options):
    """Surfaces of a body, tilted in space, of cells or of NURBS."""
    options["placement"] = TILTED if len(shape.directions) == 3 else Placement()
    return shape_body(shape, cell, degree, mesh, **options).surfaces.values()


def weighted(surface, kind, weights):
    """Points of a kind with weights, after what all weights have in common is checked."""
    even, points = surface.abscissae(kind), surface.abscissae(kind, weights)
    np.testing.assert_array_equal(points.x, even.x)
    np.testing.assert_allclose(even.weight, surface.area / len(even), rtol=1e-15)
    assert points.weight.min() > 0
    assert points.weight.sum() == pytest.approx(surface.area, rel=1e-13)
    return points


def alive(surface, traces):
    """Functions that are not zero everywhere on a surface, which are its own."""
    found = np.flatnonzero(np.abs(traces).max(axis=0) > 1e-12)
    np.testing.assert_array_equal(np.unique(surface.function_dofs), found)
    return found


KNOTS = [
    knots_with_breaks(np.repeat([0.0, 1.0], p + 1), p, np.array(breaks), continuity)
    for p, continuity in ((1, 0), (2, 1), (2, 0), (3, 2), (3, 1), (4, 3), (4, 1), (5, 0), (8, 7))
    for breaks in ([], [0.5], [0.1, 0.2, 0.7], [0.01, 0.4, 0.41, 0.9])
]


@pytest.mark.parametrize("knots", KNOTS, ids=lambda k: f"{(k == 0).sum() - 1}-{len(k)}")
def test_botella_points_are_the_maxima(knots):
    """Against a search of each function by another implementation, polished by golden section."""
    degree = int((knots == 0).sum()) - 1
    points = botella(knots, degree)
    assert (np.diff(points) > 0).all()
    assert (points[0], points[-1]) == (0, 1)
    samples = np.unique(np.concatenate([np.linspace(0, 1, 1001), knots]))
    for found, coefficients in zip(points, np.eye(len(points)), strict=True):
        spline = BSpline(knots, -coefficients, degree)
        top = spline(samples).argmin()
        near = samples[[max(top - 1, 0), min(top + 1, len(samples) - 1)]]
        best = minimize_scalar(spline, bounds=near, method="bounded", options={"xatol": 1e-12})
        assert found == pytest.approx(best.x, abs=1e-6)
        assert spline(found) <= min(best.fun, spline(samples[top])) * (1 - 1e-14)


@pytest.mark.parametrize(
    ("meshed", "kind", "order"),
    covering(MESHED, ["greville", "botella"], [(2, None), (3, 1)], strength=1),
    ids=lambda s: getattr(s[0], "shape", "") if isinstance(s, tuple) else s,
)
def test_area_weights_are_integrals_of_the_traces(meshed, kind, order):
    (shape, elements), (degree, smooth) = meshed, order
    continuity = smooth and (smooth,) * len(elements)
    for surface in surfaces_of(shape, None, elements, degree, continuity=continuity):
        points, fine = weighted(surface, kind, "area"), surface.gauss_points(16)
        traces = surface.trace(fine.at).toarray()
        dofs, integrals = alive(surface, traces), fine.weight @ traces
        assert len(points) == len(dofs)
        np.testing.assert_allclose(np.sort(points.weight), np.sort(integrals[dofs]), rtol=1e-11)
        if kind == "botella":
            # The largest function at a maximum is its own, whose integral the point bears.
            own = surface.trace(points.at).toarray().argmax(axis=1)
            inner = np.bincount(own, minlength=surface.num_scalar_dofs)[own] == 1
            assert inner.mean() > 0.5
            np.testing.assert_allclose(points.weight[inner], integrals[own[inner]], rtol=1e-11)


@pytest.mark.parametrize(
    ("shape", "mesh", "cell", "degree"),
    [
        *((BOX, (3, 3, 2), "hexahedron", p) for p in (1, 2, 3)),
        *((BOX, 0.4, "tetrahedron", p) for p in (1, 2, 3)),
        (BOX, (2, 2, 1), "hexahedron", 4),
        (ANNULUS, (2, 16, 1), "hexahedron", 2),
        (ANNULUS, 0.4, "tetrahedron", 2),
        (RECTANGLE, (3, 2), "quadrilateral", 3),
        (RING, (2, 16), "quadrilateral", 2),
        (RING, 0.4, "triangle", 2),
    ],
    ids=lambda s: getattr(s, "shape", s) if not isinstance(s, tuple) else "",
)
def test_tributary_weights_share_each_facet_by_squares(shape, mesh, cell, degree):
    for surface in surfaces_of(shape, cell, mesh, degree):
        points, fine = weighted(surface, "nodes", "tributary"), surface.gauss_points(7)
        traces = surface.trace(fine.at).toarray()
        expected = np.zeros(surface.num_scalar_dofs)
        for facet in range(surface.num_elements):
            on = fine.at.element == facet
            squares = fine.weight[on] @ traces[on] ** 2
            expected += fine.weight[on].sum() * squares / squares.sum()
        picked = surface.trace(points.at).toarray()
        np.testing.assert_allclose(picked, np.rint(picked), atol=1e-14)
        own = picked.argmax(axis=1)
        np.testing.assert_array_equal(np.sort(own), alive(surface, traces))
        rel = 1e-12 if isinstance(shape, Box | Rectangle) else 1e-5
        np.testing.assert_allclose(points.weight, expected[own], rtol=rel)
