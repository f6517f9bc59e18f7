"""Segments of coarse curved meshes, whose cells continued far beyond their edges turn back."""

from pathlib import Path

import numpy as np
import pytest
from reference_data import plane_meshes

from cea.segments import segment_points
from cea.timing import StageTimer
from comparisons.build import build_bodies
from comparisons.scene import load_scene


def sides(scene, overrides, backend):
    loaded = load_scene(Path(scene), overrides, backend)
    bodies = build_bodies(loaded, StageTimer())
    contact = loaded.contacts["interface"]
    return [bodies[b].surfaces[s] for b, s in (contact.a.split("."), contact.b.split("."))]


# Splines of degree 1 hold no circle; quarters of low degree leave gaps beyond any reach.
DEGREES = {"fe": {8: (1, 2, 3, 4), 4: (3, 4)}, "iga": {8: (2, 3, 4), 4: (2, 3, 4)}}


@pytest.mark.parametrize(("around_a", "around_b"), [(12, 8), (8, 12), (4, 4), (4, 40), (40, 4)])
def test_segments_of_coarse_rings_cover_side_a_once(backend, around_a, around_b):
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


@pytest.mark.parametrize("elements", [{"pad": [2, 16, 1], "disc": [3, 12, 1]},
                                      {"pad": [2, 4, 1], "disc": [1, 20, 1]}])  # fmt: skip
@pytest.mark.parametrize("degree", [2, 3])
def test_segments_of_coarse_annuli_cover_side_a_once(degree, elements):
    overrides = [
        f"bodies.{body}.mesh.iga={{degree=[2, {degree}, 2], elements={numbers}}}"
        for body, numbers in elements.items()
    ]
    a, b = sides("ring", overrides, "iga")
    points = segment_points(a, b, None, 0.01)
    assert points.weight.sum() == pytest.approx(a.area, rel=1e-4)
