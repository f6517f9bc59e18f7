"""Bodies of both backends as VTK cells: the same volumes, the same displacements."""

from functools import reduce
from itertools import product
from xml.etree import ElementTree

import numpy as np
import pytest
import pyvista
from blocks import two_blocks
from covering import covering
from iga_data import body as nurbs_body
from motions import mode_displacement
from scipy.interpolate import BSpline
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from meshes.shapes import Annulus, Disc, Ring
from scenes import run_scene
from scenes.export.paraview import write_paraview
from scenes.pictures.grids import cell_grid, in_space
from scenes.spec.reading import read_scene

RNG = np.random.default_rng(11)
ANNULUS, RING, DISC = Annulus(0.5, 1.0, 0.0, 0.3), Ring(0.5, 1.0), Disc(1.0, 0.0, 0.3)
GPTS = {"method": "gpts", "points": 3}
"""Cells and degrees of slow tests."""


def reread(grid, tmp_path):
    """What VTK's own reader finds in the file of a grid."""
    grid.save(tmp_path / "grid.vtu")
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "grid.vtu"))
    reader.Update()
    return reader.GetOutput()


def measure(grid, subdivisions):
    """Volume inside the skin of a grid, area of a plane one, its cells divided into flat ones."""
    skin = vtkGeometryFilter()
    skin.SetInputData(grid)
    skin.SetNonlinearSubdivisionLevel(subdivisions)
    skin.Update()
    flat = pyvista.wrap(skin.GetOutput()).triangulate()
    return flat.volume if np.ptp(flat.points[:, 2]) > 0 else flat.area


def converged_measure(grid):
    """Measures on three levels: extrapolated, as flat facets err by the square of their size."""
    levels = [measure(grid, n) for n in (2, 3, 4)]
    if abs(levels[2] - levels[1]) > 1e-6 * levels[2]:
        assert (levels[1] - levels[0]) / (levels[2] - levels[1]) == pytest.approx(4, rel=0.1)
    return levels[2] + (levels[2] - levels[1]) / 3


def evaluated(grid, cell, at):
    """Position and displacement that VTK finds at coordinates of a cell."""
    vtk_cell = grid.GetCell(cell)
    x, weights = np.zeros(3), np.zeros(vtk_cell.GetNumberOfPoints())
    vtk_cell.EvaluateLocation(reference(0), [*at, *[0.0] * (3 - len(at))], x, weights)
    ids = [vtk_cell.GetPointId(i) for i in range(len(weights))]
    return x, weights @ pyvista.wrap(grid).point_data["u"][ids]


def inside(dim, simplex, n=6):
    """Random coordinates inside a reference cell."""
    x = RNG.dirichlet(np.ones(dim + 1), n)[:, :dim] if simplex else RNG.uniform(size=(n, dim))
    return 0.02 + 0.95 * x


def nurbs(patch, coefficients, at):
    """Rational spline with coefficients (n1, ..., m) at one parameter, by scipy."""
    factors = [
        BSpline(knots, np.eye(n), p)(t)
        for knots, n, p, t in zip(patch.knots, patch.shape, patch.degrees, at, strict=True)
    ]
    top = reduce(np.multiply.outer, factors) * patch.weights
    return np.tensordot(top, coefficients, axes=len(factors)) / top.sum()


def check_bezier_cells(part, volume, tmp_path):
    """Volume, and geometry and displacement in cells chosen at random, against the splines."""
    cells = part.volume_cells()
    u = RNG.normal(size=(part.num_scalar_dofs, part.dim))
    grid = cell_grid(cells)
    grid.point_data["u"] = in_space(cells.values @ u)
    grid = reread(grid, tmp_path)
    spans = [
        (patch, dofs, corner)
        for patch, dofs in zip(
            part.space.multipatch.patches, part.space.multipatch.dofs, strict=True
        )
        for corner in product(*(range(n) for n in patch.spans))
    ]
    assert len(spans) == grid.GetNumberOfCells()
    degrees = pyvista.wrap(grid).cell_data["HigherOrderDegrees"]
    np.testing.assert_array_equal(degrees, max(part.space.degree))
    for number in RNG.choice(len(spans), 6, replace=False):
        patch, dofs, corner = spans[number]
        low, high = (
            np.array([b[i + k] for b, i in zip(patch.breaks, corner, strict=True)]) for k in (0, 1)
        )
        for at in inside(part.dim, False, 3):
            x, value = evaluated(grid, int(number), at)
            # Of left-handed patches the first parameter is reversed.
            both = [low + (high - low) * t for t in (at, [1 - at[0], *at[1:]])]
            found = [nurbs(patch, patch.control_points, t) for t in both]
            near = int(np.argmin([np.linalg.norm(f - x[: part.dim]) for f in found]))
            np.testing.assert_allclose(x[: part.dim], found[near], atol=1e-12)
            np.testing.assert_allclose(
                value[: part.dim], nurbs(patch, u[dofs], both[near]), atol=1e-12
            )
    assert converged_measure(grid) == pytest.approx(volume, rel=1e-5)
    assert handedness(grid) > 0


def handedness(grid):
    """Smallest Jacobian, up to a positive factor, in the middle of the cells of a grid."""
    dim, step = grid.GetCell(0).GetCellDimension(), 1e-4
    middle = np.full(dim, 0.3)
    grid = pyvista.wrap(grid)
    grid.point_data["u"] = grid.points
    jacobians = []
    for number in range(grid.n_cells):
        x = [evaluated(grid, number, middle + step * e)[0] for e in (np.zeros(dim), *np.eye(dim))]
        jacobians.append(np.linalg.det((np.array(x[1:]) - x[0])[:, :dim]))
    return min(jacobians)


@pytest.mark.parametrize(
    ("shape", "degree"),
    covering((ANNULUS, DISC), ((2, 2, 1), (2, 3, 2), (3, 4, 1)), strength=1),
)
def test_bezier_cells_are_rational_and_of_mixed_degrees(shape, degree, tmp_path):
    part = nurbs_body(shape, (2, 8, 1), degree)
    area = np.pi * (1.0 - (0.25 if shape is ANNULUS else 0.0))
    check_bezier_cells(part, 0.3 * area, tmp_path)


# Files of runs.


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
        cells = body.volume_cells()
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
