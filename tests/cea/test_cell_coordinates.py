"""Segments of coarse curved meshes, whose cells continued far beyond their edges turn back."""

from pathlib import Path

import numpy as np
import pytest
from covering import covering
from reference_data import plane_meshes

from cea.contact.cell_coordinates import continued_coordinates
from cea.contact.segments import segment_points
from cea.errors import ConvergenceError
from cea.timing import StageTimer
from scenes.building.build import build_bodies
from scenes.spec.reading import load_scene


def sides(scene, overrides, backend):
    loaded = load_scene(Path(scene), overrides, backend)
    bodies = build_bodies(loaded, StageTimer())
    contact = loaded.contacts["interface"]
    return [bodies[b].surfaces[s] for b, s in (contact.a.split("."), contact.b.split("."))]


# Splines of degree 1 hold no circle; quarters of low degree leave gaps beyond any reach.
DEGREES = {"fe": {8: (1, 2, 3, 4), 4: (3, 4)}, "iga": {8: (2, 3, 4), 4: (2, 3, 4)}}


@pytest.mark.parametrize(
    ("backend", "around"),
    covering(["fe", "iga"], [(12, 8), (8, 12), (4, 4), (4, 40), (40, 4)], strength=1),
)
def test_segments_of_coarse_rings_cover_side_a_once(backend, around):
    around_a, around_b = around
    for degree in DEGREES[backend][min(around_a, around_b)]:
        covered_once(backend, degree, around_a, around_b)


def covered_once(backend, degree, around_a, around_b):
    elements = {"outer": [1, around_a], "inner": [1, around_b]}
    a, b = sides("drum", plane_meshes(backend, degree, elements), backend)
    points = segment_points(a, b, 6, 0.5)
    assert points.weight.sum() == pytest.approx(a.area, rel=2e-3)
    # Each break of either side appears once: segments follow each other around the circle.
    angle = np.sort(np.arctan2(points.x[:, 1], points.x[:, 0]))
    assert np.diff(angle).min() > 1e-6


@pytest.mark.parametrize("angle", [pytest.param(40, marks=pytest.mark.slow), 80, -80])
def test_parameter_lines_go_on_straight_to_a_right_angle(angle):
    surface, _ = sides("ring", ["bodies.pad.mesh.iga={degree=[2,2,2],elements=[9,40,1]}"], "iga")
    cells = surface.cells()
    xi = cells.corners.mean(axis=1)
    xi[:, 0] += 0.3 * np.ptp(cells.corners[:, :, 0])
    here, _ = surface.tangents(cells.element, xi)
    turn = np.radians(angle)
    rotation = [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    found = continued_coordinates(
        surface, cells.element, cells.corners, (here @ np.transpose(rotation))[:, None]
    )
    assert np.abs(found[:, 0, 0] - xi[:, 0]).max() < 1e-11
    assert (np.sign(found[:, 0, 1] - xi[:, 1]) == np.sign(found[0, 0, 1] - xi[0, 1])).all()


class Arc:
    """Part of the unit circle as a single cell."""

    name, dim = "arc", 2

    def __init__(self, half):
        self.half = half

    def tangents(self, element, xi):
        """Positions and tangents."""
        turn = self.half * (2 * xi[:, 0] - 1)
        x = np.column_stack([np.sin(turn), np.cos(turn)])
        return x, 2 * self.half * np.column_stack([x[:, 1], -x[:, 0]])[:, :, None]

    def normal(self, at):
        """Unit normals."""
        return self.tangents(at.element, at.xi)[0]

    def coordinates(self, turn, radius=1.0):
        """Coordinates of points at angles from the middle."""
        x = radius * np.column_stack([np.sin(turn), np.cos(turn)])
        return continued_coordinates(self, np.array([0]), np.array([[[0.0], [1.0]]]), x[None])


def test_cells_bent_by_more_than_a_right_angle_are_refused():
    turn = np.radians([-84.0, 30.0, 84.0])
    xi = Arc(np.radians(85)).coordinates(turn)[0, :, 0]
    assert xi == pytest.approx(0.5 + turn / np.radians(170), abs=1e-12)
    with pytest.raises(ConvergenceError, match=r"1 of 3 points .* cells of arc.*refine"):
        Arc(np.radians(100)).coordinates(np.radians([-30.0, 30.0, 90.0]), 1.01)
