"""Outsides of bodies: closed, of the body's area and volume, with its displacements."""

import numpy as np
import pytest

from cea.timing import StageTimer
from scenes import load_scene
from scenes.building.build import build_bodies
from scenes.pictures.grids import merged, outside, sharp_edges

INNER, OUTER, HEIGHT = 0.06, 0.15, 0.012
VOLUME = np.pi * (OUTER**2 - INNER**2) * HEIGHT
AREA = 2 * np.pi * (OUTER**2 - INNER**2) + 2 * np.pi * (OUTER + INNER) * HEIGHT
MESHES = {
    "fe": {"cell": "tetrahedron", "degree": 2, "elements": [3, 24, 2]},
    "iga": {"degree": [3, 3, 3], "elements": [3, 8, 1]},
}


@pytest.fixture
def cells(backend):
    scene = load_scene("disc").on(backend).change(f"bodies.disc.mesh.{backend}", MESHES[backend])
    return merged(build_bodies(scene, StageTimer())["disc"].space.volume_cells())


def test_an_outside_is_closed_and_has_the_volume_of_the_body(cells):
    """Finely divided it is that of curved elements: an error of triangles remains."""
    coarse, fine = (outside(cells, {}, n) for n in (0, 3))
    for surface in (coarse, fine):
        assert surface.is_manifold
        assert surface.n_open_edges == 0
    assert abs(fine.volume / VOLUME - 1) < 1e-3
    assert abs(fine.area / AREA - 1) < 1e-3
    assert abs(fine.volume / VOLUME - 1) < abs(coarse.volume / VOLUME - 1) / 20


def test_fields_are_those_of_the_points_between_nodes(cells):
    """A linear field is exact where curved cells are divided."""
    surface = outside(cells, {"x": cells.points}, 2)
    assert surface.n_points > len(cells.points) / 2
    np.testing.assert_allclose(surface.point_data["x"], surface.points, atol=1e-7)


def test_sharp_edges_are_the_four_rims(cells):
    edges = sharp_edges(outside(cells, {}, 2))
    radii = np.hypot(edges.points[:, 0], edges.points[:, 1])
    assert np.all(np.isclose(radii, INNER, rtol=1e-5) | np.isclose(radii, OUTER, rtol=1e-5))
    assert edges.length > 0
    lengths = edges.compute_cell_sizes(area=False, volume=False)["Length"]
    assert lengths.sum() == pytest.approx(4 * np.pi * (INNER + OUTER), rel=5e-3)
