"""Meshes of gmsh models of any order, spread over the ranks.

The reader of dolfinx knows the order of gmsh's nodes up to order 2 for every cell, up to 3 for
some; here it is found from the reference nodes themselves.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import basix
import basix.ufl
import numpy as np
from dolfinx.graph import adjacencylist
from dolfinx.io.gmsh import extract_geometry, extract_topology_and_markers
from dolfinx.io.utils import distribute_entity_data
from dolfinx.mesh import create_mesh, meshtags_from_entities

from cea.body import Ints
from cea.errors import InputError

_CELLS = {
    "Triangle": "triangle",
    "Quadrilateral": "quadrilateral",
    "Tetrahedron": "tetrahedron",
    "Hexahedron": "hexahedron",
}
"""Cells of dolfinx by gmsh's names, whose first word tells the shape."""


class TaggedMesh(NamedTuple):
    """Mesh (dolfinx), tags of its boundary facets, and the tag of each named surface."""

    mesh: Any
    facet_tags: Any
    surface_tags: Mapping[str, int]


def read_gmsh(model: Any, comm: Any) -> TaggedMesh:
    """Read the mesh of a gmsh model whose cells are all of one kind; collective.

    Parameters
    ----------
    model
        Meshed gmsh model; only that of rank 0 is read.
    comm
        Communicator (mpi4py) to spread the mesh over.

    Raises
    ------
    InputError
        When the model has no physical group of cells, or cells of several kinds.
    """
    header: Any = None
    arrays: Any = None
    if comm.rank == 0:
        try:
            header, arrays = _read(model)
        except InputError as error:
            header = error
    header = comm.bcast(header, root=0)  # a refusal too: all ranks refuse together
    if isinstance(header, InputError):
        raise header
    dim, name, order, per_cell, per_facet, surface_tags = header
    if comm.rank == 0:
        x, cells, facets, values = arrays
    else:
        x, cells = np.empty((0, dim)), np.empty((0, per_cell), dtype=np.int64)
        facets, values = np.empty((0, per_facet), dtype=np.int64), np.empty(0, dtype=np.int32)

    element = basix.ufl.element(
        "Lagrange",
        name,
        order,
        lagrange_variant=basix.LagrangeVariant.equispaced,
        shape=(dim,),
    )
    mesh = create_mesh(comm, cells, element, x)
    mesh.topology.create_entities(dim - 1)
    mesh.topology.create_connectivity(dim - 1, dim)
    entities, tags = distribute_entity_data(mesh, dim - 1, facets, values)
    facet_tags = meshtags_from_entities(mesh, dim - 1, adjacencylist(entities), tags)
    return TaggedMesh(mesh, facet_tags, surface_tags)


def _read(model: Any) -> tuple[tuple, tuple]:
    """What all ranks must know of a model, and its arrays: nodes, cells, facets and their tags."""
    dim = model.getDimension()
    topologies, groups = extract_topology_and_markers(model)
    kinds: dict[int, list[int]] = {dim: [], dim - 1: []}
    for kind in topologies:
        kinds.get(model.mesh.getElementProperties(kind)[1], []).append(kind)
    if len(kinds[dim]) != 1 or len(kinds[dim - 1]) > 1:
        names = [model.mesh.getElementProperties(k)[0] for k in (*kinds[dim], *kinds[dim - 1])]
        raise InputError("model", names, "one kind of cell in physical groups, and of facet")
    (kind,) = kinds[dim]
    family, _, order, per_cell, local, _ = model.mesh.getElementProperties(kind)
    shape = _CELLS.get(family.split()[0])
    if shape is None:
        raise InputError("model", family, f"cells of one of {', '.join(_CELLS.values())}")
    cells = topologies[kind]["topology"].astype(np.int64)[:, _order_of_nodes(shape, order, local)]
    per_facet = 0
    facets, values = np.empty((0, 0), dtype=np.int64), np.empty(0, dtype=np.int32)
    for facet in kinds[dim - 1]:
        facets = topologies[facet]["topology"].astype(np.int64)
        values = topologies[facet]["cell_data"].astype(np.int32)
        per_facet = facets.shape[1]
    surface_tags = {
        name: group.tag for name, group in groups.items() if group.dim == dim - 1 and name
    }
    x = extract_geometry(model)[:, :dim].copy()
    header = (dim, shape, order, per_cell, per_facet, surface_tags)
    return header, (x, cells, facets, values)


def _order_of_nodes(shape: str, order: int, local: Any) -> Ints:
    """Gmsh's number of each node of a cell of dolfinx, (n_nodes,)."""
    element = basix.create_element(
        basix.ElementFamily.P, basix.CellType[shape], order, basix.LagrangeVariant.equispaced
    )
    nodes = np.reshape(local, (len(element.points), -1))
    if shape in ("quadrilateral", "hexahedron"):
        nodes = (nodes + 1) / 2
    apart = np.linalg.norm(element.points[:, None] - nodes, axis=2)
    return np.argmin(apart, axis=1).astype(np.int64)
