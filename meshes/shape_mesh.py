"""Meshes of the shapes: boxes between breaks, the simplices that they divide into, or unstructured.

A polynomial of degree k through the equispaced points of an arc has an error of h^(k+1), whose mean
does not vanish for odd k, and so have the eigenvalues of a body bounded by it. Through the
Gauss-Lobatto points the mean error is h^(2k), the order at which eigenvalues of elements of
degree k converge. Meshes have equispaced nodes: here they lie on that polynomial. Up to order 2 the
two sets of points coincide.

Each quadrilateral gives two triangles, each hexahedron six tetrahedra that share the diagonal from
its first to its last corner and follow one direction after the other (H. W. Kuhn, IBM J. Res.
Dev. 4, 1960).
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, permutations, product

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.special import roots_jacobi

from cea.arrays import Floats, Ints
from cea.errors import require
from cea.mesh import SIMPLICES, Cell, Mesh, lattice, reference_nodes
from meshes.breaks import SAME, Breaks, Edge, blocks_of, check_breaks, shortest_step, with_layers
from meshes.crowned import Crowned
from meshes.files.content import first_of_near
from meshes.patches import Faces
from meshes.placement import IN_PLACE, Placement
from meshes.shapes import Box, Disc, Rectangle, Shape, round_surfaces


def shape_mesh(
    shape: Shape,
    cell: Cell,
    order: int,
    *,
    breaks: Breaks | None = None,
    size: float | None = None,
    placement: Placement = IN_PLACE,
    edges: Sequence[Edge] = (),
    layers: int = 0,
) -> Mesh:
    """Mesh a shape; its surfaces (curves in the plane) are named as in ``shape.surfaces``.

    Hexahedra and quadrilaterals lie between ``breaks`` (m, degrees), with ``layers`` of cells
    towards ``edges``; each is divided into six tetrahedra or two triangles, or the mesh is
    unstructured of target edge length ``size`` (m): gmsh must not be in use then. Curved cells are
    polynomials through the Gauss-Lobatto points of the circles. Crowned faces pass through all
    nodes, and are exact on straight bases from order 2.
    """
    base = shape.base if isinstance(shape, Crowned) else shape
    if size is not None:
        from meshes.unstructured import outline_mesh  # brings in gmsh

        mesh = outline_mesh(base, order, size)
        mesh = _through_lobatto_points(base, mesh) if order > 2 else mesh
    else:
        mesh = structured_mesh(base, breaks or (), order, edges, layers)
        mesh = divided(mesh) if cell in SIMPLICES else mesh
    points = shape.crown(mesh.points) if isinstance(shape, Crowned) else mesh.points
    return replace(mesh, points=placement.apply(points))


def lobatto(order: int) -> Floats:
    """Gauss-Lobatto points of the unit interval, ends included, shape (order + 1,)."""
    inner = roots_jacobi(order - 1, 1, 1)[0] if order > 1 else np.empty(0)
    return (np.concatenate([[-1.0], inner, [1.0]]) + 1) / 2


def interpolate_arc(angles: Floats, order: int) -> Floats:
    """Nodes of polynomial arcs of a given order that interpolate the unit circle."""
    between = angles[:-1, None] + np.diff(angles)[:, None] * lobatto(order)
    circle = np.stack([np.cos(between), np.sin(between)], axis=-1)
    if order > 2:
        nodes = np.arange(order + 1)[:, None] / order
        circle = np.einsum("ij,njd->nid", _change(lobatto(order)[:, None], nodes, order), circle)
    return np.concatenate([circle[:, :-1].reshape(-1, 2), circle[-1, -1:]])


def simplex_changes(equispaced: Floats, order: int) -> tuple[Floats, Floats]:
    """Matrices from values at equispaced nodes of a simplex to Lobatto-like ones, and back.

    The Lobatto-like node of index (i, j, ..) has barycentric coordinates (g_i, g_j, ..) / sum with
    g the Lobatto points of the interval: on each edge they are those points, and nodes on a face
    depend on the face alone.
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


