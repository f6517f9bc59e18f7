"""Location of points in the cells of a Lagrange mesh that is replicated on every rank."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import basix
import numpy as np

from cea.arrays import Floats, Ints, chunks
from cea.location import near_boxes
from fe_cea.facets import geometry_element, nodes_and_dofs

_MAX_ITERATIONS = 40
_STANDS = 1e-14
"""Step of reference coordinates below which the iteration ends."""
_SETTLED = 5
"""Iterations after which a point found in one cell is dropped from the others, where convergence
to the nearest point is slow."""
_INSIDE, _OUTSIDE = 1e-10, 1e-4
"""Distances, relative to the cell size, below which a point is inside, above which outside."""
_ALIKE = 9
"""Digits to which distances are compared: on a common facet the lower cell is chosen."""
_TOUCHES, _REACH = 1e-9, 0.05
"""Search distances around bounding boxes, relative to the largest: first for points in cells, then
for the others, multiplied by four until all are found."""
_SIMPLICES = (basix.CellType.triangle, basix.CellType.tetrahedron)


@dataclass(frozen=True)
class Cells:
    """All cells of a mesh with their dofs, replicated on every rank."""

    # elements (basix) of the geometry and of the scalar displacement
    geometry: Any
    trial: Any
    nodes: Floats  # geometry nodes (m) of each cell, (n, n_geometry, dim)
    dofs: Ints  # global scalar dofs of each cell, (n, n_dofs)

    @classmethod
    def of(cls, V: Any) -> "Cells":
        """Gather the cells of a space (dolfinx); collective."""
        mesh = V.mesh
        nodes, dofs = own_cells(V)
        nodes, dofs = (np.concatenate(mesh.comm.allgather(part)) for part in (nodes, dofs))
        return cls(geometry_element(mesh), V.ufl_element().basix_element, nodes, dofs)

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return self.nodes.shape[2]

    @cached_property
    def sizes(self) -> Floats:
        """Diagonals of the bounding boxes of the nodes of each cell (m), (n,)."""
        return np.linalg.norm(np.ptp(self.nodes, axis=1), axis=1)

    def locate(self, x: Floats) -> tuple[Ints, Floats, Floats]:
        """Return the nearest cell, the reference coordinates, and the distance of each point."""
        cell = np.full(len(x), -1, dtype=np.int64)
        xi, miss = np.zeros(x.shape), np.full(len(x), np.inf)
        low, high = self.nodes.min(axis=1), self.nodes.max(axis=1)
        left, largest = np.arange(len(x)), float(self.sizes.max())
        reach, most = _TOUCHES * largest, _INSIDE
        while len(left):
            point, candidates = near_boxes(low, high, x[left], reach)
            found, apart = self._pulled_back(candidates, x[left[point]], point)
            order = np.lexsort((candidates, np.round(apart, _ALIKE), point))
            best = order[np.unique(point[order], return_index=True)[1]]
            best = best[apart[best] <= most]
            at = left[point[best]]
            cell[at], xi[at], miss[at] = candidates[best], found[best], apart[best]
            left = left[cell[left] < 0]
            reach, most = max(4 * reach, _REACH * largest), np.inf
        return cell, xi, miss

    def _pulled_back(self, cell: Ints, x: Floats, point: Ints) -> tuple[Floats, Floats]:
        """Return reference coordinates in cells by clamped Newton steps, and relative distances."""
        corners = basix.geometry(self.geometry.cell_type)
        xi = np.broadcast_to(corners.mean(axis=0), x.shape).copy()
        rest = np.empty(x.shape)
        active = np.arange(len(x))
        for number in range(_MAX_ITERATIONS):
            if not len(active):
                break
            position, jacobian = self._mapped(cell[active], xi[active])
            rest[active] = x[active] - position
            step = np.linalg.solve(jacobian, rest[active][:, :, None])[:, :, 0]
            moved = self._inside(xi[active] + step)
            way = np.abs(moved - xi[active]).max(axis=1)
            xi[active] = moved
            active = active[way > _STANDS]
            if number == _SETTLED and len(active):
                miss, least = self._missed(cell, rest), np.full(point.max() + 1, np.inf)
                np.minimum.at(least, point, miss)
                active = active[(least[point] > _INSIDE)[active] | (miss <= _OUTSIDE)[active]]
        rest = x - self._mapped(cell, xi, jacobian=False)[0]
        return xi, self._missed(cell, rest)

    def _missed(self, cell: Ints, rest: Floats) -> Floats:
        return np.asarray(np.linalg.norm(rest, axis=1) / self.sizes[cell])

    def _inside(self, xi: Floats) -> Floats:
        """Return reference coordinates moved into the reference cell."""
        clipped = np.clip(xi, 0.0, 1.0)
        if self.geometry.cell_type in _SIMPLICES:
            over = clipped.sum(axis=1, keepdims=True) - 1
            clipped = np.clip(clipped - np.maximum(over, 0) / self.dim, 0.0, 1.0)
            clipped /= np.maximum(clipped.sum(axis=1, keepdims=True), 1.0)
        return clipped

    def _mapped(self, cell: Ints, xi: Floats, *, jacobian: bool = True) -> tuple[Floats, Floats]:
        """Return positions (n, dim) and derivatives dx_i/dX_j (n, dim, dim)."""
        n, dim = xi.shape
        x, slopes = np.empty((n, dim)), np.empty((n, dim, dim) if jacobian else (0, dim, dim))
        for rows in chunks(n, 16 * (1 + dim) * self.nodes.shape[1]):
            table = self.geometry.tabulate(int(jacobian), xi[rows])[..., 0]
            nodes = self.nodes[cell[rows]]
            x[rows] = np.einsum("nk,nki->ni", table[0], nodes)
            if jacobian:
                slopes[rows] = np.einsum("jnk,nki->nij", table[1:], nodes)
        return x, slopes

    def positions(self, cell: Ints, xi: Floats) -> Floats:
        """Return positions (m) of reference coordinates, (n, dim)."""
        return self._mapped(cell, xi, jacobian=False)[0]

    def values(self, xi: Floats) -> Floats:
        """Return the values of a cell's functions at reference coordinates, (n, n_dofs)."""
        return np.asarray(self.trial.tabulate(0, xi)[0, :, :, 0])


def own_cells(V: Any) -> tuple[Floats, Ints]:
    """Return the geometry nodes (m) and global scalar dofs of the cells of this rank."""
    count = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
    return nodes_and_dofs(V, np.arange(count))
