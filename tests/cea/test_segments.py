"""The common refinement of two surfaces: areas, exact integrals, curved and hollow outlines."""

from pathlib import Path

import numpy as np
import pytest
from blocks import ROTATED, two_blocks
from covering import covering
from reference_data import plane_meshes

from cea.contact.interface import pair
from cea.contact.segments import segment_points
from cea.timing import StageTimer
from scenes.building.build import build_bodies
from scenes.spec.reading import load_scene, read_scene

PAIRINGS = [("fe", "fe"), ("fe", "iga"), ("iga", "fe"), ("iga", "iga")]
TETRAHEDRA = {"cell": "tetrahedron", "degree": 2, "size": 0.25}


def surfaces(pairing, placement=None, meshes=None):
    data = two_blocks("iga", {"method": "grid", "points": 2}, placement)
    for name, backend in zip(("upper", "lower"), pairing, strict=True):
        data["bodies"][name]["backend"] = backend
        data["bodies"][name]["mesh"] |= meshes or {}
    bodies = build_bodies(read_scene(data), StageTimer())
    return bodies["upper"].surfaces["z_min"], bodies["lower"].surfaces["z_max"]


@pytest.mark.parametrize(
    ("pairing", "meshes", "placement"),
    covering(PAIRINGS, [{}, {"fe": TETRAHEDRA}], [{}, ROTATED], strength=1),
)
def test_products_of_both_traces_are_integrated_exactly(pairing, meshes, placement):
    """More points change nothing; points that ignore the cells of b do."""
    a, b = surfaces(pairing, placement, meshes)
    points = segment_points(a, b, None, 0.1)
    assert points.weight.sum() == pytest.approx(0.3, rel=1e-13)
    assert points.weight.min() > 0
    assert not b.locate(points.x, points.normal, 0.1).missed.any()

    def product(points):
        interface = pair(a, b, points)
        weighted = interface.trace_b.multiply(points.weight[:, None]).tocsr()
        return (interface.trace_a.T @ weighted).toarray()

    exact = product(segment_points(a, b, 9, 0.1))
    scale = np.abs(exact).max()
    assert np.abs(product(points) - exact).max() <= 1e-14 + 1e-12 * scale
    assert np.abs(product(a.gauss_points(5)) - exact).max() > 1e-5 * scale


INNER, OUTER, REACH = 0.08, 0.16, 0.02
# Rings of the pad and the disc: elements along r and theta, coordinates to pass through.
UNLIKE = [("[2, 8, 1]", "[9, 8, 1]"), ("[4, 4, 1]", "[1, 16, 1]")]
UNLIKE.append(("[2, 16, 1], through={r=[0.081], theta=[89.0]}", "[2, 12, 1]"))


def ring_sides(backend, overrides, of_pad="bottom"):
    bodies = build_bodies(load_scene(Path("ring"), overrides, backend), StageTimer())
    return bodies["pad"].surfaces[of_pad], bodies["disc"].surfaces["top"]


@pytest.mark.parametrize(
    ("backend", "rings"),
    [
        ("fe", UNLIKE[0]),
        *(pytest.param("iga", rings, marks=pytest.mark.slow) for rings in UNLIKE[:2]),
        ("iga", UNLIKE[2]),
    ],
)
def test_segments_of_unlike_rings_fill_the_ring(backend, rings):
    """Moments 1, x, y, xx, xy, yy; thin curved cells, facets whose rims match."""
    kind = {"fe": "cell='hexahedron', degree=2, geometry_degree=4", "iga": "degree=[2, 2, 1]"}
    a, b = ring_sides(
        backend,
        [
            f"bodies.{body}.mesh.{backend}={{{kind[backend]}, elements={elements}}}"
            for body, elements in zip(("pad", "disc"), rings, strict=True)
        ],
    )

    def moments(points):
        x, y = points.x[:, :2].T / OUTER
        return np.array([np.ones(len(x)), x, y, x * x, x * y, y * y]) @ points.weight

    points = segment_points(a, b, 10, REACH)
    expected = moments(a.gauss_points(8))
    if backend == "iga":
        area = np.pi * (OUTER**2 - INNER**2)
        second = area * (1 + (INNER / OUTER) ** 2) / 4
        expected = np.array([area, 0, 0, second, 0, second])
    assert np.abs(moments(points) - expected).max() <= 1e-12 * a.area
    assert not b.locate(points.x[::7], points.normal[::7], REACH).missed.any()


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
    a, b = ring_sides(backend, pad, "z_min")
    points = segment_points(a, b, 9, REACH)
    half = 0.02
    hole = half * np.sqrt(INNER**2 - half**2) + INNER**2 * np.arcsin(half / INNER)
    excess = points.weight.sum() - (2 * half * 0.09 - hole)
    piece = np.radians(360 / 24 / 16)
    between_chords_and_rim = INNER**2 * np.arcsin(half / INNER) * piece**2 / 6
    assert 0 < excess < between_chords_and_rim
    assert not b.locate(points.x, points.normal, REACH).missed.any()


# Splines of degree 1 hold no circle; quarters of low degree leave gaps beyond any reach.
DEGREES = {"fe": {8: (1, 2, 3, 4), 4: (3, 4)}, "iga": {8: (2, 3, 4), 4: (2, 3, 4)}}


@pytest.mark.grid
@pytest.mark.parametrize("around", [(12, 8), (8, 12), (4, 4), (4, 40), (40, 4)])
def test_segments_of_coarse_rings_cover_side_a_once(backend, around):
    elements = {"outer": [1, around[0]], "inner": [1, around[1]]}
    for degree in DEGREES[backend][min(around)]:
        scene = load_scene(Path("drum"), plane_meshes(backend, degree, elements), backend)
        bodies, contact = build_bodies(scene, StageTimer()), scene.contacts["interface"]
        a, b = (bodies[k].surfaces[s] for k, s in (contact.a.split("."), contact.b.split(".")))
        points = segment_points(a, b, 6, 0.5)
        assert points.weight.sum() == pytest.approx(a.area, rel=2e-3)
        # Each break of either side appears once: segments follow each other around the circle.
        angle = np.sort(np.arctan2(points.x[:, 1], points.x[:, 0]))
        assert np.diff(angle).min() > 1e-6
