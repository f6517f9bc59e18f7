"""Bodies of both backends as VTK cells: the same volumes, the same displacements."""

from itertools import product
from xml.etree import ElementTree

import numpy as np
import pytest
import pyvista
from blocks import two_blocks
from motions import mode_displacement

from scenes import run_scene
from scenes.export.paraview import write_paraview
from scenes.spec.reading import read_scene

GPTS = {"method": "gpts", "points": 3}


@pytest.fixture
def result(backend):
    scene = two_blocks(backend, GPTS, held=True)
    return run_scene(read_scene(scene))


def listed(file):
    """Time, part and grid of each file of a collection."""
    datasets = ElementTree.parse(file).getroot().iter("DataSet")
    return [
        (float(d.get("timestep")), int(d.get("part")), pyvista.read(file.parent / d.get("file")))
        for d in datasets
    ]


def test_collections_list_every_mode_of_every_body(result, backend, tmp_path):
    assert len(result.modes.eigenvalues) >= 3
    modes, contacts = write_paraview(result, 3, tmp_path)
    bodies = list(result.system.bodies.items())
    grids = listed(modes)
    assert [entry[:2] for entry in grids] == list(product((1, 2, 3), (0, 1)))
    for time, part, grid in grids:
        name, body = bodies[part]
        number = int(time) - 1
        assert grid.field_data["frequency"][0] == result.modes.frequencies[number]
        u = mode_displacement(result, name, number)
        cells = body.space.volume_cells()
        found = grid.point_data["displacement_real"] + 1j * grid.point_data["displacement_imag"]
        np.testing.assert_allclose(found, cells.values @ u, atol=1e-14)
        if backend == "iga":
            assert set(grid.celltypes) == {pyvista.CellType.BEZIER_HEXAHEDRON}
        else:
            assert set(grid.celltypes) == {pyvista.CellType.LAGRANGE_HEXAHEDRON}
    points = result.interfaces["interface"].points
    entries = listed(contacts)
    assert [entry[:2] for entry in entries] == [(1, 0), (2, 0), (3, 0)]
    for _, _, grid in entries:
        np.testing.assert_array_equal(grid.points, points.x)
        np.testing.assert_array_equal(grid.point_data["normal"], points.normal)
        assert grid.point_data["weight"].sum() == pytest.approx(0.5 * 0.6)
        p = 3.0 / (0.5 * 0.6)
        for end in ("_real", "_imag"):
            gap, pressure = (grid.point_data[name + end] for name in ("gap", "pressure"))
            np.testing.assert_allclose(pressure, p * gap, rtol=1e-9, atol=1e-13 * p)
        assert np.abs(grid.point_data["gap_real"]).max() > 1e-3


@pytest.mark.parametrize(
    ("contact", "has_pressure"),
    [({}, True), ({"form": "saddle", "P": float("inf")}, False)],
)
def test_static_displacement_balances_the_load(backend, contact, has_pressure, tmp_path):
    data = two_blocks(backend, GPTS, held=True, mu=0.0)
    del data["bodies"]["upper"]["supports"]
    data["bodies"]["upper"]["supports"] = [{"surface": "x_min"}]
    data["analysis"] = {"kind": "static", "samples": 3}
    data["loads"] = [{"surface": "upper.z_max", "pressure": 0.1}]
    data["contacts"]["interface"] |= contact
    result = run_scene(read_scene(data))
    displacement, contacts = write_paraview(result, 1, tmp_path)
    assert displacement.name == "displacement.pvd"
    (upper, lower), ((_, _, points),) = [g for _, _, g in listed(displacement)], listed(contacts)
    assert upper.point_data["displacement"][:, 2].min() < -1e-3
    assert np.abs(lower.point_data["displacement"]).max() > 1e-4
    assert ("pressure" in points.point_data) == has_pressure
    if has_pressure:
        force = points.point_data["weight"] @ points.point_data["pressure"]
        assert 0 < force < 0.1 * 0.5 * 0.6
    else:
        assert np.abs(points.point_data["gap"]).max() < 1e-9
