"""Unstructured meshes by gmsh: plane outlines, swept outlines, and ventilated discs."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import pi
from typing import Any

import gmsh
import numpy as np

from cea.errors import InputError
from cea.files import ignore_closed_pipes
from cea.mesh import Mesh
from meshes.files.gmsh import arrays_of_model, content_of
from meshes.files.part import body_mesh, part_of
from meshes.files.surfaces import surface_faces
from meshes.shapes import (
    Box,
    Hub,
    Rectangle,
    RingSector,
    Sector,
    Shape,
    VentilatedDisc,
    round_surfaces,
)
from meshes.true_surfaces import true_surfaces

_AROUND = 12
"""Least number of elements around each hole."""
_CORNER = 0.4
"""Size of elements at the re-entrant corners of the hat, relative to the target size: stresses are
singular there, and all modes bend the corners."""
_GROWTH = 0.3
"""Increase of the size of elements per distance from features that need small ones."""
_SAME = 1e-6
"""Distance, relative to the outer radius, below which a face lies on a surface."""


@contextmanager
def gmsh_session() -> Iterator[None]:
    """Start gmsh, silent and on one thread, and end it when the block is left."""
    if gmsh.isInitialized():
        raise RuntimeError("gmsh is already in use: call gmsh.finalize() before the next mesh")
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    ignore_closed_pipes()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield
    finally:
        gmsh.finalize()


def read_gmsh(model: Any) -> Mesh:
    """Mesh of a gmsh model whose cells are all of one kind."""
    content = content_of(arrays_of_model(model))
    groups = model.getPhysicalGroups(content.dim - 1) if content.dim else ()
    names = [model.getPhysicalName(*group) for group in groups]
    part, sets = part_of(content, "the model", None), {n: (f"elements:{n}",) for n in names if n}
    faces = {name: on for name, (on, _) in surface_faces(content, part, sets).items()}
    return body_mesh(content, part, faces)


def outline_mesh(shape: Shape, order: int, size: float) -> Mesh:
    """Mesh a shape with triangles or tetrahedra."""
    dim = len(shape.directions)
    with gmsh_session():
        gmsh.model.add(shape.shape)
        if isinstance(shape, VentilatedDisc):
            surfaces = _ventilated_disc(shape)
            _refine(shape, size)
        else:
            surfaces = _revolved_hub(shape) if isinstance(shape, Hub) else _extruded(shape)
        _generate(dim, order, size)
        for name, entities in surfaces.items():
            gmsh.model.addPhysicalGroup(dim - 1, entities, name=name)
        gmsh.model.addPhysicalGroup(dim, [tag for _, tag in gmsh.model.getEntities(dim)])
        return read_gmsh(gmsh.model)


def _generate(dim: int, order: int, size: float) -> None:
    """Mesh the current model."""
    finer = len(gmsh.model.mesh.field.list()) > 0
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.0 if finer else size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.generate(dim)
    if order > 1:
        # Nodes on arcs are put on them exactly. A cell with two facets on one circle is flat along
        # their common edge: the optimiser moves the nodes that such cells share.
        gmsh.model.mesh.setOrder(order)
        gmsh.model.mesh.optimize("HighOrder")
        (cells,) = gmsh.model.mesh.getElements(dim)[1]
        if gmsh.model.mesh.getElementQualities(cells, "minSJ").min() <= 0:
            allowed = "a smaller size (m): curved cells of this size are inverted"
            raise InputError("size", size, allowed)


def _revolved_hub(shape: Hub) -> dict[str, list[int]]:
    """Add hub and ring, a profile revolved about z, to the model; return faces by surface."""
    profile = {  # a hub that ends flush with the ring has no side there: equal corners are one key
        (shape.bore, shape.hub_bottom): "hub_bottom",
        (shape.hub_radius, shape.hub_bottom): "hub_side",
        (shape.hub_radius, shape.bottom): "bottom",
        (shape.outer_radius, shape.bottom): "outer",
        (shape.outer_radius, shape.top): "top",
        (shape.hub_radius, shape.top): "hub_side",
        (shape.hub_radius, shape.hub_top): "hub_top",
        (shape.bore, shape.hub_top): "bore",
    }
    swept = _revolved(list(profile))
    gmsh.model.occ.synchronize()
    _, _, *walls = swept  # the profile, the volume, then the walls swept by its edges
    surfaces: dict[str, list[int]] = {name: [] for name in shape.surfaces}
    for name, (_, tag) in zip(profile.values(), walls, strict=True):
        surfaces[name].append(tag)
    return surfaces


_Edge = tuple[str, tuple[float, float], bool]
"""Edge of an outline: the surface it sweeps, its first point (m), whether it is an arc."""


def _extruded(shape: Shape) -> dict[str, list[int]]:
    """Add the outline of a shape to the model, extruded in space; return entities by surface."""
    low, high = shape.extent[2] if len(shape.directions) == 3 else (0.0, 0.0)
    loops = _loops(shape)
    geo = gmsh.model.geo
    centre = geo.addPoint(0, 0, low)
    surfaces: dict[str, list[int]] = {name: [] for name in shape.surfaces}
    loop_tags, curves = [], []
    for loop in loops:
        points = [geo.addPoint(*start, low) for _, start, _ in loop]
        around = [
            geo.addCircleArc(a, centre, b) if arc else geo.addLine(a, b)
            for (*_, arc), a, b in zip(loop, points, points[1:] + points[:1], strict=True)
        ]
        loop_tags.append(geo.addCurveLoop(around))
        curves += around
    base = geo.addPlaneSurface(loop_tags)
    walls = curves
    if high > low:
        (_, top), _, *swept = geo.extrude([(2, base)], 0, 0, high - low)
        walls = [tag for _, tag in swept]
        ends = ("z_min", "z_max") if isinstance(shape, Box) else ("bottom", "top")
        for name, tag in zip(ends, (base, top), strict=True):
            surfaces[name].append(tag)
    for (name, *_), tag in zip([edge for loop in loops for edge in loop], walls, strict=True):
        surfaces[name].append(tag)
    geo.synchronize()
    # Centres of arcs would be meshed as nodes of no cell.
    loose = [p for p in gmsh.model.getEntities(0) if not len(gmsh.model.getAdjacencies(*p)[0])]
    gmsh.model.removeEntities(loose)
    return surfaces


def _loops(shape: Shape) -> list[list[_Edge]]:
    """Closed loops of the outline of a shape in the plane."""
    if isinstance(shape, Box | Rectangle):
        (x0, x1), (y0, y1) = shape.extent[:2]
        corners = {"y_min": (x0, y0), "x_max": (x1, y0), "y_max": (x1, y1), "x_min": (x0, y1)}
        return [[(name, corner, False) for name, corner in corners.items()]]

    def point(radius: float, degrees: float) -> tuple[float, float]:
        angle = np.radians(degrees)
        return float(radius * np.cos(angle)), float(radius * np.sin(angle))

    if isinstance(shape, Sector | RingSector):
        return [
            [
                ("outer", point(shape.outer_radius, shape.start), True),
                ("end", point(shape.outer_radius, shape.end), False),
                ("inner", point(shape.inner_radius, shape.end), True),
                ("start", point(shape.inner_radius, shape.start), False),
            ]
        ]
    radii = sorted(round_surfaces(shape).items(), key=lambda item: -item[1])
    return [
        [(name, point(radius, angle), True) for angle in (0, 90, 180, 270)]
        for name, radius in radii
    ]


def _ventilated_disc(shape: VentilatedDisc) -> dict[str, list[int]]:
    """Add the disc to the model as one solid; return faces by surface."""
    occ = gmsh.model.occ
    profile = [
        (shape.bore, shape.hub_bottom),
        (shape.bore, shape.hub_top),
        (shape.wall_outer, shape.hub_top),
        (shape.wall_outer, shape.ring_height),
        (shape.outer_radius, shape.ring_height),
        (shape.outer_radius, 0.0),
        (shape.wall_inner, 0.0),
        (shape.wall_inner, shape.hub_bottom),
    ]
    inner, outer = shape.flange_outer, shape.outer_radius

    def ring(bottom: float, top: float) -> tuple[int, int]:
        return _revolved([(inner, bottom), (outer, bottom), (outer, top), (inner, top)])[1]

    lower, upper = _revolved(profile)[1], ring(shape.upper_bottom, shape.upper_top)
    bottom, width = shape.ring_height, shape.vane_width
    boxes = []  # around the rays of the vanes, cut to the space between the rings below
    for angle in shape.vane_angles:
        box = occ.addBox(0, -width / 2, bottom, 2 * outer, width, shape.upper_bottom - bottom)
        occ.rotate([(3, box)], 0, 0, 0, 0, 0, 1, angle)
        boxes.append((3, box))
    vanes, _ = occ.intersect(boxes, [ring(bottom, shape.upper_bottom)])
    solid, _ = occ.fuse([lower], [upper, *vanes])
    if shape.holes:
        height = shape.hub_top - shape.hub_bottom
        holes = [
            (3, occ.addCylinder(x, y, shape.hub_bottom, 0, 0, height, shape.hole_radius))
            for x, y in shape.hole_centres
        ]
        occ.cut(solid, holes)
    occ.synchronize()
    return _faces_of_disc(shape)


def _refine(shape: VentilatedDisc, size: float) -> None:
    """Limit the sizes of elements of the current model near features.

    Near the wall of the hat elements are no longer than its thickness, and at least twelve go
    around a hole, whatever ``size`` (m); at the corners where the wall meets flange and plate they
    are a fraction of ``size``. Away from there they grow to ``size``.
    """
    middle = (shape.wall_inner + shape.wall_outer) / 2
    thickness = shape.wall_outer - shape.wall_inner
    near = [(min(size, thickness), f"Fabs(Sqrt(x*x+y*y)-{middle!r})")]
    around = min(size, 2 * pi * shape.hole_radius / _AROUND)
    for x, y in shape.hole_centres:
        arm = f"Sqrt((x-({x!r}))^2+(y-({y!r}))^2)"
        near.append((around, f"Fabs({arm}-{shape.hole_radius!r})"))
    corners = (shape.wall_outer, shape.ring_height), (shape.wall_inner, shape.hub_bottom)
    for r, z in corners:
        near.append((_CORNER * size, f"Sqrt((Sqrt(x*x+y*y)-{r!r})^2+(z-{z!r})^2)"))
    field = gmsh.model.mesh.field
    tags = [field.add("MathEval") for _ in near]
    for tag, (least, distance) in zip(tags, near, strict=True):
        field.setString(tag, "F", f"{least!r}+{_GROWTH}*{distance}")
    smallest = field.add("Min")
    field.setNumbers(smallest, "FieldsList", tags)
    field.setAsBackgroundMesh(smallest)


def _revolved(profile: Sequence[tuple[float, float]]) -> list[tuple[int, int]]:
    """Revolve a profile of corners (r, z) about z; return the profile, the solid, its walls."""
    occ = gmsh.model.occ
    points = [occ.addPoint(r, 0, z) for r, z in profile]
    following = points[1:] + points[:1]
    lines = [occ.addLine(a, b) for a, b in zip(points, following, strict=True)]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    swept = occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, 2 * np.pi)
    occ.remove([(2, face)], recursive=True)
    return list(swept)


def _faces_of_disc(shape: VentilatedDisc) -> dict[str, list[int]]:
    """Faces of the model by surface, identified by sample points."""
    levels = {"lower_face": 0.0, "upper_face": shape.upper_top, "hub_top": shape.hub_top}
    found: dict[str, list[int]] = {name: [] for name in shape.surfaces}
    for _, tag in gmsh.model.getEntities(2):
        (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, tag)
        grid = np.meshgrid(np.linspace(u0, u1, 5), np.linspace(v0, v1, 5))  # some beyond its edges
        x = np.reshape(gmsh.model.getValue(2, tag, np.stack(grid, axis=-1).ravel()), (-1, 3))
        for name, surface in true_surfaces(shape).items():
            height = x[:, 2] - levels[name] if surface.height is None else surface.height(x)[0]
            if np.abs(height).max() < _SAME * shape.outer_radius:
                found[name].append(tag)
    return found
