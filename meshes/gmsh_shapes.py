"""Gmsh meshes of the shapes: structured hexahedra between breaks, unstructured tetrahedra."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal, NamedTuple

import gmsh
import numpy as np
from numpy.typing import NDArray

from meshes.breaks import Breaks, Floats
from meshes.errors import require
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Shape

Ints = NDArray[np.int64]

MAX_GEOMETRY_ORDER = 2
"""Highest order of the geometry that is built."""

_IN_PLACE = Placement()


@contextmanager
def gmsh_mesh(
    shape: Shape,
    cell: Literal["tetrahedron", "hexahedron"],
    order: int,
    *,
    breaks: Breaks | None = None,
    size: float | None = None,
    placement: Placement = _IN_PLACE,
    comm: Any = None,
) -> Iterator[Any]:
    """Mesh a shape with gmsh, and end gmsh when the block is left.

    Second-order nodes lie on the circles of the shape: 10-node tetrahedra, 27-node hexahedra. The
    physical surfaces bear the names ``shape.surfaces``; the one physical volume is ``volume``.

    Parameters
    ----------
    shape
        The shape.
    cell
        ``hexahedron``: one element per cell of the breaks; ``tetrahedron``: unstructured.
    order
        Order of the geometry, 1 or 2.
    breaks
        Element boundaries of hexahedra along the directions of the shape (m, degrees).
    size
        Target edge length of tetrahedra (m).
    placement
        Where the shape is put.
    comm
        MPI communicator (mpi4py): gmsh runs on its rank 0 only; None runs it on every caller.

    Yields
    ------
    gmsh.model
        The model; on ranks other than 0 it is empty, and only there to be passed on.

    Raises
    ------
    ValueError
        When the input is refused.
    RuntimeError
        When gmsh is in use already, or fails.
    """
    _check(shape, cell, order, breaks, size)
    here = comm is None or comm.rank == 0
    failure: Exception | None = None
    if here:
        if gmsh.isInitialized():
            raise RuntimeError("gmsh is in use already: leave one gmsh_mesh before the next")
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        if here:
            try:
                _build(shape, order, breaks, size, placement)
            except Exception as error:
                failure = error
        if comm is not None:
            # Told to every rank, so that none waits for a mesh that never comes.
            failure = comm.bcast(failure, root=0)
        if failure is not None:
            raise failure
        yield gmsh.model
    finally:
        if here:
            gmsh.finalize()


def _check(shape: Shape, cell: str, order: int, breaks: Breaks | None, size: float | None) -> None:
    require(cell in ("tetrahedron", "hexahedron"), "cell", cell, "tetrahedron or hexahedron")
    require(1 <= order <= MAX_GEOMETRY_ORDER, "order", order, f"1 to {MAX_GEOMETRY_ORDER}")
    if cell == "tetrahedron":
        require(size is not None and 0 < size < np.inf, "size", size, "a positive length (m)")
        require(breaks is None, "breaks", breaks, "None: tetrahedra are unstructured")
        return
    require(size is None, "size", size, "None: hexahedra follow the breaks")
    if breaks is None or len(breaks) != 3:
        raise ValueError(f"breaks = {breaks!r}: three arrays, along {', '.join(shape.directions)}")
    for name, values, (low, high) in zip(shape.directions, breaks, shape.extent, strict=True):
        rising = len(values) > 1 and bool((np.diff(values) > 0).all())
        require(
            rising and bool(np.isclose([values[0], values[-1]], [low, high], rtol=1e-12).all()),
            f"breaks of {name}",
            values,
            f"rising, from {low} to {high}",
        )
    if shape.directions[1] == "theta":
        step = float(np.diff(breaks[1]).max())
        require(step < 180, "breaks of theta", step, "less than 180 degrees apart")


def _build(
    shape: Shape, order: int, breaks: Breaks | None, size: float | None, placement: Placement
) -> None:
    """Fill the current gmsh model with the placed mesh."""
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.model.add(shape.shape)
    if breaks is not None:
        volume, surfaces = _structured(shape, breaks, order)
    else:
        volume, surfaces = _unstructured(shape, order, size)
    for name, tags in surfaces.items():
        gmsh.model.addPhysicalGroup(2, tags, name=name)
    gmsh.model.addPhysicalGroup(3, [volume], name="volume")
    matrix = np.column_stack([placement.rotation, placement.translation])
    gmsh.model.mesh.affineTransform(matrix.ravel())


def _structured(shape: Shape, breaks: Breaks, order: int) -> tuple[int, dict[str, list[int]]]:
    """Hexahedra on the lattice of the breaks and, at second order, their midpoints.

    The lattice is mapped node by node, so every node of a ring, inside too, lies at the radius and
    angle of its lattice line. Gmsh gets it as a discrete model: its own transfinite mesher would
    need one entity per break cell to follow uneven breaks.
    """
    lines = [_with_midpoints(np.asarray(b, dtype=float), order) for b in breaks]
    closed = isinstance(shape, Annulus)
    if closed:
        lines[1] = lines[1][:-1]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    node = np.arange(1, grid[..., 0].size + 1).reshape(grid.shape[:3])
    first = node.ravel()
    if closed:
        node = np.concatenate([node, node[:, :1]], axis=1)

    mesh = gmsh.model.mesh
    quadrangle = mesh.getElementType("Quadrangle", order)
    hexahedron = mesh.getElementType("Hexahedron", order)
    sides = [(d, side) for d in ((0, 2) if closed else (0, 1, 2)) for side in (0, -1)]
    surfaces = {name: [gmsh.model.addDiscreteEntity(2)] for name in shape.surfaces}
    volume = gmsh.model.addDiscreteEntity(3, boundary=[tag for (tag,) in surfaces.values()])
    mesh.addNodes(3, volume, first, _cartesian(shape, grid.reshape(-1, 3)).ravel())
    for (tag,), (direction, side) in zip(surfaces.values(), sides, strict=True):
        facets = _cells(np.take(node, side, axis=direction), quadrangle, order)
        mesh.addElementsByType(tag, quadrangle, [], facets.ravel())
    mesh.addElementsByType(volume, hexahedron, [], _cells(node, hexahedron, order).ravel())
    mesh.reclassifyNodes()
    return volume, surfaces


def _with_midpoints(line: Floats, order: int) -> Floats:
    """Breaks with each interval divided in ``order`` equal parts."""
    parts = line[:-1, None] + np.diff(line)[:, None] * np.arange(order) / order
    return np.append(parts.ravel(), line[-1])


def _cartesian(shape: Shape, points: Floats) -> Floats:
    """Cartesian coordinates (m) of points in the coordinates of a shape, (n, 3)."""
    if isinstance(shape, Box):
        return points
    r, theta, z = points.T
    angle = np.radians(theta)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])


def _cells(node: Ints, element_type: int, order: int) -> Ints:
    """Nodes of the cells of a lattice, in gmsh's order, (n_cells, n_nodes)."""
    _, dim, _, _, local, _ = gmsh.model.mesh.getElementProperties(element_type)
    offsets = np.rint((np.reshape(local, (-1, dim)) + 1) / 2 * order).astype(int)
    corners = np.meshgrid(*(np.arange(0, n - 1, order) for n in node.shape), indexing="ij")
    index = [c.reshape(-1, 1) + offsets[:, d] for d, c in enumerate(corners)]
    return node[tuple(index)]


