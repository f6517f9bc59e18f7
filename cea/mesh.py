"""Mesh as plain arrays, the input of the finite element backend from any source of geometry."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from cea.arrays import Floats, Ints, finite_numbers, numbers
from cea.errors import InputError, require

Cell = Literal["triangle", "quadrilateral", "tetrahedron", "hexahedron"]

MAX_ORDER = 4
"""Highest polynomial order of the geometry."""

DIMENSION: dict[Cell, int] = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}
"""Dimension of each kind of cell."""

SIMPLICES: tuple[Cell, ...] = ("triangle", "tetrahedron")
"""Cells that are simplices; the others are boxes."""

_SAME = 1e-6  # distance of reference nodes below which they are treated as equal


@dataclass(frozen=True, eq=False)
class Mesh:
    """Lagrange mesh of one kind of cell, with named parts of its boundary.

    Nodes of a cell are the points of a lattice on the reference cell, (i, j, k)/order with
    0 <= i, j, k <= order in boxes (squares in 2D), and also i + j + k <= order in simplices,
    listed in C order: the last index runs fastest. So

    - linear triangles and tetrahedra list their corners in any order;
    - corners listed around a linear quadrilateral are reordered by ``cells[:, [0, 3, 1, 2]]``;
    - corners listed around the bottom, then the top of a linear hexahedron are reordered by
      ``cells[:, [0, 4, 3, 7, 1, 5, 2, 6]]``.

    :func:`node_order` finds this order for any cell and program. Cells may be left-handed.

    Parameters
    ----------
    cell
        Kind of every cell: triangle, quadrilateral (plane strain), tetrahedron, hexahedron.
    order
        Order of the geometry, 1 to 4: each edge has ``order + 1`` nodes.
    points
        Positions of the nodes (m), shape (n_points, 2) or (n_points, 3); some may be unused.
    cells
        Nodes of each cell, as row numbers of ``points`` from 0, shape (n_cells, n_nodes).
    surfaces
        Facets (edges in 2D) of each named surface, given by all their nodes in any order, shape
        (n_facets, n_facet_nodes). A facet lies on the boundary of the mesh and belongs to at most
        one surface; the rest of the boundary needs no name.

    Raises
    ------
    InputError
        If arrays have wrong shapes or values, or a named facet is not a facet of exactly one cell,
        or is named twice.
    """

    cell: Cell
    order: int
    points: Floats
    cells: Ints
    surfaces: Mapping[str, Ints]

    def __post_init__(self) -> None:
        known = isinstance(self.cell, str) and self.cell in DIMENSION
        require(known, "cell", self.cell, f"one of {', '.join(get_args(Cell))}")
        whole = type(self.order) is int and 1 <= self.order <= MAX_ORDER
        require(whole, "order", self.order, f"1 to {MAX_ORDER}")
        named = isinstance(self.surfaces, Mapping) and all(type(n) is str for n in self.surfaces)
        require(named, "surfaces", self.surfaces, "facets by name")
        points = finite_numbers(self.points, "points", "rows of finite numbers (m), equally long")
        fits = points.ndim == 2 and points.shape[1] == self.dim
        require(fits, "points", points.shape, f"shape (n_points, {self.dim})")
        object.__setattr__(self, "points", points)
        n = len(lattice(self.dim, self.order, self.is_simplex))
        object.__setattr__(self, "cells", self._numbers("cells", self.cells, n))
        self._check_cells()
        object.__setattr__(self, "surfaces", self._facets_of_cells())

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        return DIMENSION[self.cell]

    @property
    def is_simplex(self) -> bool:
        """Whether the cells are triangles or tetrahedra."""
        return self.cell in SIMPLICES

    def without_loose_points(self) -> "Mesh":
        """Return the mesh without points that belong to no cell; the others keep their order."""
        used = np.zeros(len(self.points), dtype=bool)
        used[self.cells] = True
        if used.all():
            return self
        number = np.cumsum(used) - 1
        surfaces = {name: number[facets] for name, facets in self.surfaces.items()}
        return Mesh(self.cell, self.order, self.points[used], number[self.cells], surfaces)

    def _check_cells(self) -> None:
        """Raise InputError if a cell contains a node twice or a cell is listed twice."""
        ordered = np.sort(self.cells, axis=1)
        twice = (np.diff(ordered, axis=1) == 0).any(axis=1)
        worst = self.cells[np.argmax(twice)].tolist()
        require(not twice.any(), "cells", worst, "different nodes in each cell")
        group = _same_rows(ordered)
        alike = np.bincount(group)[group] > 1
        worst = self.cells[np.argmax(alike)].tolist()
        require(not alike.any(), "cells", worst, "each cell once")

    def _numbers(self, field: str, nodes: ArrayLike, per_row: int) -> Ints:
        """Return checked node numbers as an array."""
        array = numbers(nodes, field, "rows of whole numbers, equally long")
        fits = array.ndim == 2 and array.shape[1] == per_row and len(array) > 0
        allowed = f"shape (n, {per_row}), n > 0, for cell = {self.cell!r} of order {self.order}"
        require(fits, field, array.shape, allowed)
        require(array.dtype.kind in "iu", field, array.dtype.name, "whole numbers")
        ends, last = (int(array.min()), int(array.max())), len(self.points) - 1
        require(ends[0] >= 0 and ends[1] <= last, field, ends, f"numbers of points, 0 to {last}")
        return array.astype(np.int64, copy=False)

    def _facets_of_cells(self) -> dict[str, Ints]:
        """Return the checked named facets, their nodes in the order of the cells."""
        if not self.surfaces:
            return {}
        per_facet = len(lattice(self.dim - 1, self.order, self.is_simplex))
        given = {
            name: self._numbers(f"surfaces[{name!r}]", facets, per_facet)
            for name, facets in self.surfaces.items()
        }
        named, ends = np.concatenate(list(given.values())), np.cumsum([*map(len, given.values())])
        on = np.zeros(len(self.points), dtype=bool)
        on[named] = True
        facets = (self.cells[:, facet] for facet in facet_nodes(self.cell, self.order))
        # Facets of cells all of whose nodes belong to named facets.
        found = np.concatenate([nodes[on[nodes].all(axis=1)] for nodes in facets])
        group = _same_rows(np.sort(np.concatenate([named, found]), axis=1))
        own, others = group[: len(named)], group[len(named) :]
        of_cells, times = (np.bincount(g, minlength=group.max() + 1)[own] for g in (others, own))
        for wrong, allowed in (
            (of_cells == 0, "the nodes of a facet of a cell"),
            (of_cells > 1, "a facet on the boundary: this one lies between two cells"),
            (times > 1, "a facet of one surface, once: this one is named twice"),
        ):
            if wrong.any():
                first = int(np.argmax(wrong))
                name = list(given)[int(np.searchsorted(ends, first, side="right"))]
                raise InputError(f"surfaces[{name!r}]", named[first].tolist(), allowed)
        place = np.empty(group.max() + 1, dtype=np.int64)
        place[others] = np.arange(len(others))
        return dict(zip(given, np.split(found[place[own]], ends[:-1]), strict=True))


def lattice(dim: int, order: int, simplex: bool) -> Ints:
    """Return lattice points of a box or simplex in C order, from 0 to ``order``, (n_nodes, dim)."""
    points = np.indices((order + 1,) * dim).reshape(dim, -1).T
    return points[points.sum(axis=1) <= order] if simplex else points


def reference_nodes(cell: Cell, order: int) -> Floats:
    """Return reference nodes, from 0 to 1, in the order of :class:`Mesh`, (n_nodes, dim)."""
    return lattice(DIMENSION[cell], order, cell in SIMPLICES) / order


def facet_nodes(cell: Cell, order: int) -> list[Ints]:
    """Return the cell's node numbers on each facet, in C order of the facet's lattice."""
    places = lattice(DIMENSION[cell], order, cell in SIMPLICES)
    if cell in SIMPLICES:
        sides = [*(places.T == 0), places.sum(axis=1) == order]
    else:
        sides = [line == end for line in places.T for end in (0, order)]
    return [np.flatnonzero(side) for side in sides]


def node_order(cell: Cell, order: int, nodes: ArrayLike) -> Ints:
    """Return ``order`` such that ``cells[:, order]`` has the node order of :class:`Mesh`.

    ``nodes`` are the nodes of the reference cell, from 0 to 1, in the order of another program,
    shape (n_nodes, dim).
    """
    return matching_nodes(reference_nodes(cell, order), np.asarray(nodes, dtype=float))


def matching_nodes(wanted: Floats, nodes: Floats) -> Ints:
    """Return the index in ``nodes`` of each wanted node, (n_nodes,); both are (n_nodes, dim)."""
    require(nodes.shape == wanted.shape, "nodes", nodes.shape, f"shape {wanted.shape}")
    apart = np.linalg.norm(wanted[:, None] - nodes, axis=2)
    require(
        bool((apart.min(axis=1) < _SAME).all()),
        "nodes",
        nodes.tolist(),
        f"in some order {wanted.tolist()}",
    )
    return np.argmin(apart, axis=1).astype(np.int64)


def _same_rows(rows: Ints) -> Ints:
    """Return a number for each row, (n,), the same for equal rows."""
    return np.unique(rows, axis=0, return_inverse=True)[1].ravel()
