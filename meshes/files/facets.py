"""Facets of the cells of a body, matched by their corners."""

from dataclasses import dataclass

import numpy as np

from cea.mesh import Cell, facet_nodes, reference_nodes
from meshes.files.content import Ints, node_marks
from meshes.files.kinds import FACES, KINDS


@dataclass(frozen=True, eq=False)
class Facets:
    """All facets of cells; those of two cells are inner ones.

    Parameters
    ----------
    cell
        Kind of the cells.
    group
        Number of each facet of each cell, equal for equal facets, (n_cells, n_facets).
    cells_of
        Number of cells that have each facet, (n_groups,).
    keys
        What facets are found by, rising, (n_groups,).
    marks
        Random number of each node.
    """

    cell: Cell
    group: Ints
    cells_of: Ints
    keys: np.ndarray
    marks: np.ndarray

    @property
    def free(self) -> np.ndarray:
        """Which facet of which cell lies on the boundary, (n_cells, n_facets)."""
        return self.cells_of[self.group] == 1

    def find(self, corners: Ints) -> Ints:
        """Group of facets given by their corners in any order, -1 of those that are none, (n,)."""
        wanted = self.marks[corners].sum(axis=1, dtype=np.uint64)
        place = np.minimum(np.searchsorted(self.keys, wanted), len(self.keys) - 1)
        return np.where(self.keys[place] == wanted, place, -1)


def facets_of(cell: Cell, corners: Ints, n_points: int) -> Facets:
    """Facets of cells given by their corners, (n_cells, n_corners), in C order."""
    marks = node_marks(n_points)
    sides = [marks[corners[:, side]].sum(axis=1, dtype=np.uint64) for side in facet_nodes(cell, 1)]
    keys, group, times = np.unique(np.stack(sides, axis=1), return_inverse=True, return_counts=True)
    return Facets(cell, group.reshape(len(corners), -1).astype(np.int64), times, keys, marks)


def facet_numbers(cell: str) -> Ints:
    """Facet, as :func:`cea.mesh.facet_nodes` counts them, of each face S1, S2, ... of Abaqus."""
    kind = next(kind for kind in KINDS.values() if kind.cell == cell and kind.order == 1)
    place = {tuple(node): i for i, node in enumerate(reference_nodes(kind.cell, 1).tolist())}
    ours = [frozenset(side.tolist()) for side in facet_nodes(kind.cell, 1)]
    theirs = [
        frozenset(place[tuple(kind.reference[corner].tolist())] for corner in face)
        for face in FACES[cell]
    ]
    return np.array([ours.index(face) for face in theirs], dtype=np.int64)
