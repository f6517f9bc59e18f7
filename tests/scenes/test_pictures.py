"""Pictures and files of shapes: what is drawn, outsides of bodies, VTK cells of both backends."""

from dataclasses import replace
from itertools import product
from xml.etree import ElementTree

import numpy as np
import pytest
import pyvista
from blocks import GPTS, coarse, two_blocks
from matplotlib.image import imread
from motions import mode_displacement

from cea.timing import StageTimer
from scenes import load_scene, read_scene, run_scene
from scenes.building.build import build_bodies
from scenes.export.paraview import write_paraview
from scenes.results.pictures import outside, sharp_edges


@pytest.fixture(scope="module", params=["fe", "iga"])
def result(request):
    return run_scene(read_scene(coarse(two_blocks(request.param, GPTS, held=True), degree=2)))


def with_growth(result, growth):
    """The result with given growth rates of its first modes."""
    eigenvalues = result.modes.eigenvalues.imag * 1j
    eigenvalues[: len(growth)] += growth
    conditions = np.ones_like(result.modes.conditions)
    modes = replace(result.modes, eigenvalues=eigenvalues, conditions=conditions)
    analysis = replace(result.scene.analysis, growth_threshold=0.01)
    return replace(result, spectrum=modes, scene=replace(result.scene, analysis=analysis))


@pytest.mark.grid(quick=1)
def test_most_unstable_modes_are_drawn_first(result, tmp_path):
    for growth, count, chosen in (([0.5, -0.5, 0.9], 5, [2, 0]), ([0.5, -0.5, 0.9], 1, [2]),
                                  ([0.0], 2, [0, 1])):  # fmt: skip
        assert with_growth(result, growth).most_unstable(count) == chosen
    (file,) = with_growth(result, [0.0, 0.7]).draw(1, tmp_path)
    assert file.name == f"mode_{result.scene.backends}_2.png"
    drawn = np.ptp(imread(file)[..., :3], axis=2) > 0.05
    assert drawn.mean() > 0.1


INNER, OUTER, HEIGHT = 0.06, 0.15, 0.012
VOLUME = np.pi * (OUTER**2 - INNER**2) * HEIGHT
AREA = 2 * np.pi * (OUTER**2 - INNER**2) + 2 * np.pi * (OUTER + INNER) * HEIGHT
MESHES = {
    "fe": {"cell": "tetrahedron", "degree": 2, "elements": [3, 24, 2]},
    "iga": {"degree": [3, 3, 3], "elements": [3, 8, 1]},
}


def test_an_outside_is_closed_has_the_volume_of_the_body_its_fields_and_its_rims(backend):
    """Finely divided it is that of curved elements: an error of triangles remains."""
    scene = load_scene("disc").on(backend).change(f"bodies.disc.mesh.{backend}", MESHES[backend])
    cells = build_bodies(scene, StageTimer())["disc"].space.volume_cells()
    coarse, middle, fine = (outside(cells, {"x": cells.points}, n) for n in (0, 2, 3))
    for surface in (coarse, fine):
        assert surface.is_manifold
        assert surface.n_open_edges == 0
    assert abs(fine.volume / VOLUME - 1) < 1e-3
    assert abs(fine.area / AREA - 1) < 1e-3
    assert abs(fine.volume / VOLUME - 1) < abs(coarse.volume / VOLUME - 1) / 20
    # A linear field is exact where curved cells are divided.
    assert middle.n_points > len(cells.points) / 2
    np.testing.assert_allclose(middle.point_data["x"], middle.points, atol=1e-7)
    edges = sharp_edges(middle)
    lengths = edges.compute_cell_sizes(area=False, volume=False)["Length"]
    assert lengths.sum() == pytest.approx(4 * np.pi * (INNER + OUTER), rel=5e-3)


def listed(file):
    """Time, part and grid of each file of a collection."""
    datasets = ElementTree.parse(file).getroot().iter("DataSet")
    return [
        (float(d.get("timestep")), int(d.get("part")), pyvista.read(file.parent / d.get("file")))
        for d in datasets
    ]


def test_collections_list_every_mode_of_every_body(result, tmp_path):
    modes, contacts = write_paraview(result, 3, tmp_path)
    bodies = list(result.system.bodies.items())
    kind = {"iga": "BEZIER_HEXAHEDRON", "fe": "LAGRANGE_HEXAHEDRON"}[result.scene.backends]
    grids = listed(modes)
    assert [entry[:2] for entry in grids] == list(product((1, 2, 3), (0, 1)))
    for time, part, grid in grids:
        name, body = bodies[part]
        number = int(time) - 1
        assert grid.field_data["frequency"][0] == result.modes.frequencies[number]
        u = mode_displacement(result, name, number)
        found = grid.point_data["displacement_real"] + 1j * grid.point_data["displacement_imag"]
        np.testing.assert_allclose(found, body.space.volume_cells().values @ u, atol=1e-14)
        assert set(grid.celltypes) == {pyvista.CellType[kind]}
    points = result.interfaces["interface"].points
    entries = listed(contacts)
    assert [entry[:2] for entry in entries] == [(1, 0), (2, 0), (3, 0)]
    for _, _, grid in entries:
        np.testing.assert_array_equal(grid.points, points.x)
        assert grid.point_data["weight"].sum() == pytest.approx(0.5 * 0.6)
        assert np.abs(grid.point_data["gap_real"]).max() > 1e-3


def test_static_displacement_balances_the_load(backend, tmp_path):
    data = two_blocks(backend, GPTS, held=True, mu=0.0)
    data["bodies"]["upper"]["supports"] = [{"surface": "x_min"}]
    data["analysis"] = {"kind": "static", "samples": 3}
    data["loads"] = [{"surface": "upper.z_max", "pressure": 0.1}]
    displacement, contacts = write_paraview(run_scene(read_scene(data)), 1, tmp_path)
    assert displacement.name == "displacement.pvd"
    (upper, lower), ((_, _, points),) = [g for _, _, g in listed(displacement)], listed(contacts)
    assert upper.point_data["displacement"][:, 2].min() < -1e-3
    assert np.abs(lower.point_data["displacement"]).max() > 1e-4
    force = points.point_data["weight"] @ points.point_data["pressure"]
    assert 0 < force < 0.1 * 0.5 * 0.6
