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
    i + j + k <= degree in simplices. Fields of Lagrange elements pass through the values at the
    points; of Bezier elements points and values are rational Bezier coefficients.
    """

    kind: Literal["lagrange", "bezier"]
    simplex: bool  # whether cells are triangles or tetrahedra
    degree: int  # along every direction, to which lower ones are raised: programs are surest there
    points: Floats  # positions (m), shape (n, dim)
    weights: Floats  # rational weights of the points, shape (n,); 1 for Lagrange elements
    # points of each right-handed cell in C order of the lattice, shape (n_cells, points of a cell)
    cells: Ints
    values: csr_array  # coefficients there of the scalar basis functions, (n, num_scalar_dofs)

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
    """Points of a body joined to straight cells."""

    points: Floats  # positions (m), (n, dim)
    cells: Ints  # points in VTK order, (n_cells, dim + 1) simplices or (n_cells, 2^dim) boxes
    values: csr_array  # values there of the scalar basis functions, (n, num_scalar_dofs)
