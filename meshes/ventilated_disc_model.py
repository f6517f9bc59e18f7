"""The ventilated disc as a solid in gmsh, and how fine it is meshed where."""

from collections.abc import Sequence
from math import pi

import gmsh
import numpy as np

from cea.arrays import Floats
from meshes.ventilated_disc import VentilatedDisc

_AROUND = 12
"""Elements around each hole, at least."""
_CORNER = 0.4
"""Size of elements at the re-entrant corners of the hat, relative to that asked for: stresses are
singular there, and all modes bend them."""
_GROWTH = 0.3
"""Increase of the size of elements with the distance from what needs small ones."""
_SAME = 1e-6
"""Distance within which faces are found at the places where they were built, relative."""


def build_ventilated_disc(shape: VentilatedDisc) -> dict[str, list[int]]:
    """Make the disc one solid in the current model."""
    occ = gmsh.model.occ
    lower = _turned(
        (shape.bore, shape.hub_bottom),
        (shape.bore, shape.hub_top),
        (shape.wall_outer, shape.hub_top),
        (shape.wall_outer, shape.ring_height),
        (shape.outer_radius, shape.ring_height),
        (shape.outer_radius, 0.0),
        (shape.wall_inner, 0.0),
        (shape.wall_inner, shape.hub_bottom),
    )
    upper = _ring(shape, shape.upper_bottom, shape.upper_top)
    solid, _ = occ.fuse([lower], [upper, *_vanes(shape)])
    if shape.holes:
        height = shape.hub_top - shape.hub_bottom
        solid, _ = occ.cut(
            solid,
            [
                (3, occ.addCylinder(x, y, shape.hub_bottom, 0, 0, height, shape.hole_radius))
                for x, y in shape.hole_centres
            ],
        )
    occ.synchronize()
    return _surfaces(shape)


def refine(shape: VentilatedDisc, size: float) -> None:
    """Bound the sizes of elements of the current model where features need it.

    Elements are no longer than the wall of the hat is thick, and no fewer than twelve go round a
    hole, whatever ``size`` (m); at the corners where the wall meets flange and plate they are a
    part of ``size``. Away from there they grow to it.
    """
    field = gmsh.model.mesh.field
    middle = (shape.wall_inner + shape.wall_outer) / 2
    thickness = shape.wall_outer - shape.wall_inner
    near = [f"{min(size, thickness)!r}+{_GROWTH}*Fabs(Sqrt(x*x+y*y)-{middle!r})"]
    around = min(size, 2 * pi * shape.hole_radius / _AROUND)
    for x, y in shape.hole_centres:
        distance = f"Fabs(Sqrt((x-({x!r}))^2+(y-({y!r}))^2)-{shape.hole_radius!r})"
        near.append(f"{around!r}+{_GROWTH}*{distance}")
    for r, z in (
        (shape.wall_outer, shape.ring_height),
        (shape.wall_inner, shape.hub_bottom),
    ):
        distance = f"Sqrt((Sqrt(x*x+y*y)-{r!r})^2+(z-{z!r})^2)"
        near.append(f"{_CORNER * size!r}+{_GROWTH}*{distance}")
    tags = []
    for formula in near:
        tags.append(field.add("MathEval"))
        field.setString(tags[-1], "F", formula)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", tags)
    field.setAsBackgroundMesh(least)


def revolved(profile: Sequence[tuple[float, float]]) -> list[tuple[int, int]]:
    """What a profile of corners (r, z) sweeps about the z axis: itself, a solid, its walls."""
    occ = gmsh.model.occ
    points = [occ.addPoint(r, 0, z) for r, z in profile]
    following = points[1:] + points[:1]
    lines = [occ.addLine(a, b) for a, b in zip(points, following, strict=True)]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    swept = occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, 2 * np.pi)
    occ.remove([(2, face)], recursive=True)
    return list(swept)


def _turned(*profile: tuple[float, float]) -> tuple[int, int]:
    """Solid that a profile of corners (r, z) sweeps about the z axis."""
    (solid,) = (entity for entity in revolved(profile) if entity[0] == 3)
    return solid


def _ring(shape: VentilatedDisc, bottom: float, top: float) -> tuple[int, int]:
    """Flat ring of the radii of the rings."""
    inner, outer = shape.flange_outer, shape.outer_radius
    return _turned((inner, bottom), (outer, bottom), (outer, top), (inner, top))


def _vanes(shape: VentilatedDisc) -> list[tuple[int, int]]:
    """Solids of the vanes: boxes about their rays, as far as the ring between the rings reaches."""
    occ = gmsh.model.occ
    bottom, height = shape.ring_height, shape.upper_bottom - shape.ring_height
    boxes = []
    for angle in shape.vane_angles:
        box = occ.addBox(0, -shape.vane_width / 2, bottom, 2 * shape.outer_radius,
                         shape.vane_width, height)  # fmt: skip
        occ.rotate([(3, box)], 0, 0, 0, 0, 0, 1, angle)
        boxes.append((3, box))
    within = _ring(shape, bottom, shape.upper_bottom)
    vanes, _ = occ.intersect(boxes, [within])
    return list(vanes)


def _surfaces(shape: VentilatedDisc) -> dict[str, list[int]]:
    """Faces by surface, found by points of theirs."""
    found: dict[str, list[int]] = {name: [] for name in shape.surfaces}
    for _, tag in gmsh.model.getEntities(2):
        for name in _names_at(shape, _points_of(tag)):
            found[name].append(tag)
    return found


def _points_of(face: int) -> Floats:
    """Points of a face: a grid of its parameters, not all inside its edges, shape (n, 3)."""
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face)
    grid = np.meshgrid(np.linspace(u0, u1, 5), np.linspace(v0, v1, 5))
    at = np.column_stack([each.ravel() for each in grid])
    return np.reshape(gmsh.model.getValue(2, face, at.ravel()), (-1, 3))


def _names_at(shape: VentilatedDisc, x: Floats) -> list[str]:
    """Surfaces on which all of some points lie."""
    radius, z = np.hypot(x[:, 0], x[:, 1]), x[:, 2]
    close = _SAME * shape.outer_radius

    def all_at(values: Floats, value: float) -> bool:
        return bool((np.abs(values - value) < close).all())

    names = [
        name
        for name, level in (("lower_face", 0.0), ("upper_face", shape.upper_top),
                            ("hub_top", shape.hub_top))
        if all_at(z, level)
    ]  # fmt: skip
    if all_at(radius, shape.bore):
        names.append("bore")
    if all_at(radius, shape.outer_radius):
        names.append("rim")
    for centre in shape.hole_centres:
        if all_at(np.hypot(*(x[:, :2] - centre).T), shape.hole_radius):
            names.append("holes")
    return names