def _through_lobatto_points(shape: Shape, mesh: Mesh) -> Mesh:
    """Mesh whose cells interpolate circles at Gauss-Lobatto points instead of their nodes."""
    to_lobatto, back = simplex_changes(reference_nodes(mesh.cell, mesh.order), mesh.order)
    radius = np.zeros(len(mesh.points))
    for name, value in round_surfaces(shape).items():
        radius[mesh.surfaces[name]] = value
    curved = mesh.cells[radius[mesh.cells].any(axis=1)]
    lobatto = mesh.points.copy()
    lobatto[curved] = to_lobatto @ mesh.points[curved]
    on = radius > 0
    lobatto[on, :2] *= (radius[on] / np.linalg.norm(lobatto[on, :2], axis=1))[:, None]
    points = mesh.points.copy()
    points[curved] = back @ lobatto[curved]
    return replace(mesh, points=points)


def structured_mesh(
    shape: Shape, breaks: Breaks, order: int, edges: Sequence[Edge] = (), layers: int = 0
) -> Mesh:
    """Mesh a shape with one cell between neighbouring breaks, and layers at edges."""
    check_breaks(shape, breaks)
    dim = len(shape.directions)
    blocks, faces = _blocks(shape, breaks, order)
    every = np.concatenate([block.reshape(-1, dim) for block in blocks])
    first = first_of_near(every, SAME * shortest_step(blocks, range(dim)))
    used, number = np.unique(first, return_inverse=True)
    ends = np.cumsum([block[..., 0].size for block in blocks])[:-1]
    parts = zip(np.split(number, ends), blocks, strict=True)
    nodes = [part.reshape(block.shape[:-1]) for part, block in parts]
    facets = {
        name: np.concatenate(
            [_cells(np.take(nodes[k], -side, axis), order) for k, axis, side in on]
        )
        for name, on in faces.items()
    }
    mesh = Mesh(
        cell="quadrilateral" if dim == 2 else "hexahedron",
        order=order,
        points=every[used],
        cells=np.concatenate([_cells(node, order) for node in nodes]),
        surfaces=facets,
    )
    return with_layers(mesh, shape, edges, layers) if edges and layers else mesh


def _cells(nodes: Ints, order: int) -> Ints:
    """Nodes of the cells of a lattice, (n_cells, n_nodes)."""
    windows = sliding_window_view(nodes, (order + 1,) * nodes.ndim)
    return windows[(slice(None, None, order),) * nodes.ndim].reshape(-1, (order + 1) ** nodes.ndim)


def _blocks(shape: Shape, breaks: Breaks, order: int) -> tuple[list[Floats], Faces]:
    """Nodes (m) on the lattice of each block of a shape, (n1, ..., dim), and its named faces.

    Inner nodes of a ring also lie on the circle of their lattice line.
    """
    if isinstance(shape, Disc):
        flat, faces = _disc(shape, breaks, order)
        return [_extruded(each, breaks[2:], order) for each in flat], faces
    blocks, faces = blocks_of(shape, breaks)
    plane = _grid if isinstance(shape, Box | Rectangle) else _arcs
    return [_extruded(plane(x, y, order), z, order) for x, y, *z in blocks], faces


def _divided(line: Floats, order: int) -> Floats:
    """Breaks with each interval divided in ``order`` equal parts."""
    parts = line[:-1, None] + np.diff(line)[:, None] * np.arange(order) / order
    return np.append(parts.ravel(), line[-1])


def _grid(x: Floats, y: Floats, order: int) -> Floats:
    """Nodes (m) between breaks of the plane."""
    grid = np.meshgrid(_divided(x, order), _divided(y, order), indexing="ij")
    return np.stack(grid, axis=-1)


