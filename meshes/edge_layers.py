"""Geometric layers of cells around singular edges, and nowhere else.

Every cell at an edge is divided across it: into a smaller one at the edge, with sides of relative
length q, and two that connect its inner sides with the outer sides of the cell. The outer sides
stay whole, so that no neighbour is divided, whereas layered breaks would run through the whole
shape. A further layer divides the smaller cells again. A cell with two edges on one side, as across
a thin disc, is divided into a smaller one at each edge and five others.

Edges extend along one whole direction of a lattice; in the plane they are points.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from cea.mesh import Mesh
from meshes.files.content import facets_on, first_of_near, named_sides
from meshes.shapes import Disc, Shape

TOO_FEW = "more elements: at most two edges at one cell, and on one side of it"
"""Advice for elements that leave no room for layers."""
_ON = 1e-9
"""Distance from an edge, relative to the shape, below which a node lies on it."""
Bools = NDArray[np.bool_]
Edge = Mapping[str, float]
"""Coordinates of an edge along the two directions of a shape that it is normal to."""


def run_along(shape: Shape, edges: Sequence[Edge]) -> int | None:
    """Axis along which edges run, None in the plane."""
    directions, pairs = shape.directions, {frozenset(edge) for edge in edges}
    known = [pair for pair in pairs if len(pair) == 2 and pair <= set(directions)]
    allowed = f"coordinates along the same two of {', '.join(directions)} each"
    require(len(pairs) == len(known) == 1, "edges", [dict(edge) for edge in edges], allowed)
    for edge in edges:
        for name, (low, high) in zip(directions, shape.extent, strict=True):
            inside = low <= edge.get(name, low) <= high
            require(inside, "edges", dict(edge), f"{name} from {low} to {high}")
        if isinstance(shape, Disc):
            on_rim = edge.get("r") == shape.outer_radius and "z" in edge
            require(on_rim, "edges", dict(edge), "r of the rim, and z")
    return next((i for i, name in enumerate(directions) if name not in known[0]), None)


def fit(shape: Shape, breaks: Sequence[Floats], edges: Sequence[Edge]) -> bool:
    """Whether no cell between breaks has edges at opposite corners, or at more than two."""
    along, directions = run_along(shape, edges), shape.directions
    axes = [axis for axis in range(len(directions)) if axis != along]
    at = np.zeros([len(breaks[axis]) for axis in axes], dtype=bool)
    for edge in edges:
        places = (np.abs(breaks[axis] - edge[directions[axis]]).argmin() for axis in axes)
        at[tuple(places)] = True
    opposite = (at[:-1, :-1] & at[1:, 1:]) | (at[:-1, 1:] & at[1:, :-1])
    return not opposite.any()


def _on_edge(shape: Shape, points: Floats, edge: Edge) -> Bools:
    """Which points (m) lie on an edge."""
    at = dict(zip("xyz", points.T, strict=False))
    if "theta" in shape.directions:
        at |= {"r": np.hypot(at["x"], at["y"]), "theta": np.degrees(np.arctan2(at["y"], at["x"]))}
    on = np.ones(len(points), dtype=bool)
    for name, (low, high) in zip(shape.directions, shape.extent, strict=True):
        if name in edge:
            away = at[name] - edge[name]
            away = (away + 180) % 360 - 180 if name == "theta" else away
            on &= np.abs(away) <= _ON * (high - low)
    require(bool(on.any()), "edges", dict(edge), "coordinates of element boundaries")
    return on


RATIO = 0.2
"""Size of a cell of a layer relative to the next one: near the optimum for corners."""
_TURN = np.array([0.55, 0.3])
"""Relative coordinates of the bend of the cells between two edges: away from the side with both
edges, and along it."""


def quads_towards(marked: NDArray[np.bool_], layers: int) -> Floats:
    """Divide the unit square into quadrilaterals towards marked corners, (n, 2, 2, 2).

    The last axis has the two coordinates of corner [i, j]; quadrilaterals are right-handed.
    """
    whole = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], indexing="ij"), axis=-1)[None]
    if not layers:
        return whole
    corners = np.argwhere(marked)
    alone = len(corners) == 1
    shared = [] if alone else np.flatnonzero((corners == corners[0]).all(axis=0)).tolist()
    if not alone and (len(corners) > 2 or not shared):
        raise InputError("elements", f"{len(corners)} edges at a cell", TOO_FEW)
    corner = np.array([[True, False], [False, False]])
    small = RATIO * quads_towards(corner, layers - 1)
    quads = _around_one(small) if alone else _around_two(small)
    if not alone and shared[0] == 1:
        quads = quads.swapaxes(1, 2)[..., ::-1]
    for axis in range(2):
        if corners[0, axis] == 1:
            quads = np.flip(quads, axis=1 + axis).copy()
            quads[..., axis] = 1 - quads[..., axis]
    return quads


def _around_one(small: Floats) -> Floats:
    """Divide a square towards the corner (0, 0), given the cells ``small`` at it."""
    q = RATIO
    along = [[[q, 0], [q, q]], [[1, 0], [1, 1]]]
    up = [[[0, q], [0, 1]], [[q, q], [1, 1]]]
    return np.concatenate([small, np.array([along, up], dtype=float)])


def _around_two(small: Floats) -> Floats:
    """Divide a square towards (0, 0) and (0, 1), given the cells ``small`` at the first."""
    q, (a, b) = RATIO, _TURN
    low = np.concatenate([small, np.array([[[[q, 0], [q, q]], [[1, 0], [a, b]]]])])
    high = np.flip(low, axis=2).copy()
    high[..., 1] = 1 - high[..., 1]
    between = [
        [[[0, q], [0, 1 - q]], [[q, q], [q, 1 - q]]],
        [[[q, q], [q, 1 - q]], [[a, b], [a, 1 - b]]],
        [[[a, b], [a, 1 - b]], [[1, 0], [1, 1]]],
    ]
    return np.concatenate([low, high, np.array(between)])


SAME = 1e-3
"""Distance of nodes, relative to the least of neighbours, below which they are merged."""


def shortest_step(blocks: Iterable[Floats], axes: Iterable[int]) -> float:
    """Least distance of neighbours on lattices of points, (n1, ..., dim), along some axes."""
    steps = [np.diff(x, axis=axis) for x in blocks for axis in axes if x.shape[axis] > 1]
    return min(float(np.linalg.norm(step, axis=-1).min()) for step in steps)


def with_layers(mesh: Mesh, shape: Shape, edges: Sequence[Edge], layers: int) -> Mesh:
    """Divide the cells of a structured mesh at edges into layers towards them."""
    along, n, dim = run_along(shape, edges), mesh.order + 1, mesh.dim
    lattice = mesh.cells.reshape(-1, *(n,) * dim)
    lattice = lattice[..., None] if along is None else np.moveaxis(lattice, 1 + along, -1)
    corners = lattice[:, :: n - 1, :: n - 1, :: n - 1]
    used, place = np.unique(corners, return_inverse=True)
    singular = np.logical_or.reduce([_on_edge(shape, mesh.points[used], edge) for edge in edges])
    marked = singular[place.reshape(corners.shape)].all(axis=-1)
    cells, points, named = [mesh.cells], [mesh.points], named_sides(mesh)
    sides = {name: [on] for name, on in named.items()}
    kept = np.ones(len(mesh.cells), dtype=bool)
    count, least = len(mesh.points), np.inf
    for pattern in np.unique(marked[marked.any(axis=(1, 2))], axis=0):
        some = np.flatnonzero((marked == pattern).all(axis=(1, 2)))
        kept[some] = False
        quads = quads_towards(pattern, layers)
        x = _placed(mesh.points[lattice[some]], quads, mesh.order)
        least = min(least, shortest_step([x], (2, 3, 4)))
        numbers = count + np.arange(x[..., 0].size).reshape(x.shape[:-1])
        count += x[..., 0].size
        points.append(x.reshape(-1, dim))
        made = numbers[..., 0] if along is None else np.moveaxis(numbers, -1, 2 + along)
        made = made.reshape(len(some), len(quads), -1)
        cells.append(made.reshape(-1, made.shape[-1]))
        parents = _sides_of_parts(quads, dim, along)
        for name, on in named.items():
            sides[name].append((on[some][:, parents] & (parents >= 0)).reshape(-1, 2 * dim))
    if len(points) == 1:
        return mesh
    every = np.concatenate(points)
    first = first_of_near(every, SAME * least)
    cells[0] = mesh.cells[kept]
    parts = first[np.concatenate(cells)]
    surfaces = {
        name: facets_on(mesh.cell, mesh.order, parts, np.concatenate([whole[kept], *divided]))
        for name, (whole, *divided) in sides.items()
    }
    return Mesh(mesh.cell, mesh.order, every, parts, surfaces).without_loose_points()


def _placed(nodes: Floats, quads: Floats, order: int) -> Floats:
    """Nodes of the parts of cells, by the polynomial maps of the cells."""
    t = np.arange(order + 1) / order
    ends = np.stack([1 - t, t])
    at = np.einsum("ai,bj,qabx->qijx", ends, ends, quads)
    others = ~np.eye(order + 1, dtype=bool)
    factors = np.where(others, at[..., None, None] - t, 1.0).prod(axis=-1)
    values = factors / np.where(others, t[:, None] - t, 1.0).prod(axis=-1)
    u, v = values[..., 0, :], values[..., 1, :]
    placed: Floats = np.einsum("qija,qijb,cabkx->cqijkx", u, v, nodes, optimize=True)
    return placed


def _sides_of_parts(quads: Floats, dim: int, along: int | None) -> Ints:
    """Facet of a cell on which each facet of each of its parts lies; -1 inside, (parts, 2 dim)."""
    axes = [axis for axis in range(dim) if axis != along]
    found: Ints = np.full((len(quads), 2 * dim), -1, dtype=np.int64)
    if along is not None:
        found[:, [2 * along, 2 * along + 1]] = 2 * along, 2 * along + 1
    for part, own, of_own in np.ndindex(len(quads), 2, 2):
        line = quads[part, of_own, :, :] if own == 0 else quads[part, :, of_own, :]
        for axis, end in np.ndindex(2, 2):
            if (line[:, axis] == end).all():
                found[part, 2 * axes[own] + of_own] = 2 * axes[axis] + end
    return found
