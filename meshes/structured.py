"""Structured meshes of the shapes: boxes between breaks, or the simplices that they divide into.

A polynomial of degree k through the equispaced points of an arc errs by h^(k+1), with a mean that
does not vanish when k is odd, and so do the eigenvalues of a body so bounded. Through the
Gauss-Lobatto points the mean error is h^(2k), the order at which eigenvalues of elements of
degree k converge. Mesh files hold equispaced nodes: those here lie on that polynomial. Up to
order 2 the two sets of points are one.

Each quadrilateral gives two triangles, each hexahedron six tetrahedra that have the diagonal from
its first to its last corner in common and go along one direction after the other (H. W. Kuhn, IBM
J. Res. Dev. 4, 1960). Neighbours divide their common face alike when parallel edges run the same
way through the whole mesh.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.special import roots_jacobi

from cea.arrays import Floats, Ints
from cea.errors import require
from cea.mesh import Mesh, lattice
from meshes.breaks import CLOSED, Breaks
from meshes.edge_layers import Edge, edge_nodes, run_along, with_layers
from meshes.placement import Placement
from meshes.shapes import Box, Disc, Hub, Rectangle, Shape


def lobatto(order: int) -> Floats:
    """Gauss-Lobatto points of the unit interval, ends included, shape (order + 1,)."""
    inner = roots_jacobi(order - 1, 1, 1)[0] if order > 1 else np.empty(0)
    return (np.concatenate([[-1.0], inner, [1.0]]) + 1) / 2


def interpolate_arc(angles: Floats, order: int) -> Floats:
    """Points of the unit circle at the nodes of arcs of a given order."""
    between = angles[:-1, None] + np.diff(angles)[:, None] * lobatto(order)
    circle = np.stack([np.cos(between), np.sin(between)], axis=-1)
    if order > 2:
        nodes = np.arange(order + 1)[:, None] / order
        circle = np.einsum("ij,njd->nid", _change(lobatto(order)[:, None], nodes, order), circle)
    return np.concatenate([circle[:, :-1].reshape(-1, 2), circle[-1, -1:]])


def simplex_changes(equispaced: Floats, order: int) -> tuple[Floats, Floats]:
    """Matrices from values at the equispaced nodes of a simplex to Lobatto-like ones, and back.

    The Lobatto-like node of index (i, j, ..) has barycentric coordinates (g_i, g_j, ..) / sum with
    g the Lobatto points of the interval: on each edge they are those points, and what lies on a
    face depends on the face alone.
    """
    last = 1 - equispaced.sum(axis=1, keepdims=True)
    index = np.rint(order * np.column_stack([equispaced, last])).astype(int)
    barycentric = lobatto(order)[index]
    warped = (barycentric / barycentric.sum(axis=1, keepdims=True))[:, :-1]
    return _change(equispaced, warped, order), _change(warped, equispaced, order)


def _change(known: Floats, wanted: Floats, order: int) -> Floats:
    """Matrix from values of a polynomial at known points to those at wanted points."""
    return np.linalg.solve(_monomials(known, order).T, _monomials(wanted, order).T).T


def _monomials(points: Floats, order: int) -> Floats:
    powers = [p for p in product(range(order + 1), repeat=points.shape[1]) if sum(p) <= order]
    return np.prod((2 * points[:, None] - 1) ** np.array(powers), axis=2)


Region = tuple[slice | int, ...]
"""Part of a lattice: a range of its cells along a direction, or the number of a break across it."""

Sides = tuple[tuple[str, Region], ...]
_ALL = slice(None)


@dataclass(frozen=True)
class Lattice:
    """Block of cells."""

    node: Ints
    solids: tuple[Region, ...]
    sides: Sides

    def cells(self, region: Region, offsets: Ints, order: int) -> Ints:
        """Nodes of the cells of a region, (n_cells, n_nodes)."""
        node = self.node
        for axis, part in reversed(list(enumerate(region))):
            count = (self.node.shape[axis] - 1) // order
            if isinstance(part, int):
                node = np.take(node, range(count + 1)[part] * order, axis=axis)
            else:
                start, stop, _ = part.indices(count)
                node = np.take(node, np.arange(start * order, stop * order + 1), axis=axis)
        corners = np.meshgrid(*(np.arange(0, n - 1, order) for n in node.shape), indexing="ij")
        return node[tuple(c.reshape(-1, 1) + offsets[:, d] for d, c in enumerate(corners))]


def lattices(shape: Shape, breaks: Breaks, order: int) -> tuple[Floats, list[Lattice]]:
    """Nodes (m), (n, dim), and lattices of a shape.

    Inner nodes of a ring, too, lie on the circle of their lattice line. A disc is five blocks: a
    square whose corners lie on the circle of the break nearest to half the radius, divided as its
    quarters are, takes the place of the breaks along r inside that circle; between the square and
    the rim the lattice lines pass over from the straight to the round.
    """
    if isinstance(shape, Disc):
        points, nodes = _disc(shape, breaks, order)
    else:
        points, nodes = _plane(shape, breaks, order)
    if len(breaks) == 3:
        z = _divided(breaks[2], order)
        nodes = [node[..., None] + len(points) * np.arange(len(z)) for node in nodes]
        points = np.column_stack([np.tile(points, (len(z), 1)), np.repeat(z, len(points))])
    if isinstance(shape, Hub):
        return points, [_hub(shape, breaks, nodes[0])]
    whole: Region = (_ALL,) * len(breaks)
    if isinstance(shape, Disc):
        faces: Sides = (("bottom", (_ALL, _ALL, 0)), ("top", (_ALL, _ALL, -1)))
        around: Sides = (("outer", (-1, _ALL, _ALL)), *faces)
        square, ring = nodes
        return points, [Lattice(square, (whole,), faces), Lattice(ring, (whole,), around)]
    ends = [(axis, end) for axis in range(len(breaks)) for end in (0, -1)]
    if isinstance(shape, CLOSED):
        ends = [(axis, end) for axis, end in ends if axis != 1]
    walls = [(*whole[:axis], end, *whole[axis + 1 :]) for axis, end in ends]
    return points, [Lattice(nodes[0], (whole,), tuple(zip(shape.surfaces, walls, strict=True)))]


def _divided(line: Floats, order: int) -> Floats:
    """Breaks with each interval divided in ``order`` equal parts."""
    parts = line[:-1, None] + np.diff(line)[:, None] * np.arange(order) / order
    return np.append(parts.ravel(), line[-1])


def _plane(shape: Shape, breaks: Breaks, order: int) -> tuple[Floats, list[Ints]]:
    """Points (m), (n, 2), and numbers on the lattice of the first two directions."""
    first = _divided(breaks[0], order)
    if isinstance(shape, Box | Rectangle):
        grid = np.stack(np.meshgrid(first, _divided(breaks[1], order), indexing="ij"), axis=-1)
    else:
        grid = first[:, None, None] * interpolate_arc(np.radians(breaks[1]), order)
    if isinstance(shape, CLOSED):
        points = grid[:, :-1].reshape(-1, 2)
        open_ring = np.arange(len(points)).reshape(len(first), -1)
        return points, [np.concatenate([open_ring, open_ring[:, :1]], axis=1)]
    points = grid.reshape(-1, 2)
    return points, [np.arange(len(points)).reshape(grid.shape[:2])]


def _disc(shape: Disc, breaks: Breaks, order: int) -> tuple[Floats, list[Ints]]:
    """Points (m), (n, 2), and lattices of the square in the middle and of the ring around it."""
    radii, angles = breaks[0], breaks[1]
    require(len(radii) > 2, "breaks of r", radii, "two elements at least, one of them the square")
    quarter = np.searchsorted(angles, np.array([0.0, 90.0, 180.0, 270.0, 360.0]) - 1e-9)
    sides = np.diff(quarter)
    matching = sides[0] == sides[2] and sides[1] == sides[3]
    allowed = "as many in a quarter of a disc as in that across"
    require(bool(matching), "breaks of theta", angles, allowed)
    core = 1 + int(np.abs(radii[1:-1] - shape.outer_radius / 2).argmin())
    corner = radii[core]

    # Share of its side of the square at each lattice line of a quarter.
    shares = []
    for start, stop in pairwise(quarter):
        line = _divided(angles[start : stop + 1], order)
        shares.append((line - line[0]) / (line[-1] - line[0]))
    below, above = shares[0][:, None], 1 - shares[2][::-1, None]
    left, right = 1 - shares[3][::-1], shares[1]
    # Where the line from side 0 to side 2 crosses that from side 1 to side 3.
    du, dv = above - below, right - left
    u = (below + left * du) / (1 - du * dv)
    v = left + u * dv
    square = corner * np.stack([1 - u - v, u - v], axis=-1)
    middle = np.arange(square[..., 0].size).reshape(square.shape[:2])
    rim = np.concatenate([middle[:-1, 0], middle[-1, :-1], middle[:0:-1, -1], middle[0, :0:-1]])

    inner = square.reshape(-1, 2)[rim]
    outer = shape.outer_radius * interpolate_arc(np.radians(angles), order)[:-1]
    along = (_divided(radii[core:], order)[1:] - corner) / (shape.outer_radius - corner)
    ring = inner + along[:, None, None] * (outer - inner)
    around = square[..., 0].size + np.arange(ring[..., 0].size).reshape(ring.shape[:2])
    around = np.concatenate([rim[None], around])
    around = np.concatenate([around, around[:, :1]], axis=1)
    return np.concatenate([square.reshape(-1, 2), ring.reshape(-1, 2)]), [middle, around]


def _hub(shape: Hub, breaks: Breaks, node: Ints) -> Lattice:
    """Lattice of hub and ring, empty above and below the ring."""
    wall = int(np.abs(breaks[0] - shape.hub_radius).argmin())
    low, high = (int(np.abs(breaks[2] - z).argmin()) for z in (shape.bottom, shape.top))
    within, beyond, ring = slice(0, wall), slice(wall, None), slice(low, high)
    sides: Sides = (
        ("bore", (0, _ALL, _ALL)),
        ("outer", (-1, _ALL, ring)),
        ("bottom", (beyond, _ALL, low)),
        ("top", (beyond, _ALL, high)),
        ("hub_bottom", (within, _ALL, 0)),
        ("hub_top", (within, _ALL, -1)),
        ("hub_side", (wall, _ALL, slice(0, low))),
        ("hub_side", (wall, _ALL, slice(high, None))),
    )
    return Lattice(node, ((within, _ALL, _ALL), (beyond, _ALL, ring)), sides)


_SIMPLEX = {"quadrilateral": "triangle", "hexahedron": "tetrahedron"}


def divided(mesh: Mesh) -> Mesh:
    """Divide quadrilaterals into two triangles or hexahedra into six tetrahedra on their nodes."""
    require(mesh.cell in _SIMPLEX, "cell", mesh.cell, f"one of {', '.join(_SIMPLEX)}")
    order, points = mesh.order, mesh.points
    if mesh.cell == "quadrilateral":
        return Mesh("triangle", order, points, _split(mesh.cells, 2, order), mesh.surfaces)
    aligned = replace(mesh, cells=_same_ways(mesh))  # its facets run as their cells do
    facets = {name: _split(part, 2, order) for name, part in aligned.surfaces.items()}
    return Mesh("tetrahedron", order, points, _split(aligned.cells, 3, order), facets)


def _split(boxes: Ints, dim: int, order: int) -> Ints:
    """Nodes of the simplices of boxes, those of one box after another, (n_simplices, n_nodes)."""
    places = lattice(dim, order, simplex=True)
    parts = [
        np.ravel_multi_index((places @ _edges(way)).T, (order + 1,) * dim)
        for way in permutations(range(dim))
    ]
    return boxes[:, parts].reshape(-1, len(places))


def _edges(way: Sequence[int]) -> Ints:
    """Edges from the first corner of a simplex to the others, right-handed, (dim, dim)."""
    corners = np.cumsum(np.eye(len(way), dtype=np.int64)[list(way)], axis=0)
    if np.linalg.det(corners) < 0:
        corners[[0, 1]] = corners[[1, 0]]
    return corners


def _same_ways(mesh: Mesh) -> Ints:
    """Cells of hexahedra, some turned over so that parallel edges run the same way in all."""
    order = mesh.order
    nodes = mesh.cells.reshape(-1, *(order + 1,) * 3)
    against = _against(nodes[:, ::order, ::order, ::order])
    for axis in range(3):
        flip = against[:, axis, None, None, None]
        nodes = np.where(flip, np.flip(nodes, axis=axis + 1), nodes)
    return nodes.reshape(mesh.cells.shape)


def _against(corners: Ints) -> NDArray[np.bool_]:
    """Whether the edges of each hexahedron along each direction run against the others.

    Edges opposite each other in a face are parallel. All that are parallel shall run as they do in
    the first cell that has one of them.
    """
    parallel = [np.moveaxis(corners, axis, -1).reshape(-1, 4, 2) for axis in (1, 2, 3)]
    edges = np.stack(parallel, axis=1)
    low, high = edges.min(axis=3), edges.max(axis=3)
    _, edge = np.unique(low * (corners.max() + 1) + high, return_inverse=True)
    # An edge is two nodes of a graph, one for each way along it: links join equal ways.
    way = 2 * edge.reshape(low.shape) + (edges[..., 0] == low)
    first, others = np.repeat(way[..., 0], 3), way[..., 1:].ravel()
    rows, columns = np.concatenate([first, first ^ 1]), np.concatenate([others, others ^ 1])
    size = 2 * (int(edge.max()) + 1)
    links = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(size, size))
    _, label = connected_components(links, directed=False)
    forth, back = label[way[..., 0]], label[way[..., 0] ^ 1]
    twisted = (forth == back).any(axis=1)
    value = f"{twisted.sum()} of {len(corners)} hexahedra"
    allowed = "parallel edges that can run the same way, so that faces are divided alike"
    require(not twisted.any(), "cells", value, allowed)
    _, leader, sheet = np.unique(np.minimum(forth, back), return_index=True, return_inverse=True)
    return forth != forth.ravel()[leader][sheet.reshape(forth.shape)]


def structured_mesh(
    shape: Shape,
    breaks: Breaks,
    order: int,
    placement: Placement,
    *,
    edges: Sequence[Edge] = (),
    layers: int = 0,
) -> Mesh:
    """Mesh a shape with one cell between each two breaks, and layers around edges."""
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
