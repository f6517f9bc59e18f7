"""Inverted elements of a mesh file, told by their numbers."""

from itertools import product

import numpy as np

from cea.errors import InputError
from cea.mesh import DIMENSION, SIMPLICES, Cell, reference_nodes
from meshes.files.content import Floats, Ints

_INWARD = 0.775
"""Where Jacobians are looked at: so far from the middle towards each node, as Gauss points lie."""
_FLAT = 1e-10
"""Smallest Jacobian of an element, relative to its largest, that is not called flat."""
_AT_ONCE = 20_000
"""Elements whose Jacobians are in memory together."""


def check_elements(cell: Cell, order: int, points: Floats, cells: Ints, numbers: Ints) -> None:
    """Refuse elements whose Jacobian is not positive; in the plane, does not keep its sign.

    Parameters
    ----------
    cell, order
        Their kind.
    points
        Positions of the nodes, (n, dim).
    cells
        Their nodes in the order of :class:`cea.mesh.Mesh`, (n_cells, n_nodes).
    numbers
        Their numbers in the file.

    Raises
    ------
    InputError
        Telling the first of them by its number.
    """
    dim, slopes = DIMENSION[cell], _slopes(cell, order)
    least, most = np.empty(len(cells)), np.empty(len(cells))
    for start in range(0, len(cells), _AT_ONCE):
        rows = slice(start, start + _AT_ONCE)
        x = points[cells[rows]]
        jacobians = np.linalg.det(np.einsum("qnj,cni->cqij", slopes, x, optimize=True))
        least[rows], most[rows] = jacobians.min(axis=1), jacobians.max(axis=1)
    if dim == 2 and (most < 0).sum() > len(cells) / 2:  # seen from behind
        least, most = -most, -least
    inverted = ~(least > _FLAT * most)
    if inverted.any():
        first = int(numbers[np.argmax(inverted)])
        allowed = "elements whose Jacobian is positive: these are inverted, flat, or list their "
        value = f"{inverted.sum()} of {len(cells)} elements, the first {first}"
        raise InputError("file", value, f"{allowed}nodes in another order than the format has")


def _slopes(cell: Cell, order: int) -> Floats:
    """Slopes of the shape functions at points inside the reference cell, (points, nodes, dim)."""
    nodes = reference_nodes(cell, order)
    middle = nodes.mean(axis=0)
    inside = np.vstack([middle, middle + _INWARD * (nodes - middle)])
    degree, dim = range(order + 1), nodes.shape[1]
    powers = np.array(
        [p for p in product(degree, repeat=dim) if cell not in SIMPLICES or sum(p) <= order]
    )
    values = np.prod(nodes[:, None] ** powers, axis=2)
    slopes = np.empty((len(inside), len(powers), dim))
    for axis in range(dim):
        lowered = powers.copy()
        lowered[:, axis] = np.maximum(powers[:, axis] - 1, 0)
        slopes[:, :, axis] = powers[:, axis] * np.prod(inside[:, None] ** lowered, axis=2)
    return np.einsum("qpd,pn->qnd", slopes, np.linalg.inv(values))
