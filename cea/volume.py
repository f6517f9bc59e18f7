"""The volume of a body: its cells as they are, or straight ones through their corners."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints
from cea.mesh import lattice


@dataclass(frozen=True)
class VolumeCells:
    """Cells of a body with geometry and displacement as they are, for programs that draw such.

    Lagrange elements on equally spaced nodes, or the rational Bezier elements of knot spans. Both
    have one point for each (i, j, k) of a lattice: 0 <= i, j, k <= degree in boxes,
    i + j + k <= degree in simplices.

    Parameters
    ----------
    kind
        ``lagrange``: fields pass through the values at the points; ``bezier``: points and values
        are rational Bezier coefficients.
    simplex
        Whether cells are triangles or tetrahedra, rather than quadrilaterals or hexahedra.
    degree
        Degree along every direction, to which lower ones are raised: programs are surest there.
    points
        Positions (m), shape (n, dim).
    weights
        Rational weights of the points, shape (n,); 1 for Lagrange elements.
    cells
        Point numbers of each right-handed cell, lattice points in C order, shape
        (n_cells, points of a cell).
    values
        Coefficients at the points of the scalar basis functions, shape (n, num_scalar_dofs).
    """

    kind: Literal["lagrange", "bezier"]
    simplex: bool
    degree: int
    points: Floats
    weights: Floats
    cells: Ints
    values: csr_array

    def straight(self) -> "StraightCells":
        """Straight cells through the corners of these, on which fields are what they are."""
        dim = self.points.shape[1]
        places = lattice(dim, self.degree, self.simplex).tolist()
        corners = np.vstack([np.zeros((1, dim), dtype=int), np.eye(dim, dtype=int)])
        if not self.simplex:
            corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
            if dim == 3:
                corners = np.vstack([np.insert(corners, 2, z, axis=1) for z in (0, 1)])
        at = [places.index(corner) for corner in (self.degree * corners).tolist()]
        used, cells = np.unique(self.cells[:, at], return_inverse=True)
        cells = cells.reshape(-1, len(at))
        return StraightCells(self.points[used], cells, csr_array(self.values[used]))


@dataclass(frozen=True)
class StraightCells:
    """Points of a body joined to straight cells.

    Positions (m), (n, dim); points of each cell in VTK order, (n_cells, dim + 1) simplices or
    (n_cells, 2^dim) boxes; values of the scalar basis functions at the points,
    (n, num_scalar_dofs).
    """

    points: Floats
    cells: Ints
    values: csr_array
