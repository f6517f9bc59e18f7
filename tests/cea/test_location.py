"""Point location on surfaces known in closed form."""

from dataclasses import dataclass

import numpy as np
import pytest

from cea.location import TOLERANCE, locate_along
from cea.surface_points import Status


@dataclass(frozen=True)
class Grid:
    """nx x ny elements over the parameters u, v of a surface in closed form.

    Candidates are the element that holds the parameters of the point's foot and its neighbours, so
    that the answer is among them and others compete.
    """

    low: tuple[float, float]
    high: tuple[float, float]
    shape: tuple[int, int]

    dim = 3

    @property
    def step(self):
        """Size of an element in parameters."""
        return (np.array(self.high) - self.low) / self.shape

    def parameters(self, element, xi):
        """Parameters of points in elements."""
        cell = np.stack(np.unravel_index(element, self.shape), axis=1)
        return self.low + (cell + xi) * self.step

    def candidates(self, x, direction, reach):
        """The element of the foot and its neighbours."""
        cell = np.floor((self.foot(x) - self.low) / self.step).astype(int)
        points, elements = [], []
        for shift in np.ndindex(3, 3):
            near = cell + np.array(shift) - 1
            inside = ((near >= 0) & (near < self.shape)).all(axis=1)
            points.append(np.flatnonzero(inside))
            elements.append(np.ravel_multi_index(near[inside].T, self.shape))
        point, element = np.concatenate(points), np.concatenate(elements)
        return point, element, np.full((len(point), 2), 0.5)

    def tangents(self, element, xi):
        """Positions and derivatives along xi."""
        x, derivatives = self.surface(*self.parameters(element, xi).T)
        return x, derivatives * self.step

    def clamp(self, element, xi):
        """Nearest point of the unit square."""
        return np.clip(xi, 0.0, 1.0)

    def on_edge(self, element, xi, tolerance):
        """On the boundary of the element."""
        return np.minimum(xi, 1 - xi).min(axis=1) <= tolerance

    def size(self, element):
        """Largest side of an element."""
        return np.full(len(element), self.step.max() * self.radius)


class Plane(Grid):
    """z = 0."""

    radius = 1.0

    def surface(self, u, v):
        """Positions and derivatives along the parameters."""
        zero, one = np.zeros_like(u), np.ones_like(u)
        x = np.stack([u, v, zero], axis=1)
        return x, np.stack([np.stack([one, zero, zero], 1), np.stack([zero, one, zero], 1)], axis=2)

    def foot(self, x):
        """Parameters of the nearest point."""
        return x[:, :2]


class Cylinder(Grid):
    """Angle u and height v on a cylinder of radius 2 about the z axis."""

    radius = 2.0

    def surface(self, u, v):
        """Positions and derivatives along the parameters."""
        zero, one = np.zeros_like(u), np.ones_like(u)
        radial = np.stack([np.cos(u), np.sin(u), zero], axis=1)
        around = np.stack([-np.sin(u), np.cos(u), zero], axis=1)
        up = np.stack([zero, zero, one], axis=1)
        return self.radius * radial + v[:, None] * up, np.stack([self.radius * around, up], axis=2)

    def foot(self, x):
        """Parameters of the nearest point."""
        return np.stack([np.arctan2(x[:, 1], x[:, 0]), x[:, 2]], axis=1)


CHARTS = [
    Plane((-1.0, 0.5), (2.0, 2.5), (9, 7)),
    Cylinder((-1.2, -0.4), (1.3, 0.9), (8, 5)),
]


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def cloud(chart, n, *, margin, seed=4):
    """Parameters in and around the chart, positions and unit normals there, signed distances."""
    rng = np.random.default_rng(seed)
    low, high = (
        np.array(chart.low) - margin * chart.step,
        np.array(chart.high) + margin * chart.step,
    )
    parameters = rng.uniform(low, high, (n, 2))
    x, tangents = chart.surface(*parameters.T)
    normal = unit(np.cross(tangents[:, :, 0], tangents[:, :, 1]))
    return parameters, x, normal, rng.uniform(-0.05, 0.05, n)


@pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: type(chart).__name__)
def test_points_along_normals(chart):
    parameters, x, normal, distance = cloud(chart, 10_000, margin=0.8)
    found = locate_along(chart, x - distance[:, None] * normal, normal, reach=0.06)
    outside = ((parameters < chart.low) | (parameters > chart.high)).any(axis=1)
    assert 0.1 < outside.mean() < 0.6
    np.testing.assert_array_equal(found.status == Status.MISSED, outside)
    assert (found.status[~outside] == Status.INSIDE).all()
    hit = ~outside
    cell = np.floor((parameters[hit] - chart.low) / chart.step).astype(int)
    np.testing.assert_array_equal(found.at.element[hit], np.ravel_multi_index(cell.T, chart.shape))
    np.testing.assert_allclose(
        chart.parameters(found.at.element[hit], found.at.xi[hit]), parameters[hit], atol=1e-9
    )
    np.testing.assert_allclose(found.distance[hit], distance[hit], atol=1e-9)
    assert (found.miss[hit] <= TOLERANCE * chart.size(found.at.element[hit])).all()
    assert (found.miss[outside] > TOLERANCE * chart.step.max() * chart.radius).all()


@pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: type(chart).__name__)
def test_shared_edges_and_corners_go_to_the_lowest_element(chart):
    """Whatever the order of points, and with rounding either way."""
    rng = np.random.default_rng(6)
    lines = rng.integers(1, np.array(chart.shape), (3000, 2))
    along = rng.uniform(0.1, 0.9, (3000, 2))
    on_line = np.zeros((3000, 2), dtype=bool)
    on_line[:1000, 0] = on_line[1000:2000, 1] = True
    on_line[2000:] = True
    place = np.where(on_line, lines, lines + along)
    x, tangents = chart.surface(*(chart.low + place * chart.step).T)
    normal = unit(np.cross(tangents[:, :, 0], tangents[:, :, 1]))
    distance = rng.uniform(-0.05, 0.05, 3000)
    points = x - distance[:, None] * normal
    found = locate_along(chart, points, normal, reach=0.06)
    assert (found.status == Status.EDGE).all()
    cell = np.where(on_line, lines - 1, lines)
    np.testing.assert_array_equal(found.at.element, np.ravel_multi_index(cell.T, chart.shape))
    np.testing.assert_allclose(found.distance, distance, atol=1e-9)

    order = rng.permutation(3000)
    again = locate_along(chart, points[order], normal[order], reach=0.06)
    np.testing.assert_array_equal(again.at.element, found.at.element[order])


class Floors(Plane):
    """Two planes: the upper half of the elements lies below the other, one above the other."""

    depth = 0.05

    def candidates(self, x, direction, reach):
        """Elements of both floors within reach."""
        point, element, start = super().candidates(x, direction, reach)
        count = self.shape[0] * self.shape[1]
        point, start = np.tile(point, 2), np.tile(start, (2, 1))
        element = np.concatenate([element, element + count])
        height = np.where(element < count, 0.0, -self.depth)
        near = np.abs(x[point, 2] - height) <= reach
        return point[near], element[near], start[near]

    def tangents(self, element, xi):
        """Positions and derivatives, those of the lower floor farther down."""
        count = self.shape[0] * self.shape[1]
        x, derivatives = super().tangents(element % count, xi)
        x[:, 2] -= np.where(element < count, 0.0, self.depth)
        return x, derivatives


@pytest.mark.parametrize("height", [0.001, 0.02, -0.02, -0.03, -0.049, -0.06])
def test_the_nearer_of_two_floors_is_met(height):
    """Whether it lies close by, or as far as both are looked for."""
    floors = Floors((-1.0, 0.5), (2.0, 2.5), (9, 7))
    x = np.column_stack([*np.random.default_rng(3).uniform((-0.9, 0.6), (1.9, 2.4), (500, 2)).T,
                         np.full(500, height)])  # fmt: skip
    up = np.tile([0.0, 0.0, 1.0], (500, 1))
    found = locate_along(floors, x, up, reach=0.2)
    nearest = min((-height, -floors.depth - height), key=abs)
    assert not found.missed.any()
    np.testing.assert_allclose(found.distance, nearest, atol=1e-12)
