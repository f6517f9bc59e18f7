"""Distribution of meshes given as plain arrays, as dolfinx meshes with tagged facets."""

from typing import Any

import basix
import basix.ufl
import numpy as np
from dolfinx.graph import adjacencylist
from dolfinx.io.utils import distribute_entity_data
from dolfinx.mesh import create_mesh, meshtags_from_entities

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.mesh import DIMENSION, SIMPLICES, Cell, Mesh, lattice, matching_nodes
from cea.petsc import MPI


def lasting_communicator(comm: Any) -> Any:
    """Return an equivalent communicator that is never freed, if there is one.

    The communicator of a dolfinx mesh is freed with it, which makes its PETSc matrices unusable,
    but contacts and pencils outlive their meshes.
    """
    same = (MPI.IDENT, MPI.CONGRUENT)
    for known in (MPI.COMM_WORLD, MPI.COMM_SELF):
        if MPI.Comm.Compare(comm, known) in same:
            return known
    return comm


def distribute(mesh: Mesh | None, comm: Any, field: str) -> tuple[Any, Any, dict[str, int]]:
    """Distribute a mesh over the ranks; collective.

    Return the mesh (dolfinx), tags of its boundary facets, and the tag of each named surface.
    """
    said = (mesh.cell, mesh.order, tuple(mesh.surfaces)) if mesh is not None else None
    said = comm.bcast(said, root=0)
    if said is None:
        raise InputError(field, None, "a mesh, at least on rank 0")
    cell, order, names = said
    dim = DIMENSION[cell]
    element = basix.ufl.element(
        "Lagrange",
        cell,
        order,
        lagrange_variant=basix.LagrangeVariant.equispaced,
        shape=(dim,),
    )
    points, cells, facets, tags = _arrays(mesh if comm.rank == 0 else None, cell, order)
    spread = create_mesh(comm, cells, element, points)
    spread.topology.create_entities(dim - 1)
    spread.topology.create_connectivity(dim - 1, dim)
    entities, values = distribute_entity_data(spread, dim - 1, facets, tags)
    facet_tags = meshtags_from_entities(spread, dim - 1, adjacencylist(entities), values)
    return spread, facet_tags, {name: tag for tag, name in enumerate(names, start=1)}


def _arrays(mesh: Mesh | None, cell: Cell, order: int) -> tuple[Floats, Ints, Ints, Any]:
    """Return points, cells, facets and tags in the order of basix; empty without a mesh."""
    dim = DIMENSION[cell]
    kind = basix.CellType[cell]
    in_cell = _order_of_basix(kind, dim, order)
    in_facet = _order_of_basix(basix.cell.sub_entity_type(kind, dim - 1, 0), dim - 1, order)
    if mesh is None:
        none = np.empty((0, len(in_cell)), dtype=np.int64)
        no_facets = np.empty((0, len(in_facet)), dtype=np.int64)
        return np.empty((0, dim)), none, no_facets, np.empty(0, dtype=np.int32)
    mesh = mesh.without_loose_points()  # dolfinx does not accept unused points
    facets = [np.empty((0, len(in_facet)), dtype=np.int64), *mesh.surfaces.values()]
    tags = np.repeat(np.arange(len(facets), dtype=np.int32), [len(part) for part in facets])
    return mesh.points, mesh.cells[:, in_cell], np.concatenate(facets)[:, in_facet], tags


def _order_of_basix(kind: Any, dim: int, order: int) -> Ints:
    """Return the number in a :class:`cea.mesh.Mesh` of each node of a basix cell, (n_nodes,)."""
    element = basix.create_element(
        basix.ElementFamily.P, kind, order, basix.LagrangeVariant.equispaced
    )
    return matching_nodes(element.points, lattice(dim, order, kind.name in SIMPLICES) / order)
