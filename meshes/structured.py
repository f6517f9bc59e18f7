"""Structured meshes of the shapes: quadrilaterals or hexahedra between breaks."""

from collections.abc import Sequence

import numpy as np

from cea.mesh import Ints, Mesh, lattice
from meshes.breaks import Breaks
from meshes.edge_layers import with_layers
from meshes.lattice import lattices
from meshes.placement import Placement
from meshes.shapes import Shape
from meshes.singular_edges import Edge, edge_nodes, run_along


def structured_mesh(
    shape: Shape,
    breaks: Breaks,
    order: int,
    placement: Placement,
    *,
    edges: Sequence[Edge] = (),
    layers: int = 0,
) -> Mesh:
    """Mesh a shape with one cell between each two breaks, and layers around edges.

    Parameters
    ----------
    shape
        The shape.
    breaks
        Element boundaries along the directions of the shape (m, degrees).
    order
        Order of the geometry, 1 to 4.
    placement
        Where the shape is put.
    edges, layers
        Edges along breaks, and geometric layers towards them (:mod:`meshes.edge_layers`).

    Raises
    ------
    InputError
        When breaks do not suit the shape, or the edges.
    """
    dim = len(shape.directions)
    points, parts = lattices(shape, tuple(np.asarray(b, dtype=float) for b in breaks), order)
    in_cell, in_facet = (lattice(d, order, simplex=False) for d in (dim, dim - 1))
    facets: dict[str, list[Ints]] = {name: [] for name in shape.surfaces}
    for part in parts:
        for name, region in part.sides:
            facets[name].append(part.cells(region, in_facet, order))
    cells = np.concatenate([p.cells(region, in_cell, order) for p in parts for region in p.solids])
    mesh = Mesh(
        cell="quadrilateral" if dim == 2 else "hexahedron",
        order=order,
        points=placement.apply(points),
        cells=cells,
        surfaces={name: np.concatenate(parts) for name, parts in facets.items()},
    )
    if edges and layers:
        along = run_along(shape, edges)
        singular = np.zeros(len(points), dtype=bool)
        for edge in edges:  # the last lattice is the outermost one
            on = edge_nodes(parts[-1].node, breaks, shape.directions, edge, order)
            singular[on] = True
        return with_layers(mesh, singular, along, layers)
    return mesh.without_loose_points()  # a hub stands out of a lattice that is otherwise empty
