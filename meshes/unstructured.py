"""Unstructured meshes by gmsh: triangles in an outline, tetrahedra in what it sweeps."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

import gmsh
import numpy as np

from cea.errors import InputError
from cea.mesh import Mesh, reference_nodes
from cea.signals import ignore_closed_pipes
from meshes.files.body import body_mesh
from meshes.files.gmsh import arrays_of_model, content_of
from meshes.files.part import part_of
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
from meshes.structured import simplex_changes
from meshes.ventilated_disc_model import build_ventilated_disc, refine, revolved


@contextmanager
def gmsh_session() -> Iterator[None]:
    """Start gmsh, silent and on one thread, and end it when the block is left."""
    if gmsh.isInitialized():
        raise RuntimeError("gmsh is in use already: end it before the next mesh")
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    ignore_closed_pipes()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield
    finally:
        gmsh.finalize()


def read_gmsh(model: Any) -> Mesh:
    """Mesh of a gmsh model whose cells are all of one kind.

    Parameters
    ----------
    model
        Meshed gmsh model of order 1 to 4; its named physical groups of one dimension less than its
        cells are the surfaces.

    Raises
    ------
    InputError
        When there are no cells, or of several kinds, or they are none of a mesh.
    """
    content = content_of(arrays_of_model(model))
    groups = model.getPhysicalGroups(content.dim - 1) if content.dim else ()
    names = [model.getPhysicalName(*group) for group in groups]
    faces = {name: (f"elements:{name}",) for name in names if name}
    return body_mesh(content, part_of(content, "the model", None), faces)


def outline_mesh(shape: Shape, order: int, size: float) -> Mesh:
    """Mesh a shape with triangles or tetrahedra."""
    with gmsh_session():
        gmsh.model.add(shape.shape)
        surfaces = _built(shape, size)
        _generate(len(shape.directions), order, size)
        _name(len(shape.directions), surfaces)
        mesh = read_gmsh(gmsh.model)
    return _through_lobatto_points(shape, mesh) if order > 2 else mesh


def _built(shape: Shape, size: float) -> dict[str, list[int]]:
    """A shape in the current model; entities of each surface."""
    if isinstance(shape, VentilatedDisc):
        surfaces = build_ventilated_disc(shape)
        refine(shape, size)
        return surfaces
    return _revolved_hub(shape) if isinstance(shape, Hub) else _extruded(shape)


def _generate(dim: int, order: int, size: float) -> None:
    """Mesh the current model."""
    finer = len(gmsh.model.mesh.field.list()) > 0
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.0 if finer else size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.generate(dim)
    if order > 1:
        # Nodes on arcs are put on them exactly. A cell with two facets on one circle is flat along
        # their common edge: the optimiser moves what such cells share.
        gmsh.model.mesh.setOrder(order)
        gmsh.model.mesh.optimize("HighOrder")
        (cells,) = gmsh.model.mesh.getElements(dim)[1]
        if gmsh.model.mesh.getElementQualities(cells, "minSJ").min() <= 0:
            raise InputError("size", size, "less (m): curved cells of that size are inverted")


def _name(dim: int, surfaces: Mapping[str, list[int]]) -> None:
    """Physical groups of the current model: its surfaces by name, and all cells."""
    for name, entities in surfaces.items():
        gmsh.model.addPhysicalGroup(dim - 1, entities, name=name)
    gmsh.model.addPhysicalGroup(dim, [tag for _, tag in gmsh.model.getEntities(dim)])


def _through_lobatto_points(shape: Shape, mesh: Mesh) -> Mesh:
    """Mesh whose cells meet the circles at Gauss-Lobatto points rather than at their nodes."""
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


def _revolved_hub(shape: Hub) -> dict[str, list[int]]:
    """Hub and ring in the current model, a profile turned about z; entities of each surface."""
    profile = [
        ("hub_bottom", shape.bore, shape.hub_bottom),
        ("hub_side", shape.hub_radius, shape.hub_bottom),
        ("bottom", shape.hub_radius, shape.bottom),
        ("outer", shape.outer_radius, shape.bottom),
        ("top", shape.outer_radius, shape.top),
        ("hub_side", shape.hub_radius, shape.top),
        ("hub_top", shape.hub_radius, shape.hub_top),
        ("bore", shape.bore, shape.hub_top),
    ]
    following = [corner[1:] for corner in profile[1:] + profile[:1]]
    edges = [
        corner
        for corner, end in zip(profile, following, strict=True)
        if corner[1:] != end  # a hub that ends flush with the ring has no side there
    ]
    swept = revolved([corner[1:] for corner in edges])
    gmsh.model.occ.synchronize()
    _, _, *walls = swept  # the profile itself again, the volume, then what its edges sweep
    surfaces: dict[str, list[int]] = {name: [] for name in shape.surfaces}
    for (name, _, _), (_, tag) in zip(edges, walls, strict=True):
        surfaces[name].append(tag)
    return surfaces


class _Edge(NamedTuple):
    """Edge of an outline: the surface it sweeps, its first point (m), arc or straight line."""

    surface: str
    start: tuple[float, float]
    arc: bool = False


def _extruded(shape: Shape) -> dict[str, list[int]]:
    """Outline of a shape in the current model, swept along z in space; entities by surface."""
    low, high = shape.extent[2] if len(shape.directions) == 3 else (0.0, 0.0)
    loops = _loops(shape)
    geo = gmsh.model.geo
    centre = geo.addPoint(0, 0, low)
    surfaces: dict[str, list[int]] = {name: [] for name in shape.surfaces}
    loop_tags, curves = [], []
    for loop in loops:
        points = [geo.addPoint(*edge.start, low) for edge in loop]
        around = [
            geo.addCircleArc(a, centre, b) if edge.arc else geo.addLine(a, b)
            for edge, a, b in zip(loop, points, points[1:] + points[:1], strict=True)
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
    for edge, tag in zip([edge for loop in loops for edge in loop], walls, strict=True):
        surfaces[edge.surface].append(tag)
    geo.synchronize()
    # Centres of arcs would be meshed as nodes of no cell.
    loose = [p for p in gmsh.model.getEntities(0) if not len(gmsh.model.getAdjacencies(*p)[0])]
    gmsh.model.removeEntities(loose)
    return surfaces


def _loops(shape: Shape) -> list[list[_Edge]]:
    """Closed loops of the outline of a shape in the plane."""
    if isinstance(shape, Box | Rectangle):
        (x0, x1), (y0, y1) = shape.extent[:2]
        loop = [
            _Edge("y_min", (x0, y0)),
            _Edge("x_max", (x1, y0)),
            _Edge("y_max", (x1, y1)),
            _Edge("x_min", (x0, y1)),
        ]
        return [loop]

    def point(radius: float, degrees: float) -> tuple[float, float]:
        angle = np.radians(degrees)
        return float(radius * np.cos(angle)), float(radius * np.sin(angle))

    if isinstance(shape, Sector | RingSector):
        loop = [
            _Edge("outer", point(shape.outer_radius, shape.start), arc=True),
            _Edge("end", point(shape.outer_radius, shape.end)),
            _Edge("inner", point(shape.inner_radius, shape.end), arc=True),
            _Edge("start", point(shape.inner_radius, shape.start)),
        ]
        return [loop]
    radii = sorted(round_surfaces(shape).items(), key=lambda item: -item[1])
    return [
        [_Edge(name, point(radius, angle), arc=True) for angle in (0, 90, 180, 270)]
        for name, radius in radii
    ]
