"""Gmsh models read as plain arrays, and gmsh held for as long as one is made."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import gmsh
import numpy as np

from cea.errors import InputError, require
from cea.mesh import Cell, Ints, Mesh, node_order
from cea.signals import ignore_closed_pipes

_CELLS: dict[str, Cell] = {
    "Triangle": "triangle",
    "Quadrilateral": "quadrilateral",
    "Tetrahedron": "tetrahedron",
    "Hexahedron": "hexahedron",
}
"""Cells by the first word of gmsh's names."""


@contextmanager
def gmsh_session() -> Iterator[None]:
    """Start gmsh, silent and on one thread, and end it when the block is left."""
    if gmsh.isInitialized():
        raise RuntimeError("gmsh is in use already: end it before the next mesh")
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    ignore_closed_pipes()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield
    finally:
        gmsh.finalize()


def read_gmsh(model: Any) -> Mesh:
    """Mesh of a gmsh model whose cells are all of one kind.

    Parameters
    ----------
    model
        Meshed gmsh model of order 1 to 4. Cells of its physical groups of highest dimension are
        read; its named physical groups of one dimension less are the surfaces.

    Raises
    ------
    InputError
        When no physical group has cells, or they are of several kinds, or as for
        :class:`cea.mesh.Mesh`.
    """
    dim = model.getDimension()
    entities = dict.fromkeys(
        entity
        for group in model.getPhysicalGroups(dim)
        for entity in model.getEntitiesForPhysicalGroup(*group)
    )
    kind, tagged = _elements(model, dim, entities)
    family, _, order, _, local, _ = model.mesh.getElementProperties(kind)
    cell = _CELLS.get(family.split()[0])
    if cell is None:
        raise InputError("model", family, f"cells of one of {', '.join(_CELLS.values())}")
    nodes = np.reshape(local, (-1, dim))
    if cell in ("quadrilateral", "hexahedron"):
        nodes = (nodes + 1) / 2  # gmsh's reference boxes reach from -1 to 1

    tags, positions, _ = model.mesh.getNodes()
    by_tag = np.argsort(tags)
    number = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    number[tags[by_tag]] = np.arange(len(tags))
    surfaces = {}
    for group in model.getPhysicalGroups(dim - 1):
        name = model.getPhysicalName(*group)
        if name:
            facets = model.getEntitiesForPhysicalGroup(*group)
            surfaces[name] = number[_elements(model, dim - 1, facets)[1]]
    points = positions.reshape(-1, 3)[by_tag, :dim]
    cells = number[tagged[:, node_order(cell, order, nodes)]]
    return Mesh(cell, order, points, cells, surfaces).without_loose_points()


def _elements(model: Any, dim: int, entities: Iterable[int]) -> tuple[int, Ints]:
    """Kind of the elements of some entities, and the tags of their nodes, (n, n_nodes)."""
    found: dict[int, list[Ints]] = {}
    for entity in entities:
        for kind, _, nodes in zip(*model.mesh.getElements(dim, entity), strict=True):
            per_element = model.mesh.getElementProperties(kind)[3]
            found.setdefault(kind, []).append(nodes.astype(np.int64).reshape(-1, per_element))
    names = [model.mesh.getElementProperties(kind)[0] for kind in found]
    allowed = f"elements of one kind in the physical groups of dimension {dim}"
    require(len(found) == 1, "model", names, allowed)
    ((kind, parts),) = found.items()
    return kind, np.concatenate(parts)
