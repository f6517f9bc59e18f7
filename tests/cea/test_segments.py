"""The common refinement of two surfaces: areas, exact integrals, curved outlines."""

import numpy as np
import pytest
from blocks import ROTATED, two_blocks

from cea.contact.interface import pair
from cea.contact.segments import segment_points
from cea.timing import StageTimer
from scenes.building.build import build_bodies
from scenes.spec.reading import read_scene

PAIRINGS = [("fe", "fe"), ("fe", "iga"), ("iga", "fe"), ("iga", "iga")]
TETRAHEDRA = {"cell": "tetrahedron", "degree": 2, "size": 0.25}


def surfaces(pairing, placement=None, meshes=None):
    data = two_blocks("iga", {"method": "grid", "points": 2}, placement)
    for name, backend in zip(("upper", "lower"), pairing, strict=True):
        data["bodies"][name]["backend"] = backend
        data["bodies"][name]["mesh"] |= (meshes or {}).get(name, {})
    bodies = build_bodies(read_scene(data), StageTimer())
    return bodies["upper"].surfaces["z_min"], bodies["lower"].surfaces["z_max"]


@pytest.mark.parametrize("pairing", PAIRINGS)
@pytest.mark.parametrize("placement", [{}, ROTATED], ids=["aligned", "rotated"])
def test_segments_cover_side_a(pairing, placement):
    a, b = surfaces(pairing, placement)
    points = segment_points(a, b, None, 0.1)
    assert points.weight.sum() == pytest.approx(0.3, rel=1e-13)
    assert points.weight.min() > 0
    assert not b.locate(points.x, points.normal, 0.1).missed.any()


@pytest.mark.parametrize("pairing", PAIRINGS)
@pytest.mark.parametrize("mesh", ["lattice", "unstructured"])
def test_products_of_both_traces_are_integrated_exactly(pairing, mesh):
    """More points change nothing; points that ignore the cells of b do."""
    meshes = {name: {"fe": TETRAHEDRA} for name in ("upper", "lower")}
    a, b = surfaces(pairing, meshes=meshes if mesh == "unstructured" else None)

    def product(points):
        interface = pair(a, b, points)
        weighted = interface.trace_b.multiply(points.weight[:, None]).tocsr()
        return (interface.trace_a.T @ weighted).toarray()

    exact = product(segment_points(a, b, 9, 0.1))
    scale = np.abs(exact).max()
    assert np.abs(product(segment_points(a, b, None, 0.1)) - exact).max() <= 1e-14 + 1e-12 * scale
    assert np.abs(product(a.gauss_points(5)) - exact).max() > 1e-5 * scale


def disc_and_pad(pairing):
    pad, disc = pairing
    data = {
        "name": "small disc and pad",
        "bodies": {
            "pad": {
                "backend": pad,
                "geometry": {
                    "shape": "sector", "inner_radius": 0.09, "outer_radius": 0.14,
                    "start": 25.0, "end": 65.0, "bottom": 0.012, "top": 0.027,
                },
                "material": {"E": 1.0, "nu": 0.3, "rho": 1.0},
                "mesh": {
                    "fe": {"degree": 2, "elements": [3, 4, 1]},
                    "iga": {"degree": [2, 2, 2], "elements": [3, 4, 1]},
                },
            },
            "disc": {
                "backend": disc,
                "geometry": {
                    "shape": "annulus", "inner_radius": 0.06, "outer_radius": 0.15,
                    "bottom": 0.0, "top": 0.012,
                },
                "material": {"E": 1.0, "nu": 0.3, "rho": 1.0},
                "mesh": {
                    "fe": {"degree": 2, "elements": [4, 36, 1]},
                    "iga": {"degree": [2, 2, 2], "elements": [4, 36, 1]},
                },
            },
        },
        "analysis": {"kind": "cea", "max_frequency": 1.0},
    }  # fmt: skip
    bodies = build_bodies(read_scene(data), StageTimer())
    return bodies["pad"].surfaces["bottom"], bodies["disc"].surfaces["top"]


@pytest.mark.parametrize("pairing", PAIRINGS)
def test_curved_outlines_leave_no_gap(pairing):
    a, b = disc_and_pad(pairing)
    points = segment_points(a, b, None, 0.003)
    assert points.weight.sum() == pytest.approx(a.area, rel=1e-12)
    if pairing == ("iga", "iga"):
        # Knot lines of both are parameter lines of each other: nothing but boxes is cut.
        fewer = segment_points(a, b, 1, 0.003)
        theta = np.degrees(np.arctan2(fewer.x[:, 1], fewer.x[:, 0]))
        lines = np.unique(np.concatenate([np.linspace(25, 65, 5), np.arange(30, 65, 10.0)]))
        rows = np.unique(np.round(theta, 6))
        assert len(rows) == len(lines) - 1
