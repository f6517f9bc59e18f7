"""Point location on surfaces known in closed form."""

import numpy as np
import pytest

from cea.location import TOLERANCE, Chart
from cea.surface_points import Status, SurfaceCells


class Grid(Chart):
    """nx x ny elements over the parameters u, v of a surface in closed form."""

    def __init__(self, low, high, shape):
        self.low, self.shape = np.array(low), shape
        self.step = (np.array(high) - low) / shape  # size of an element in parameters

    @property
    def count(self):
        """Number of elements."""
        return int(np.prod(self.shape))

    @property
    def domains(self):
        """Unit squares."""
        return np.zeros((self.count, 2)), np.ones((self.count, 2))

    def cells(self):
        """The elements."""
        outline = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        return SurfaceCells(np.arange(self.count), np.tile(outline, (self.count, 1, 1)), 2, True)

    def parameters(self, element, xi):
        """Parameters of points in elements."""
        cell = np.stack(np.unravel_index(element, self.shape), axis=1)
        return self.low + (cell + xi) * self.step

    def tangents(self, element, xi):
        """Positions and derivatives along xi."""
        x, derivatives = self.surface(*self.parameters(element, xi).T)
        return x, derivatives * self.step

    def size(self, element):
        """Largest side of an element."""
        return np.full(len(element), self.step.max() * self.radius)


class Plane(Grid):
    """z = 0."""

    radius = 1.0

    def surface(self, u, v):
        """Positions and derivatives along the parameters."""
        x = np.stack([u, v, np.zeros_like(u)], axis=1)
        return x, np.tile(np.eye(3)[:, :2], (len(u), 1, 1))


class Cylinder(Grid):
    """Angle u and height v on a cylinder of radius 2 about the z axis."""

    radius = 2.0

    def surface(self, u, v):
        """Positions and derivatives along the parameters."""
        zero, up = np.zeros_like(u), np.tile([0.0, 0.0, 1.0], (len(u), 1))
        radial = np.stack([np.cos(u), np.sin(u), zero], axis=1)
        around = np.stack([-np.sin(u), np.cos(u), zero], axis=1)
        return self.radius * radial + v[:, None] * up, np.stack([self.radius * around, up], axis=2)


class Floors(Plane):
    """Two planes: the upper half of the elements lies below the other, one above the other."""

    depth = 0.05

    @property
    def count(self):
        """Elements of both floors."""
        return 2 * super().count

    def tangents(self, element, xi):
        """Positions and derivatives, those of the lower floor farther down."""
        upper = super().count
        x, derivatives = super().tangents(element % upper, xi)
        x[:, 2] -= np.where(element < upper, 0.0, self.depth)
        return x, derivatives


PLANE = (-1.0, 0.5), (2.0, 2.5), (9, 7)
EACH = pytest.mark.parametrize(
    "chart",
    [Plane(*PLANE), Cylinder((-1.2, -0.4), (1.3, 0.9), (8, 5))],
    ids=lambda chart: type(chart).__name__,
)


def lifted(chart, rng, place):
    """Points off the places on a chart, normals there, signed distances."""
    x, tangents = chart.surface(*(chart.low + place * chart.step).T)
    normal = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    distance = rng.uniform(-0.05, 0.05, len(x))
    return x - distance[:, None] * normal, normal, distance


@EACH
def test_points_along_normals(chart):
    rng = np.random.default_rng(4)
    place = rng.uniform(-0.8, np.add(chart.shape, 0.8), (10_000, 2))
    x, normal, distance = lifted(chart, rng, place)
    found = chart.locate(x, normal, reach=0.06)
    outside = ((place < 0) | (place > chart.shape)).any(axis=1)
    assert 0.1 < outside.mean() < 0.6
    np.testing.assert_array_equal(found.status == Status.MISSED, outside)
    hit = ~outside
    assert (found.status[hit] == Status.INSIDE).all()
    cell, element = np.floor(place[hit]).astype(int), found.at.element[hit]
    np.testing.assert_array_equal(element, np.ravel_multi_index(cell.T, chart.shape))
    parameters = chart.parameters(element, found.at.xi[hit])
    np.testing.assert_allclose(parameters, chart.low + place[hit] * chart.step, atol=1e-9)
    np.testing.assert_allclose(found.distance[hit], distance[hit], atol=1e-9)
    assert (found.miss[hit] <= TOLERANCE * chart.size(element)).all()
    assert (found.miss[outside] > TOLERANCE * chart.step.max() * chart.radius).all()
    if isinstance(chart, Plane):
        beyond = (place - np.clip(place, 0, chart.shape)) * chart.step
        near = outside & np.isfinite(found.miss)
        expected = np.linalg.norm(beyond[near], axis=1)
        np.testing.assert_allclose(found.miss[near], expected, atol=1e-9)


@EACH
def test_shared_edges_and_corners_go_to_the_lowest_element(chart):
    """Whatever the order of points, and with rounding either way."""
    rng = np.random.default_rng(6)
    lines = rng.integers(1, np.array(chart.shape), (3000, 2))
    on_line = np.repeat([[True, False], [False, True], [True, True]], 1000, axis=0)
    place = np.where(on_line, lines, lines + rng.uniform(0.1, 0.9, (3000, 2)))
    x, normal, distance = lifted(chart, rng, place)
    found = chart.locate(x, normal, reach=0.06)
    assert (found.status == Status.EDGE).all()
    cell = np.where(on_line, lines - 1, lines)
    np.testing.assert_array_equal(found.at.element, np.ravel_multi_index(cell.T, chart.shape))
    np.testing.assert_allclose(found.distance, distance, atol=1e-9)
    order = rng.permutation(3000)
    again = chart.locate(x[order], normal[order], reach=0.06)
    np.testing.assert_array_equal(again.at.element, found.at.element[order])


@pytest.mark.parametrize("height", [0.001, 0.02, -0.02, -0.03, -0.049, -0.06])
def test_the_nearer_of_two_floors_is_met(height):
    """Whether it lies close by, or as far as both are looked for."""
    x = np.full((500, 3), height)
    x[:, :2] = np.random.default_rng(3).uniform((-0.9, 0.6), (1.9, 2.4), (500, 2))
    found = Floors(*PLANE).locate(x, np.tile([0.0, 0.0, 1.0], (500, 1)), reach=0.2)
    assert not found.missed.any()
    nearest = min((-height, -Floors.depth - height), key=abs)
    np.testing.assert_allclose(found.distance, nearest, atol=1e-12)
