"""Division of shapes into elements: breaks along their directions, and layers at singular edges.

Breaks are rising coordinates of the element boundaries along each direction of a shape. A shape is
made of blocks, boxes in its coordinates, which both builders map to space.

Geometric layers surround singular edges, and nothing else. Every cell at an edge is divided across
it: into a smaller one at the edge, with sides of relative length q, and two that connect its inner
sides with the outer sides of the cell. The outer sides stay whole, so that no neighbour is divided,
whereas layered breaks would run through the whole shape. A further layer divides the smaller cells
again. A cell with two edges on one side, as across a thin disc, is divided into a smaller one at
each edge and five others.

Edges extend along one whole direction of a lattice; in the plane they are points.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from cea.mesh import Mesh
from meshes.files.content import facets_on, first_of_near, named_sides
from meshes.patches import Face, Faces
from meshes.shapes import Annulus, Disc, Hub, Ring, Shape

Breaks = tuple[Floats, ...]

CLOSED = (Annulus, Hub, Disc, Ring)
"""Shapes all the way round, made of four quarters."""
_JOINTS = (90.0, 180.0, 270.0)
_SNAP = 1e-9
"""Distance (degrees, m) from a joint of blocks below which a break lies on it."""
TOO_FEW = "more elements: at most two edges at one cell, and on one side of it"
"""Advice for elements that leave no room for layers."""
_ON = 1e-9
"""Distance from an edge, relative to the shape, below which a node lies on it."""
Bools = NDArray[np.bool_]
Edge = Mapping[str, float]
"""Coordinates of an edge along the two directions of a shape that it is normal to."""


def spread(low: float, high: float, count: int, through: Sequence[float] = ()) -> Floats:
    """Return ``count + 1`` element boundaries, as even as possible, through given coordinates."""
    stops = np.unique(np.concatenate([[low, high], np.asarray(through, dtype=float)]))
    inside = bool(stops[0] == low and stops[-1] == high)
    require(inside, "through", list(through), f"{low} to {high}")
    require(count >= len(stops) - 1, "elements", count, f"at least {len(stops) - 1}")
    lengths = np.diff(stops)
    even = np.floor(count * lengths / (high - low)).astype(int)
    shares = np.maximum(1, even - len(lengths))  # lower bounds of the numbers of elements
    for _ in range(count - shares.sum()):
        shares[np.argmax(lengths / shares)] += 1
    counted = zip(pairwise(stops), shares, strict=True)
    pieces = [np.linspace(a, b, n + 1)[:-1] for (a, b), n in counted]
    return np.concatenate([*pieces, [high]])


def breaks_of(
    shape: Shape, elements: Sequence[int], through: Mapping[str, Sequence[float]] | None = None
) -> Breaks:
    """Breaks of a shape along its directions."""
    asked = _asked(shape, elements, through or {})
    return tuple(
        spread(low, high, count, asked.get(name, ()))
        for name, (low, high), count in zip(shape.directions, shape.extent, elements, strict=True)
    )


def check_breaks(shape: Shape, breaks: Breaks) -> None:
    """Refuse breaks that do not rise from end to end of a shape, through joints of its blocks."""
    along = f"one array along each of {', '.join(shape.directions)}"
    require(len(breaks) == len(shape.directions), "breaks", breaks, along)
    for name, values, (low, high) in zip(shape.directions, breaks, shape.extent, strict=True):
        rising = len(values) > 1 and bool((np.diff(values) > 0).all())
        fits = rising and np.allclose([values[0], values[-1]], [low, high], rtol=1e-12)
        require(bool(fits), f"breaks of {name}", values, f"rising, from {low} to {high}")
        joints = _joints(shape).get(name, ())
        there = all(np.abs(values - joint).min() <= _SNAP for joint in joints)
        require(there, f"breaks of {name}", values, f"{joints} among them")


def _joints(shape: Shape) -> dict[str, tuple[float, ...]]:
    """Coordinates at which blocks of a shape meet, by direction."""
    if isinstance(shape, Hub):
        return {"r": (shape.hub_radius,), "theta": _JOINTS, "z": (shape.bottom, shape.top)}
    return {"theta": _JOINTS} if isinstance(shape, CLOSED) else {}


def _asked(
    shape: Shape, elements: Sequence[int], through: Mapping[str, Sequence[float]]
) -> dict[str, list[float]]:
    """Coordinates through which breaks must go, by direction."""
    asked = {name: list(values) for name, values in through.items()}
    unknown = set(asked) - set(shape.directions)
    require(not unknown, "through", sorted(unknown), f"directions {', '.join(shape.directions)}")
    allowed = f"one number for each of {', '.join(shape.directions)}"
    require(len(elements) == len(shape.directions), "elements", tuple(elements), allowed)
    for name, joints in _joints(shape).items():
        asked[name] = [*asked.get(name, []), *joints]
    return asked


def fewest(shape: Shape, through: Mapping[str, Sequence[float]]) -> tuple[int, ...]:
    """Least number of elements along each direction: one between required boundaries."""
    asked = _asked(shape, (1,) * len(shape.directions), through)
    return tuple(
        len({*ends, *asked.get(name, ())}) - 1
        for name, ends in zip(shape.directions, shape.extent, strict=True)
    )


def layered(breaks: Floats, towards: Sequence[float], layers: int, ratio: float) -> Floats:
    """Breaks with geometric layers towards some of them, as for singular stresses at corners."""
    require(0 < ratio < 0.5 and layers >= 0, "ratio", ratio, "0 to 1/2: layers must not overlap")
    shares = ratio ** np.arange(1, layers + 1)
    new = [breaks]
    for centre in towards:
        at = int(np.abs(breaks - centre).argmin())
        for other in (at - 1, at + 1):
            if 0 <= other < len(breaks):
                new.append(breaks[at] + shares * (breaks[other] - breaks[at]))
    return np.unique(np.concatenate(new))


def blocks_of(shape: Shape, breaks: Breaks) -> tuple[list[Breaks], Faces]:
    """Breaks of each block of a shape, and its named faces.

    Straight shapes and sectors are one block, closed ones four quarters; a hub has those of its
    ring, then four of each layer of the hub from below.
    """
    if isinstance(shape, Hub):
        return _blocks_of_hub(shape, breaks)
    axes = [axis for axis in range(len(breaks)) if not (isinstance(shape, CLOSED) and axis == 1)]
    ends = [(axis, side) for axis in axes for side in (0, 1)]
    if isinstance(shape, Disc):
        ends.remove((0, 0))  # the axis is no face
    blocks = _quarters(*breaks) if isinstance(shape, CLOSED) else [breaks]
    named = dict(zip(shape.surfaces, ends, strict=True))
    return blocks, {name: _on_all(range(len(blocks)), *end) for name, end in named.items()}


def _blocks_of_hub(shape: Hub, breaks: Breaks) -> tuple[list[Breaks], Faces]:
    r, theta, z = breaks
    inside, outside = _between(r, 0.0, shape.hub_radius), _between(r, shape.hub_radius, np.inf)
    levels = np.unique([shape.hub_bottom, shape.bottom, shape.top, shape.hub_top])
    blocks = _quarters(outside, theta, _between(z, shape.bottom, shape.top))
    standing_out: list[int] = []
    for low, high in pairwise(levels):
        if low != shape.bottom:
            standing_out += range(len(blocks), len(blocks) + 4)
        blocks += _quarters(inside, theta, _between(z, low, high))
    ring, hub = range(4), range(4, len(blocks))
    return blocks, {
        "bore": _on_all(hub, 0, 0),
        "outer": _on_all(ring, 0, 1),
        "bottom": _on_all(ring, 2, 0),
        "top": _on_all(ring, 2, 1),
        "hub_bottom": _on_all(hub[:4], 2, 0),
        "hub_top": _on_all(hub[-4:], 2, 1),
        "hub_side": _on_all(standing_out, 0, 1),
    }


def _quarters(radii: Floats, angles: Floats, *heights: Floats) -> list[Breaks]:
    """Breaks of four blocks all the way round."""
    blocks: list[Breaks] = []
    for low, high in pairwise((0.0, *_JOINTS, 360.0)):
        within = _between(angles, low, high)
        within[[0, -1]] = low, high
        blocks.append((radii, within, *heights))
    return blocks


def _between(values: Floats, low: float, high: float) -> Floats:
    return values[(values > low - _SNAP) & (values < high + _SNAP)]


def _on_all(blocks: Iterable[int], axis: int, side: int) -> tuple[Face, ...]:
    """The same face of several blocks."""
    return tuple((block, axis, side) for block in blocks)


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
