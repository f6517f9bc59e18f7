"""VTK grids of bodies, and triangulations of their outer surfaces.

Lagrange elements become VTK Lagrange cells and knot spans VTK rational Bezier cells, without
resampling.
"""

from collections.abc import Iterable, Mapping
from itertools import product
from typing import Any

import numpy as np
import pyvista
from numpy.typing import NDArray
from vtkmodules.vtkCommonDataModel import (
    vtkHigherOrderHexahedron,
    vtkHigherOrderQuadrilateral,
    vtkHigherOrderTetra,
    vtkHigherOrderTriangle,
)

from cea.arrays import Floats, Ints
from cea.body import VolumeCells

_CELL_TYPES = {
    ("lagrange", True, 2): pyvista.CellType.LAGRANGE_TRIANGLE,
    ("lagrange", True, 3): pyvista.CellType.LAGRANGE_TETRAHEDRON,
    ("lagrange", False, 2): pyvista.CellType.LAGRANGE_QUADRILATERAL,
    ("lagrange", False, 3): pyvista.CellType.LAGRANGE_HEXAHEDRON,
    ("bezier", False, 2): pyvista.CellType.BEZIER_QUADRILATERAL,
    ("bezier", False, 3): pyvista.CellType.BEZIER_HEXAHEDRON,
}

_MERGED = 1e-6
"""Distance of points that are merged, relative to the diagonal of a body."""
FEATURE_ANGLE = 30.0
"""Angle between triangles (degrees) above which their common edge is drawn as sharp."""
_SIMPLICES: dict[int, Any] = {2: vtkHigherOrderTriangle, 3: vtkHigherOrderTetra}
_BOXES: dict[int, Any] = {2: vtkHigherOrderQuadrilateral, 3: vtkHigherOrderHexahedron}


def cell_grid(cells: VolumeCells) -> Any:
    """Return the cells of a body as VTK cells of the same geometry (pyvista ``UnstructuredGrid``).

    Values at the points of the grid are ``cells.values`` times the scalar dofs.
    """
    dim = cells.points.shape[1]
    count, size = cells.cells.shape
    connectivity = np.empty((count, size + 1), dtype=np.int64)
    connectivity[:, 0] = size
    connectivity[:, 1 + _vtk_positions(cells)] = cells.cells
    kinds = np.full(count, _CELL_TYPES[cells.kind, cells.simplex, dim], dtype=np.uint8)
    grid = pyvista.UnstructuredGrid(connectivity.ravel(), kinds, in_space(cells.points))
    if cells.kind == "bezier":
        degrees = np.full((count, 3), float(cells.degree))
        # pyvista would also make them the active scalars, and VTK filters then lose the weights.
        grid.GetPointData().SetRationalWeights(
            pyvista.convert_array(cells.weights, name="RationalWeights")
        )
        grid.GetCellData().SetHigherOrderDegrees(
            pyvista.convert_array(degrees, name="HigherOrderDegrees")
        )
    return grid


def outside(cells: VolumeCells, fields: Mapping[str, Floats], subdivisions: int) -> Any:
    """Return the triangulated outer surface of a body with vectors at points (``PolyData``).

    Coincident points are merged, so that interior faces are found; curved cells are subdivided.
    """
    grid = cell_grid(cells)
    for name, values in fields.items():
        grid.point_data[name] = in_space(values)
    size = float(np.linalg.norm(np.ptp(cells.points, axis=0)))
    surface = grid.clean(tolerance=_MERGED * size).extract_surface(
        nonlinear_subdivision=subdivisions, pass_cellid=True, algorithm="dataset_surface"
    )
    return surface.triangulate()


def sharp_edges(surface: Any) -> Any:
    """Return sharp edges and boundary edges of a triangulated surface (pyvista)."""
    return surface.extract_feature_edges(FEATURE_ANGLE, manifold_edges=False)


def in_space[T: np.generic](vectors: NDArray[T]) -> NDArray[T]:
    """Return vectors of shape (n, 3), with z = 0 added in 2D."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def _vtk_positions(cells: VolumeCells) -> Ints:
    """Return the index in the VTK cell of each lattice point of a cell (C order)."""
    p, dim = cells.degree, cells.points.shape[1]
    lattice: Iterable[tuple[int, ...]] = product(range(p + 1), repeat=dim)
    if cells.simplex:
        inside = (point for point in lattice if sum(point) <= p)
        return np.array([_SIMPLICES[dim].Index((*point, p - sum(point)), p) for point in inside])
    return np.array([_BOXES[dim].PointIndexFromIJK(*point, (p,) * dim) for point in lattice])
