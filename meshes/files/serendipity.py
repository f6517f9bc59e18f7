"""Nodes that elements without middle nodes lack of Lagrange cells of order 2.

The shape functions of 8-node quadrilaterals and 20-node hexahedra lie in the space of the Lagrange
cells of 9 and 27 nodes. With nodes put where they map the middles of faces and cells the geometry
is what it was.
"""

import numpy as np

from cea.errors import InputError
from cea.mesh import SIMPLICES, facet_nodes, lattice
from meshes.files.content import Floats, Ints
from meshes.files.facets import facets_of
from meshes.files.part import Part

_FACE = {"corner": -0.25, "edge": 0.5}
_CELL = {"corner": -0.25, "edge": 0.25}
"""Shape functions of corners and of middles of edges, at the middle of a face and of a cell."""


def completed(points: Floats, part: Part) -> tuple[Floats, Ints]:
    """Points and cells of a part, with the nodes that were lacking at their end.

    Parameters
    ----------
    points
        Positions of the nodes, (n, dim).
    part
        The part.

    Raises
    ------
    InputError
        When middles of edges lack, or only some elements lack nodes.
    """
    if not part.incomplete:
        return points, part.nodes
    dim, cells = part.dim, part.nodes.copy()
    middles = (lattice(dim, part.order, part.cell in SIMPLICES) == 1).sum(axis=1)
    lacks = cells < 0
    whole_columns = bool((lacks.any(axis=0) == lacks.all(axis=0)).all())
    if (
        part.cell in SIMPLICES
        or part.order != 2
        or not whole_columns
        or lacks[:, middles < 2].any()
    ):
        worst = int(part.numbers[np.argmax(lacks.any(axis=1))])
        raise InputError("file", f"element {worst}", "elements with all nodes of one kind")
    if dim == 3:
        facets = facets_of(part.cell, part.corners, len(points))
        at_faces = np.empty((len(facets.keys), dim))
        for side, group in zip(facet_nodes(part.cell, 2), facets.group.T, strict=True):
            at_faces[group] = _middle(points, cells[:, side], _FACE)
            cells[:, side[4]] = len(points) + group
        points = np.concatenate([points, at_faces])
    centres = _middle(points, part.nodes, _CELL if dim == 3 else _FACE)
    cells[:, np.argmax(middles)] = len(points) + np.arange(len(cells))
    return np.concatenate([points, centres]), cells


def _middle(points: Floats, nodes: Ints, weights: dict[str, float]) -> Floats:
    """Positions of the middles of faces or cells from their corners and middles of edges."""
    dim = {9: 2, 27: 3}[nodes.shape[1]]
    ones = (lattice(dim, 2, simplex=False) == 1).sum(axis=1)
    corners, edges = (points[nodes[:, ones == count]].sum(axis=1) for count in (0, 1))
    return weights["corner"] * corners + weights["edge"] * edges
