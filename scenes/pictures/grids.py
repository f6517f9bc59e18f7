"""Bodies on their true cells as VTK has them, and their outsides in triangles.

Lagrange elements become VTK Lagrange cells, knot spans VTK rational Bezier cells: nothing is
resampled.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
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
from cea.body.space import VolumeCells

_CELL_TYPES = {
    ("lagrange", True, 2): pyvista.CellType.LAGRANGE_TRIANGLE,
    ("lagrange", True, 3): pyvista.CellType.LAGRANGE_TETRAHEDRON,
    ("lagrange", False, 2): pyvista.CellType.LAGRANGE_QUADRILATERAL,
    ("lagrange", False, 3): pyvista.CellType.LAGRANGE_HEXAHEDRON,
    ("bezier", False, 2): pyvista.CellType.BEZIER_QUADRILATERAL,
    ("bezier", False, 3): pyvista.CellType.BEZIER_HEXAHEDRON,
}

_MERGED, _OFF_GRID = 1e-6, 0.2113
"""Points nearer than this, relative to the diagonal of a body, are one point; and the shift of the
lattice on which they are merged, which round numbers fall on no border of."""
FEATURE_ANGLE = 30.0
"""Angle between triangles (degrees) from which on their edge is sharp."""
_SIMPLICES: dict[int, Any] = {2: vtkHigherOrderTriangle, 3: vtkHigherOrderTetra}
_BOXES: dict[int, Any] = {2: vtkHigherOrderQuadrilateral, 3: vtkHigherOrderHexahedron}


def cell_grid(cells: VolumeCells) -> Any:
    """Cells of a body as VTK cells of the same geometry (pyvista ``UnstructuredGrid``).

    Values at its points are ``cells.values`` times those of the scalar dofs.
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
        # As pyvista adds them they would be scalars too, and VTK's filters then lose the weights.
        grid.GetPointData().SetRationalWeights(
            pyvista.convert_array(cells.weights, name="RationalWeights")
        )
        grid.GetCellData().SetHigherOrderDegrees(
            pyvista.convert_array(degrees, name="HigherOrderDegrees")
        )
    return grid


def merged(cells: VolumeCells) -> VolumeCells:
    """Cells that share their points, those of joined patches too: what is inside is then known."""
    x = cells.points
    size = float(np.linalg.norm(np.ptp(x, axis=0)))
    grid = np.round(x / (_MERGED * size) + _OFF_GRID)
    _, first, number = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    return replace(
        cells,
        points=x[first],
        weights=cells.weights[first],
        cells=number.reshape(-1)[cells.cells],
        values=cells.values[first],
    )


def outside(cells: VolumeCells, fields: Mapping[str, Floats], subdivisions: int) -> Any:
    """Outside of a body in triangles with vectors at its points by name (pyvista ``PolyData``).

    Its cells share their points (:func:`merged`); edges of curved ones are halved some times.
    """
    grid = cell_grid(cells)
    for name, values in fields.items():
        grid.point_data[name] = in_space(values)
    surface = grid.extract_surface(
        nonlinear_subdivision=subdivisions, pass_cellid=True, algorithm="dataset_surface"
    )
    return surface.triangulate()


def straight_outside(points: Floats, cells: Ints, displacement: Floats) -> Any:
    """Outside of straight cells in space with real displacements of their points."""
    kind = {4: pyvista.CellType.TETRA, 8: pyvista.CellType.HEXAHEDRON}[cells.shape[1]]
    grid = pyvista.UnstructuredGrid({kind: cells}, points)
    grid.point_data["real"], grid.point_data["imaginary"] = displacement, 0 * displacement
    return grid.extract_surface(algorithm="dataset_surface").triangulate()


def sharp_edges(surface: Any) -> Any:
    """Edges between triangles whose normals differ, and those of one alone (pyvista)."""
    return surface.extract_feature_edges(FEATURE_ANGLE, manifold_edges=False)


def in_space[T: np.generic](vectors: NDArray[T]) -> NDArray[T]:
    """Vectors with z = 0 added in 2D, shape (n, 3)."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def _vtk_positions(cells: VolumeCells) -> Ints:
    """Place of each lattice point of a cell, in C order, among the points of a VTK cell."""
    p, dim = cells.degree, cells.points.shape[1]
    lattice: Iterable[tuple[int, ...]] = product(range(p + 1), repeat=dim)
    if cells.simplex:
        inside = (point for point in lattice if sum(point) <= p)
        return np.array([_SIMPLICES[dim].Index((*point, p - sum(point)), p) for point in inside])
    return np.array([_BOXES[dim].PointIndexFromIJK(*point, (p,) * dim) for point in lattice])
