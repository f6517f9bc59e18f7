"""Views of the volume of a body for pictures and for comparing modes: points, cells, values."""

from dataclasses import dataclass
from typing import Literal

from scipy.sparse import csr_array

from cea.arrays import Floats, Ints


@dataclass(frozen=True)
class VolumeSample:
    """Points through a body joined to straight cells, for pictures and for comparing modes."""

    points: Floats  # positions (m), shape (n, dim)
    # points of each cell in VTK order: (n_cells, 4) tetrahedra or (n_cells, 8) hexahedra; in the
    # plane 3 or 4
    cells: Ints
    values: csr_array  # of the scalar basis functions at the points, shape (n, num_scalar_dofs)


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
