"""Edges of shapes at which stresses are singular: where they lie among element boundaries."""

from collections.abc import Mapping, Sequence

import numpy as np

from cea.errors import InputError, require
from cea.mesh import Floats, Ints
from meshes.shapes import Disc, Shape

TOO_FEW = "more elements: at most two edges at one cell, and on one side of it"
"""What is asked of elements among which there is no room for layers."""
Edge = Mapping[str, float]
"""Coordinates along two directions of a shape, those that an edge lies across."""


def run_along(shape: Shape, edges: Sequence[Edge]) -> int | None:
    """Axis that edges run along, None in the plane.

    Raises
    ------
    InputError
        When they do not run along one direction all, or lie outside of the shape. Inside a disc,
        whose lattice turns into that of a square, there are none: only its rim has edges.
    """
    directions, pairs = shape.directions, {frozenset(edge) for edge in edges}
    known = [pair for pair in pairs if len(pair) == 2 and pair <= set(directions)]
    allowed = f"coordinates along the same two of {', '.join(directions)} each"
    require(len(pairs) == len(known) == 1, "edges", [dict(edge) for edge in edges], allowed)
    for edge in edges:
        for name, (low, high) in zip(directions, shape.extent, strict=True):
            inside = low <= edge.get(name, low) <= high
            require(inside, "edges", dict(edge), f"{name} from {low} to {high}")
        on_rim = not isinstance(shape, Disc) or (
            edge.get("r") == shape.outer_radius and "z" in edge
        )
        require(on_rim, "edges", dict(edge), "r of the rim, and z")
    return next((i for i, name in enumerate(directions) if name not in known[0]), None)


def check_edges(shape: Shape, edges: Sequence[Edge], field: str) -> None:
    """Refuse edges that layers cannot be laid around, as :func:`run_along` does.

    Parameters
    ----------
    shape, edges
        The edges of which shape.
    field
        Name of the mesh in messages.

    Raises
    ------
    InputError
        Naming edges.
    """
    try:
        run_along(shape, edges)
    except InputError as error:
        raise InputError(f"{field}.{error.field}", error.value, error.allowed) from None


def check_room(shape: Shape, breaks: Sequence[Floats], edges: Sequence[Edge], field: str) -> None:
    """Refuse elements among which there is no room for layers towards edges.

    Parameters
    ----------
    shape, breaks, edges
        Element boundaries along the directions of a shape, and edges along boundaries.
    field
        Name of the mesh in messages.

    Raises
    ------
    InputError
        Naming elements.
    """
    counts = tuple(len(each) - 1 for each in breaks)
    require(fit(shape, breaks, edges), f"{field}.elements", counts, TOO_FEW)


def fit(shape: Shape, breaks: Sequence[Floats], edges: Sequence[Edge]) -> bool:
    """Whether no cell between breaks has edges at opposite corners, or at more than two."""
    along, directions = run_along(shape, edges), shape.directions
    axes = [axis for axis in range(len(directions)) if axis != along]
    at = np.zeros([len(breaks[axis]) for axis in axes], dtype=bool)
    for edge in edges:
        places = (np.abs(breaks[axis] - edge[directions[axis]]).argmin() for axis in axes)
        at[tuple(places)] = True
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    opposite = (a & d) | (b & c)
    return not opposite.any()


def edge_nodes(
    node: Ints, breaks: Sequence[Floats], directions: Sequence[str], edge: Edge, order: int
) -> Ints:
    """Numbers of the nodes of a lattice on an edge.

    Parameters
    ----------
    node
        Numbers on the lattice. It may begin at a later break of the first direction.
    breaks
        Element boundaries along the directions.
    directions
        Their names.
    edge
        The edge, along breaks.
    order
        Lattice steps across a cell.

    Raises
    ------
    InputError
        When the edge is not along breaks of the lattice.
    """
    for axis, (name, each) in reversed(list(enumerate(zip(directions, breaks, strict=True)))):
        if name in edge:
            at = int(np.abs(each - edge[name]).argmin())
            from_end = (len(each) - 1 - at) * order
            near = abs(each[at] - edge[name]) <= 1e-9 * (each[-1] - each[0])
            require(
                bool(near and from_end < node.shape[axis]),
                "edges",
                dict(edge),
                f"element boundaries along {name}",
            )
            node = np.take(node, node.shape[axis] - 1 - from_end, axis=axis)
    return node.ravel()
