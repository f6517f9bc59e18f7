"""How stiff a contact is beside its bodies: nondimensional, from the scene and its points."""

from collections.abc import Sequence

from cea.contact.contact import Contact
from cea.expressions import Expression, evaluate
from meshes.ventilated_disc import VentilatedDisc
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

_ENDS = {
    "x": ("x_min", "x_max"),
    "y": ("y_min", "y_max"),
    "z": ("z_min", "z_max", "bottom", "top", "hub_bottom", "hub_top"),
    "r": ("inner", "outer", "bore", "hub_side"),
}
"""Surfaces that end a body along each direction of its shape."""


def relative_stiffness(scene: Scene, name: str, halves: Sequence[Contact]) -> float:
    """P (L_a / E_a + L_b / E_b): how much more the bodies yield than the contact.

    L is the depth of a body behind the contact, or the width of the contact where that is less or
    the depth is not known; p the mean contact stiffness (N/m^3), of both halves of a full pass.
    """
    spec, compliance, interface = scene.contacts[name], 0.0, halves[0].interface
    width = float(interface.points.weight.sum()) ** (1 / (interface.a.dim - 1))
    for side in (spec.a, spec.b):
        body, surface = side.split(".")
        depth = _depth(scene, body, surface)
        compliance += min(depth or width, width) / scene.bodies[body].material.E
    return _mean(spec, halves) * compliance


def stiffness_in_the_mesh(scene: Scene, name: str, halves: Sequence[Contact]) -> float:
    """P h / E with the mesh size h and E of the side for which h / E is larger."""
    spec, interface = scene.contacts[name], halves[0].interface
    sides = zip((spec.a, spec.b), (interface.a, interface.b), strict=True)
    yields = (s.mesh_size / scene.bodies[side.split(".")[0]].material.E for side, s in sides)
    return _mean(spec, halves) * max(yields)


def _mean(spec: ContactSpec, halves: Sequence[Contact]) -> float:
    """Mean contact stiffness p (N/m^3), of steady sliding where a law makes it, open parts too."""
    points = halves[0].interface.points
    if spec.c_n is not None:
        return sum(half.P for half in halves) / float(points.weight.sum())
    if spec.P is not None:
        return spec.P / float(points.weight.sum())
    if isinstance(spec.p, str):
        return float(points.weight @ evaluate(Expression(spec.p), points.x) / points.weight.sum())
    assert spec.p is not None
    return spec.p


def _depth(scene: Scene, body: str, surface: str) -> float | None:
    """Extent (m) of a body across one of its surfaces; None where its shape does not say."""
    shape = scene.bodies[body].geometry
    if isinstance(shape, VentilatedDisc):
        return shape.depth(surface)
    if shape.shape in ("patches", "nurbs_file"):
        return None
    for direction, (low, high) in zip(shape.directions, shape.extent, strict=True):
        if surface in _ENDS.get(direction, ()):
            return high - low
    return None
