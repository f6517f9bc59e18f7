"""Outsides of bodies: closed, of the body's area and volume, with its displacements."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from cea.timing import StageTimer
from scenes import load_scene
from scenes.building.build import build_bodies
from scenes.pictures.decimation import reduced
from scenes.pictures.skin import skins

INNER, OUTER, HEIGHT = 0.06, 0.15, 0.012
VOLUME = np.pi * (OUTER**2 - INNER**2) * HEIGHT
AREA = 2 * np.pi * (OUTER**2 - INNER**2) + 2 * np.pi * (OUTER + INNER) * HEIGHT


def corners(skin):
    points = np.pad(skin.points, ((0, 0), (0, 3 - skin.points.shape[1])))
    return points[skin.triangles].transpose(1, 0, 2)


def area_and_volume(skin):
    a, b, c = corners(skin)
    doubled = np.cross(b - a, c - a)
    volume = np.einsum("ij,ij->", a, doubled) / 6
    return np.linalg.norm(doubled, axis=1).sum() / 2, volume, doubled.sum(axis=0)


HEXAHEDRA = {"cell": "hexahedron", "degree": 2, "elements": [3, 24, 2]}
CASES = [
    pytest.param("fe", HEXAHEDRA, marks=pytest.mark.slow),
    ("fe", {"cell": "tetrahedron", "degree": 2, "elements": [3, 24, 2]}),
    ("fe", {"cell": "hexahedron", "degree": 3, "elements": [2, 16, 1]}),
    pytest.param("iga", {"degree": [2, 2, 2], "elements": [3, 16, 2]}, marks=pytest.mark.slow),
    ("iga", {"degree": [3, 3, 3], "elements": [3, 8, 1]}),
]


@pytest.mark.parametrize(("backend", "mesh"), CASES)
def test_outside_is_closed_and_has_the_volume_of_the_body(backend, mesh):
    """Finely divided it is that of curved elements: an error of triangles remains."""
    scene = load_scene("disc").on(backend).change({f"bodies.disc.mesh.{backend}": mesh})
    bodies = build_bodies(scene, StageTimer(lambda stage: None))
    coarse, fine = (skins(bodies, points)["disc"] for points in (1, 10**5))
    errors = []
    for skin in (coarse, fine):
        area, volume, total = area_and_volume(skin)
        np.testing.assert_allclose(total, 0.0, atol=1e-12)
        pairs = np.sort(skin.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        assert set(np.unique(pairs, axis=0, return_counts=True)[1]) == {2}
        errors.append((abs(area / AREA - 1), abs(volume / VOLUME - 1)))
    assert len(fine.points) > 4 * len(coarse.points)
    assert max(errors[1]) < 0.004
    assert errors[1][1] < errors[0][1] / 20


@pytest.mark.parametrize(("backend", "mesh"), CASES)
def test_values_reproduce_linear_displacements(backend, mesh):
    """The functions add up to 1, and take positions to positions."""
    scene = load_scene("disc").on(backend).change({f"bodies.disc.mesh.{backend}": mesh})
    bodies = build_bodies(scene, StageTimer(lambda stage: None))
    skin = skins(bodies, 2000)["disc"]
    np.testing.assert_allclose(skin.values.sum(axis=1), 1.0, atol=1e-12)
    cells = bodies["disc"].volume_cells()
    # Positions as coefficients of the scalar dofs: least squares over the lattice is exact.
    transposed = cells.values.T
    dofs = spsolve((transposed @ cells.values).tocsc(), transposed @ cells.points)
    np.testing.assert_allclose(skin.values @ dofs, skin.points, atol=1e-10)


def test_flat_bodies_are_seen_whole(backend):
    scene = load_scene("drum").on(backend)
    bodies = build_bodies(scene, StageTimer(lambda stage: None))
    for name, skin in skins(bodies, 8000).items():
        geometry = scene.bodies[name].geometry
        area, _, total = area_and_volume(skin)
        exact = np.pi * (geometry.outer_radius**2 - geometry.inner_radius**2)
        assert area == pytest.approx(exact, rel=2e-3)
        assert total[2] / 2 == pytest.approx(area)


def test_sharp_edges_are_the_four_rims(backend):
    """Rims of the disc lie at both radii and both ends; between them nothing is sharp."""
    bodies = build_bodies(load_scene("disc").on(backend), StageTimer(lambda stage: None))
    skin = skins(bodies, 1)["disc"]
    ends = skin.points[skin.sharp]
    radii = np.linalg.norm(ends[..., :2], axis=-1)
    assert np.all(np.isclose(radii, INNER, rtol=1e-6) | np.isclose(radii, OUTER, rtol=1e-6))
    assert np.all(np.isclose(ends[..., 2], 0.0) | np.isclose(ends[..., 2], HEIGHT))
    np.testing.assert_allclose(ends[:, 0, 2], ends[:, 1, 2], atol=1e-12)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(4 * np.pi * (INNER + OUTER), rel=5e-3)


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_fewer_points_are_some_of_those_there_were(backend):
    bodies = build_bodies(load_scene("disc_pad").on(backend), StageTimer(lambda stage: None))
    whole = skins(bodies, 20_000)
    total = sum(len(skin.points) for skin in whole.values())
    fewer = reduced(whole, total // 4)
    assert sum(len(skin.points) for skin in fewer.values()) == pytest.approx(total / 4, rel=0.05)
    for name, skin in fewer.items():
        before, after = (area_and_volume(each) for each in (whole[name], skin))
        assert after[1] == pytest.approx(before[1], rel=0.01)
        np.testing.assert_allclose(after[2], 0.0, atol=1e-12)
        kept = {tuple(point) for point in skin.points.tolist()}
        assert kept <= {tuple(point) for point in whole[name].points.tolist()}
        np.testing.assert_allclose(skin.values.sum(axis=1), 1.0, atol=1e-12)
        assert skin.triangles.max() == len(skin.points) - 1
        assert len(skin.edges) == 0
    same = reduced(whole, total)
    assert all(same[name] is whole[name] for name in whole)
