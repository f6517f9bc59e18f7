"""Segments between flat rings: thin curved cells, unlike meshes, rims that miss each other.

Area and moments of the common surface are held against numbers that no segment went into.
"""

from pathlib import Path

import numpy as np
import pytest
from covering import covering

from cea.contact.segments import segment_points
from cea.surface_points import SurfaceCoordinates
from cea.timing import StageTimer
from scenes.building.build import build_bodies
from scenes.spec.reading import load_scene

INNER, OUTER = 0.08, 0.16
REACH = 0.02

# Rings of the pad and the disc, each elements along r and theta and coordinates to pass through.
GRADED = ((4, 8, "r=[0.081, 0.083], theta=[2.0]"), (2, 8, "theta=[2.0]"))
MATCHING_RIMS = [((9, 8), (2, 8)), ((2, 8), (9, 8)), GRADED]
RINGS = [
    *MATCHING_RIMS,
    ((13, 12), (5, 12)),
    ((9, 4), (2, 8)),
    ((2, 8), (9, 4)),
    ((9, 8), (3, 12)),
    ((2, 8, "r=[0.081], theta=[89.0]"), (5, 4)),
]


def sides(backend, degree, rings, geometry_degree=None):
    meshes = []
    for body, (radial, around, *through) in zip(("pad", "disc"), rings, strict=True):
        kind = (
            f"degree=[{degree}, {degree}, 1]"
            if backend == "iga"
            else f"cell='hexahedron', degree={degree}, geometry_degree={geometry_degree}"
        )
        numbers = f"elements=[{radial}, {around}, 1], through={{{''.join(through)}}}"
        meshes.append(f"bodies.{body}.mesh.{backend}={{{kind}, {numbers}}}")
    bodies = build_bodies(load_scene(Path("ring"), meshes, backend), StageTimer())
    return bodies["pad"].surfaces["bottom"], bodies["disc"].surfaces["top"]


def moments(points):
    """Moments 1, x, y, xx, xy, yy over powers of the outer radius."""
    x, y = points.x[:, :2].T / OUTER
    return np.array([np.ones(len(x)), x, y, x * x, x * y, y * y]) @ points.weight


def ring_moments():
    area = np.pi * (OUTER**2 - INNER**2)
    second = area * (1 + (INNER / OUTER) ** 2) / 4
    return np.array([area, 0, 0, second, 0, second])


@pytest.mark.parametrize(
    ("degree", "rings"),
    [
        pytest.param(k % 2 + 2, rings, marks=() if k in (1, 2, 6) else pytest.mark.slow)
        for k, rings in enumerate(RINGS)
    ],
    ids=str,
)
def test_boxes_of_splines_fill_the_ring(rings, degree):
    a, b = sides("iga", degree, rings)
    points = segment_points(a, b, 10, REACH)
    assert np.abs(moments(points) - ring_moments()).max() <= 1e-12 * a.area
    assert len(points) == 100 * common_boxes(a, b)
    assert not b.locate(points.x[::7], points.normal[::7], REACH).missed.any()


def common_boxes(a, b):
    """Boxes between the circles and spokes through knots of either side."""
    lines = []
    for surface in (a, b):
        cells = surface.cells()
        element = np.repeat(cells.element, 4)
        x, y = surface.position(SurfaceCoordinates(element, cells.corners.reshape(-1, 2)))[:, :2].T
        lines.append((np.hypot(x, y).round(9), np.degrees(np.arctan2(y, x)).round(6) % 360))
    circles, spokes = (np.unique(np.concatenate(c)) for c in zip(*lines, strict=True))
    return (len(circles) - 1) * len(spokes)


@pytest.mark.parametrize(
    ("rings", "degree"), covering(MATCHING_RIMS, [4, 3, 2], strength=1), ids=str
)
def test_segments_of_elements_fill_rings_whose_rims_match(rings, degree):
    a, b = sides("fe", 1, rings, degree)
    points = segment_points(a, b, 8, REACH)
    assert np.abs(moments(points) - moments(a.gauss_points(8))).max() <= 1e-12 * a.area
    assert not b.locate(points.x[::7], points.normal[::7], REACH).missed.any()


@pytest.mark.parametrize("backend", ["fe", "iga"])
def test_a_pad_over_the_hole_touches_no_further_than_the_rim(backend):
    """The rim is hollow: polylines along it leave the disc."""
    pad = [
        "bodies.pad.geometry={shape='box', size=[0.03, 0.04, 0.01], origin=[0.06, -0.02, 0.0]}",
        "bodies.pad.supports=[{surface='z_max'}]",
        "bodies.pad.mesh.fe={cell='hexahedron', degree=1, geometry_degree=1, elements=[3, 2, 1]}",
        "bodies.pad.mesh.iga={degree=[2, 2, 1], elements=[3, 2, 1]}",
        "bodies.disc.mesh.fe={cell='hexahedron', degree=1, geometry_degree=4, elements=[2, 24, 1]}",
        "bodies.disc.mesh.iga={degree=[2, 2, 1], elements=[2, 24, 1]}",
        "contacts.interface.a='pad.z_min'",
    ]
    bodies = build_bodies(load_scene(Path("ring"), pad, backend), StageTimer())
    a, b = bodies["pad"].surfaces["z_min"], bodies["disc"].surfaces["top"]
    points = segment_points(a, b, 9, REACH)
    half = 0.02
    hole = half * np.sqrt(INNER**2 - half**2) + INNER**2 * np.arcsin(half / INNER)
    excess = points.weight.sum() - (2 * half * 0.09 - hole)
    piece = np.radians(360 / 24 / 16)
    between_chords_and_rim = INNER**2 * np.arcsin(half / INNER) * piece**2 / 6
    assert 0 < excess < between_chords_and_rim
    assert not b.locate(points.x, points.normal, REACH).missed.any()