def _unstructured(shape: Shape, order: int, size: float | None) -> tuple[int, dict[str, list[int]]]:
    """Tetrahedra in the outline of the shape extruded along z."""
    bottom, height, loops = _outline(shape)
    geo = gmsh.model.geo
    centre = geo.addPoint(0, 0, bottom)
    names = [edge.surface for loop in loops for edge in loop]
    loop_tags = []
    for loop in loops:
        points = [geo.addPoint(*edge.start, bottom) for edge in loop]
        curves = [
            geo.addCircleArc(a, centre, b) if edge.arc else geo.addLine(a, b)
            for edge, a, b in zip(loop, points, points[1:] + points[:1], strict=True)
        ]
        loop_tags.append(geo.addCurveLoop(curves))
    base = geo.addPlaneSurface(loop_tags)
    (_, top), (_, volume), *walls = geo.extrude([(2, base)], 0, 0, height)
    geo.synchronize()
    # Centres of arcs would be meshed as nodes of no cell.
    loose = [p for p in gmsh.model.getEntities(0) if not len(gmsh.model.getAdjacencies(*p)[0])]
    gmsh.model.removeEntities(loose)

    low, high = ("z_min", "z_max") if isinstance(shape, Box) else ("bottom", "top")
    surfaces: dict[str, list[int]] = {name: [] for name in shape.surfaces}
    for name, tag in zip([low, high, *names], [base, top, *(w for _, w in walls)], strict=True):
        surfaces[name].append(tag)

    for option in ("MeshSizeMin", "MeshSizeMax"):
        gmsh.option.setNumber(f"Mesh.{option}", size)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.generate(3)
    if order == 2:
        # Nodes on an extruded arc are put on it exactly. A tetrahedron with two faces on one
        # cylinder is flat along their common edge: the optimiser moves what such cells share.
        gmsh.model.mesh.setOrder(2)
        gmsh.model.mesh.optimize("HighOrder")
        _, (cells,), _ = gmsh.model.mesh.getElements(3)
        if gmsh.model.mesh.getElementQualities(cells, "minSJ").min() <= 0:
            raise RuntimeError(f"size = {size} m leaves inverted curved tetrahedra: take less")
    return volume, surfaces


class _Edge(NamedTuple):
    """Edge of an outline: the surface it sweeps, its first point (m), arc or straight line."""

    surface: str
    start: tuple[float, float]
    arc: bool = False


def _outline(shape: Shape) -> tuple[float, float, list[list[_Edge]]]:
    """Bottom and height (m) of a shape and the closed loops of its outline in the plane."""
    if isinstance(shape, Box):
        (x0, x1), (y0, y1), (z0, z1) = shape.extent
        loop = [
            _Edge("y_min", (x0, y0)),
            _Edge("x_max", (x1, y0)),
            _Edge("y_max", (x1, y1)),
            _Edge("x_min", (x0, y1)),
        ]
        return z0, z1 - z0, [loop]

    def point(radius: float, degrees: float) -> tuple[float, float]:
        angle = np.radians(degrees)
        return float(radius * np.cos(angle)), float(radius * np.sin(angle))

    radii = {"outer": shape.outer_radius, "inner": shape.inner_radius}
    height = shape.top - shape.bottom
    if isinstance(shape, Annulus):
        rings = [
            [_Edge(name, point(radius, angle), arc=True) for angle in (0, 90, 180, 270)]
            for name, radius in radii.items()
        ]
        return shape.bottom, height, rings
    loop = [
        _Edge("outer", point(shape.outer_radius, shape.start), arc=True),
        _Edge("end", point(shape.outer_radius, shape.end)),
        _Edge("inner", point(shape.inner_radius, shape.end), arc=True),
        _Edge("start", point(shape.inner_radius, shape.start)),
    ]
    return shape.bottom, height, [loop]
