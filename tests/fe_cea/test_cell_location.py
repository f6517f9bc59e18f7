"""Points located in the cells of a Lagrange mesh, beside trying every cell of it."""

import numpy as np
import pytest

from cea.timing import StageTimer
from fe_cea.cell_location import Cells
from scenes.building.build import build_bodies
from scenes.refinement.meshes import Resolution, refined
from scenes.spec.reading import load_scene


@pytest.fixture(scope="module")
def layered():
    """Curved cells of a disc with three layers towards its edges, of very different sizes."""
    scene = load_scene("disc_pad", backend="fe")
    disc = build_bodies(refined(scene, "fe", Resolution(2, 0.3, 3)), StageTimer())["disc"]
    cells = Cells.of(disc.space.scalar)
    assert cells.sizes.max() > 5 * cells.sizes.min()
    return cells


def in_every_cell(cells, x):
    """The same by trying all cells for every point."""
    count = len(cells.nodes)
    cell, point = np.tile(np.arange(count), len(x)), np.repeat(np.arange(len(x)), count)
    apart = cells._pulled_back(cell, x[point], np.arange(len(cell)))[1].reshape(len(x), count)
    return np.round(apart, 9).argmin(axis=1), apart.min(axis=1)


def test_points_inside_and_on_common_facets_are_found(layered):
    rng = np.random.default_rng(5)
    own = rng.integers(0, len(layered.nodes), 300)
    xi = rng.uniform(0.02, 0.98, (300, 3))
    xi[150:, 0] = rng.integers(0, 2, 150)  # on a facet
    x = layered.positions(own, xi)
    cell, found, miss = layered.locate(x)
    expected, apart = in_every_cell(layered, x)
    assert (cell == expected).all()
    assert (cell[:150] == own[:150]).all()
    assert (miss <= 1e-12).all()
    assert (apart <= 1e-12).all()
    assert layered.positions(cell, found) == pytest.approx(x, abs=1e-13)
    assert found[:150] == pytest.approx(xi[:150], abs=1e-9)


def test_points_beside_the_body_come_to_its_nearest_cells(layered):
    rng = np.random.default_rng(6)
    own = rng.integers(0, len(layered.nodes), 100)
    above = layered.positions(own, np.column_stack([rng.uniform(0, 1, (100, 2)), np.ones(100)]))
    x = above + rng.uniform(-1, 1, above.shape) * 1e-3
    _, apart = in_every_cell(layered, x)
    cell, found, miss = layered.locate(x)
    left = np.linalg.norm(layered.positions(cell, found) - x, axis=1)
    assert miss == pytest.approx(left / layered.sizes[cell], abs=1e-12)
    inside = apart <= 1e-10
    assert 0 < inside.sum() < 100
    assert (miss[inside] <= 1e-10).all()
    assert (miss[~inside] > 1e-10).all()
    assert (left <= 2e-3).all()
