"""Geometric layers of cells around singular edges, and nowhere else.

Every cell at an edge is divided across it: into a smaller one at the edge, with sides of a part q,
and two that pass over from its inner sides to the outer sides of the cell. These stay whole, so
that no neighbour is divided, where breaks with layers would go through the whole shape. A further
layer divides the smaller cells again. A cell with two edges on one side, as the one across a thin
disc is, is divided into two smaller ones at both and five others.

Edges run along one direction of a lattice all the way; in the plane they are points.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cea.mesh import Floats, Ints, Mesh, facet_nodes
from meshes.edge_templates import quads_towards

_SAME = 1e-3
"""Distance of nodes, relative to the least of a cell, below which they are one."""

Bools = NDArray[np.bool_]


def with_layers(mesh: Mesh, singular: Bools, along: int | None, layers: int) -> Mesh:
    """Divide the cells around edges towards them.

    Parameters
    ----------
    mesh
        Quadrilaterals or hexahedra.
    singular
        Whether each point of the mesh lies on an edge, shape (n_points,).
    along
        Axis of the cells' lattices that edges run along; None in the plane.
    layers
        Times that cells are divided.

    Raises
    ------
    InputError
        When a cell has edges at opposite corners, or at more than two.
    """
    n, dim = mesh.order + 1, mesh.dim
    lattice = mesh.cells.reshape(-1, *(n,) * dim)
    lattice = lattice[..., None] if along is None else np.moveaxis(lattice, 1 + along, -1)
    marked = singular[lattice[:, :: n - 1, :: n - 1]].all(axis=-1)
    cells, points, facets = [mesh.cells], [mesh.points], _Facets(mesh)
    kept = np.ones(len(mesh.cells), dtype=bool)
    count, least = len(mesh.points), np.inf
    for pattern in np.unique(marked[marked.any(axis=(1, 2))], axis=0):
        some = np.flatnonzero((marked == pattern).all(axis=(1, 2)))
        kept[some] = False
        quads = quads_towards(pattern, layers)
        x = _placed(mesh.points[lattice[some]], quads, mesh.order)
        least = min(least, _least_distance(x))
        numbers = count + np.arange(x[..., 0].size).reshape(x.shape[:-1])
        count += x[..., 0].size
        points.append(x.reshape(-1, dim))
        made = numbers[..., 0] if along is None else np.moveaxis(numbers, -1, 2 + along)
        made = made.reshape(len(some), len(quads), -1)
        cells.append(made.reshape(-1, made.shape[-1]))
        facets.divide(some, made, quads, along)
    if len(points) == 1:
        return mesh
    every = np.concatenate(points)
    first = _first_of_same(every, _SAME * least)
    cells[0] = mesh.cells[kept]
    surfaces = {name: first[nodes] for name, nodes in facets.named().items()}
    parts = first[np.concatenate(cells)]
    return Mesh(mesh.cell, mesh.order, every, parts, surfaces).without_loose_points()


def _placed(nodes: Floats, quads: Floats, order: int) -> Floats:
    """Nodes of the parts of cells, on the maps of these.

    Parameters
    ----------
    nodes
        Nodes of the cells, (cells, n, n, along, dim).
    quads
        Parts of each, (parts, 2, 2, 2).
    order
        Order of the geometry, n - 1.

    Returns
    -------
    ndarray
        (cells, parts, n, n, along, dim).
    """
    t = np.arange(order + 1) / order
    ends = np.stack([1 - t, t])
    at = np.einsum("ai,bj,qabx->qijx", ends, ends, quads)
    others = ~np.eye(order + 1, dtype=bool)
    factors = np.where(others, at[..., None, None] - t, 1.0).prod(axis=-1)
    values = factors / np.where(others, t[:, None] - t, 1.0).prod(axis=-1)
    u, v = values[..., 0, :], values[..., 1, :]
    placed: Floats = np.einsum("qija,qijb,cabkx->cqijkx", u, v, nodes, optimize=True)
    return placed


def _least_distance(x: Floats) -> float:
    """Least distance of neighbours on the lattices of cells, (cells, parts, n, n, along, dim)."""
    steps = [np.diff(x, axis=axis) for axis in (2, 3, 4) if x.shape[axis] > 1]
    return float(min(np.linalg.norm(step, axis=-1).min() for step in steps))


def _first_of_same(points: Floats, distance: float) -> Ints:
    """Number of the first point of those that lie together with each."""
    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    size = len(points)
    links = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=(size, size))
    _, group = connected_components(links, directed=False)
    _, first = np.unique(group, return_index=True)
    return first[group]


@dataclass
class _Facets:
    """Named facets of a mesh while its cells are divided.

    Parameters
    ----------
    mesh
        The mesh.
    """

    mesh: Mesh

    def __post_init__(self) -> None:
        self._left = dict(self.mesh.surfaces)
        self._new: dict[str, list[Ints]] = {name: [] for name in self._left}
        self._of_cell = facet_nodes(self.mesh.cell, self.mesh.order)

    def divide(self, some: Ints, made: Ints, quads: Floats, along: int | None) -> None:
        """Give the names of facets to those of the parts of their cells.

        Parameters
        ----------
        some
            Numbers of the cells.
        made
            Nodes of their parts, (cells, parts, n_nodes).
        quads
            What each is divided into.
        along
            Axis that all parts run along.
        """
        axes = [axis for axis in range(self.mesh.dim) if axis != along]
        for side, local in enumerate(self._of_cell):
            axis, end = divmod(side, 2)
            nodes = np.sort(self.mesh.cells[some][:, local], axis=1)
            for name, left in self._left.items():
                at, of = _matched(nodes, np.sort(left, axis=1))
                if not len(at):
                    continue
                self._left[name] = np.delete(left, of, axis=0)
                for part, facet in self._parts(quads, axes, axis, end, local):
                    self._new[name].append(made[at, part][:, facet])

    def _parts(
        self, quads: Floats, axes: list[int], axis: int, end: int, local: Ints
    ) -> list[tuple[int, Ints]]:
        """Parts that have a part of a facet of the cell, and which of their facets that is."""
        if axis not in axes:
            return [(part, local) for part in range(len(quads))]
        found = []
        for part, corners in enumerate(quads):
            for own in range(2):
                for of_own in range(2):
                    line = np.take(corners, of_own, axis=own)[:, axes.index(axis)]
                    if (line == end).all():
                        found.append((part, self._of_cell[2 * axes[own] + of_own]))
        return found

    def named(self) -> dict[str, Ints]:
        """Facets by name, of cells that were divided and of those that were not."""
        return {name: np.concatenate([left, *self._new[name]]) for name, left in self._left.items()}


def _matched(rows: Ints, others: Ints) -> tuple[Ints, Ints]:
    """Which rows are among others, all different, and which of those each is."""
    both = np.concatenate([rows, others])
    _, group = np.unique(both, axis=0, return_inverse=True)
    place = np.full(group.max(initial=-1) + 1, -1)
    place[group[len(rows) :]] = np.arange(len(others))
    of = place[group[: len(rows)]]
    at = np.flatnonzero(of >= 0)
    return at, of[at]
