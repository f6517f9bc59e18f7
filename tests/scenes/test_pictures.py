"""Pictures of modes, and outsides of bodies: closed, of their area, with their displacements."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista
from blocks import two_blocks
from matplotlib.image import imread

from cea.timing import StageTimer
from scenes import load_scene, run_scene
from scenes.building.build import build_bodies
from scenes.pictures.drawing import draw_mode, largest_deflection
from scenes.pictures.grids import merged, outside, sharp_edges
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene


def test_largest_deflection_beats_every_phase():
    rng = np.random.default_rng(3)
    shape = rng.normal(size=(40, 3)) + 1j * rng.normal(size=(40, 3))
    complex_shape, largest = largest_deflection(shape)
    real = complex_shape.real
    np.testing.assert_allclose(np.abs(complex_shape), np.abs(shape), rtol=1e-12)
    phases = np.exp(1j * np.linspace(0, 2 * np.pi, 3601))
    swept = np.linalg.norm((shape[:, :, None] * phases).real, axis=1)
    assert np.linalg.norm(real, axis=1).max() == pytest.approx(largest, rel=1e-12)
    assert largest == pytest.approx(swept.max(), rel=1e-5)
    turned, _ = largest_deflection(shape * np.exp(2.1j))
    np.testing.assert_allclose(turned.real, real, atol=1e-12)


@pytest.fixture
def result(backend):
    scene = two_blocks(backend, {"method": "gpts", "points": 3}, held=True)
    return run_scene(read_scene(scene))


def with_growth(result, growth):
    """The result with given growth rates of its first modes."""
    eigenvalues = result.modes.eigenvalues.imag * 1j
    eigenvalues[: len(growth)] += growth
    conditions = np.ones_like(result.modes.conditions)
    modes = replace(result.modes, eigenvalues=eigenvalues, conditions=conditions)
    analysis = replace(result.scene.analysis, growth_threshold=0.01)
    return replace(result, spectrum=modes, scene=replace(result.scene, analysis=analysis))


def test_most_unstable_modes_are_drawn_first(result):
    assert len(result.modes.eigenvalues) >= 3
    assert with_growth(result, [0.5, -0.5, 0.9]).most_unstable(5) == [2, 0]
    assert with_growth(result, [0.5, -0.5, 0.9]).most_unstable(1) == [2]
    assert with_growth(result, [0.0]).most_unstable(2) == [0, 1]


@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_modes_are_drawn(result, backend, tmp_path):
    (file,) = with_growth(result, [0.0, 0.7]).draw(1, tmp_path)
    assert file.name == f"mode_{backend}_2.png"
    image = imread(file)[..., :3]
    drawn = np.ptp(image, axis=2) > 0.05
    rows, columns = (np.flatnonzero(drawn[:780].any(axis=axis)) for axis in (1, 0))
    assert np.ptp(rows) > 0.6 * len(image)
    assert drawn.mean() > 0.1
    assert rows.min() > 0
    assert columns.min() > 0
    assert columns.max() < image.shape[1] - 1


def test_what_is_drawn_is_displaced_and_has_the_colour_of_its_deflection():
    """A square between bars at rest, which keep the frame."""
    centres = []
    for u in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0j, 0.0]):
        bodies = [
            pyvista.Rectangle([[x, low, 0.0], [x + 1, low, 0.0], [x + 1, -low, 0.0]]).triangulate()
            for x, low in ((0.0, -0.5), (-3.0, -2.0), (3.0, -2.0))
        ]
        for body, part in zip(bodies, (u, [0.0] * 3, [0.0] * 3), strict=True):
            body.point_data["real"] = np.tile(np.real(part), (body.n_points, 1))
            body.point_data["imaginary"] = np.tile(np.imag(part), (body.n_points, 1))
        pixels = np.asarray(draw_mode(bodies, ""))[:780]
        rows, columns = np.nonzero((pixels[..., 2] > 60) & (pixels[..., 0] < 30))
        centres.append(complex(columns.mean(), -rows.mean()))
    right, up, delayed = centres
    assert (right - up).real > 10
    assert (up - right).imag == pytest.approx((right - up).real, rel=0.05)
    assert delayed == pytest.approx(up)  # at the phase of its largest deflection


def test_a_static_scene_has_no_modes_to_draw():
    data = two_blocks("iga", {"method": "mortar"}, held=True)
    data |= {"analysis": {"kind": "static"}, "output": {"pictures": 1}}
    with pytest.raises(SceneError, match=r"output\.pictures = 1: 0 in a static analysis"):
        read_scene(data)


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