def _arcs(radii: Floats, angles: Floats, order: int) -> Floats:
    """Nodes (m) between radii and angles (degrees)."""
    return _divided(radii, order)[:, None, None] * interpolate_arc(np.radians(angles), order)


def _extruded(plane: Floats, heights: Sequence[Floats], order: int) -> Floats:
    """Extrude a plane block between heights; return it unchanged if there are none."""
    for line in heights:
        z = _divided(line, order)
        points = np.empty((*plane.shape[:2], len(z), 3))
        points[..., :2], points[..., 2] = plane[:, :, None], z
        return points
    return plane


def _disc(shape: Disc, breaks: Breaks, order: int) -> tuple[list[Floats], Faces]:
    """Blocks of a disc in the plane: a square in its middle, and four from its sides to the rim.

    The corners of the square lie on the circle of the break nearest to half the radius. The square
    is divided like the quarters, and replaces the breaks along r inside that circle; outside of it
    lattice lines change from straight to round. Parallel edges run the same way in all blocks.
    """
    radii, angles = breaks[0], breaks[1]
    allowed = "at least two elements, of which one is the square"
    require(len(radii) > 2, "breaks of r", radii, allowed)
    quarter = np.searchsorted(angles, np.array([0.0, 90.0, 180.0, 270.0, 360.0]) - 1e-9)
    sides = np.diff(quarter)
    matching = sides[0] == sides[2] and sides[1] == sides[3]
    allowed = "as many in a quarter of a disc as in the opposite one"
    require(bool(matching), "breaks of theta", angles, allowed)
    core = 1 + int(np.abs(radii[1:-1] - shape.outer_radius / 2).argmin())
    corner = radii[core]
    lines = [angles[start : stop + 1] for start, stop in pairwise(quarter)]

    # Share of its side of the square at each lattice line of a quarter.
    shares = []
    for each in lines:
        line = _divided(each, order)
        shares.append((line - line[0]) / (line[-1] - line[0]))
    below, above = shares[0][:, None], 1 - shares[2][::-1, None]
    left, right = 1 - shares[3][::-1], shares[1]
    # Intersection of the line from side 0 to side 2 with that from side 1 to side 3.
    du, dv = above - below, right - left
    u = (below + left * du) / (1 - du * dv)
    v = left + u * dv
    square = corner * np.stack([1 - u - v, u - v], axis=-1)

    along = (_divided(radii[core:], order) - corner) / (shape.outer_radius - corner)
    arcs = [shape.outer_radius * interpolate_arc(np.radians(each), order) for each in lines]
    rim = arcs[0], arcs[1], arcs[2][::-1], arcs[3][::-1]
    inner = square[:, 0], square[-1], square[:, -1], square[0]
    ring = [a + along[:, None, None] * (b - a) for a, b in zip(inner, rim, strict=True)]
    ends = {side: tuple((block, 2, side) for block in range(5)) for side in (0, 1)}
    outer = tuple((block, 0, 1) for block in range(1, 5))
    return [square, *ring], {"outer": outer, "bottom": ends[0], "top": ends[1]}


_SIMPLEX: dict[Cell, Cell] = {"quadrilateral": "triangle", "hexahedron": "tetrahedron"}


def divided(mesh: Mesh) -> Mesh:
    """Divide quadrilaterals into two triangles or hexahedra into six tetrahedra on their nodes.

    Parallel edges run the same way in all cells, so that neighbours divide their face alike.
    """
    require(mesh.cell in _SIMPLEX, "cell", mesh.cell, f"one of {', '.join(_SIMPLEX)}")
    cells, surfaces = _split(mesh.cells, mesh.dim, mesh.order), mesh.surfaces
    if mesh.dim == 3:
        surfaces = {name: _split(part, 2, mesh.order) for name, part in surfaces.items()}
    return Mesh(_SIMPLEX[mesh.cell], mesh.order, mesh.points, cells, surfaces)


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
