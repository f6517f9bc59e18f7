"""What a body that rotates is refused for."""

from collections.abc import Iterable

import numpy as np

from cea.arrays import Floats, of_size_one
from cea.errors import InputError
from cea.material import Elasticity
from cea.motion import Rotation
from cea.supports.boundary import Support
from cea.supports.frames import Cartesian, Cylindrical
from scenes.spec.body import BodySpec
from scenes.spec.problems import Faults

_AXISYMMETRIC = ("annulus", "hub", "disc", "ring")
"""Shapes that a rotation about their own axis leaves as they are, and all of their surfaces."""
_ASIDE = 1e-9
"""Distance of an axis from that of a shape, relative to its radius, and sine of their angle."""
_ALIKE = "alike all round the axis of the rotation where a body that rotates is damped"


def rotation_checks(faults: Faults, place: str, body: BodySpec, rotation: Rotation) -> None:
    """Rotations that do not leave a body as it is, and what does not suit them."""
    shape, dim, damping = body.geometry.shape, body.dim, body.damping
    faults.of(rotation.check, dim, f"{place}.rotation")
    if shape not in _AXISYMMETRIC:
        allowed = f"{', '.join(_AXISYMMETRIC)} to rotate"
        faults.append(InputError(f"{place}.geometry.shape", shape, allowed))
        return
    axis, here = body.placement.rotation[:, 2], body.placement.translation
    parallel, on_axis = _are_parallel(axis, rotation.axis), _is_on_axis(body, rotation.origin)
    faults.require(parallel, f"{place}.rotation.axis", rotation.axis, f"along {axis.tolist()}")
    allowed = f"a point of the axis of the body, as {list(here)}"
    faults.require(on_axis, f"{place}.rotation.origin", rotation.origin, allowed)
    alike = _material_turns(body.material.elasticity, rotation, dim)
    kind, allowed = body.material.kind, "the same all round the rotation"
    faults.require(alike, f"{place}.material", kind, allowed)
    for i, spec in enumerate(body.supports):
        at_rest = not (body.rotates_in_equilibrium and spec.support().prescribes)
        allowed = "zero where a body rotates with damping or convective stiffness"
        faults.require(at_rest, f"{place}.supports.{i}.value", spec.value, allowed)
        alike = damping is None or _goes_round(spec.support(), body, rotation)
        faults.require(alike, f"{place}.supports.{i}", list(spec.components), _ALIKE)
    for i, spring in enumerate(body.springs if damping is not None and damping.modal else ()):
        stiffness = spring.stiffness
        alike = len(stiffness) != dim or _turns(np.diag(stiffness), rotation)
        allowed = f"{_ALIKE} mode by mode"
        faults.require(alike, f"{place}.springs.{i}.stiffness", stiffness, allowed)


def _goes_round(support: Support, body: BodySpec, rotation: Rotation) -> bool:
    """Whether a support of a surface of revolution is the same all round the axis."""
    frame, components = support.frame, support.components
    if components is None:
        return True
    if isinstance(frame, Cartesian):
        held = np.isin(np.arange(body.dim), components)
        return _turns(np.diag(held.astype(float)), rotation)
    if isinstance(frame, Cylindrical):
        along = _are_parallel(frame.axis or (0.0, 0.0, 1.0), rotation.axis)
        about = (0 in components) == (1 in components)
        return along and (about or _is_on_axis(body, frame.origin or (0.0, 0.0, 0.0)))
    return True


def _material_turns(law: Elasticity, rotation: Rotation, dim: int) -> bool:
    """Whether stresses turn with the strains, where both are turned about the axis by a radian."""
    spin, origin = rotation.spin(dim), np.asarray(rotation.origin[:dim], dtype=float)[:, None]
    turn = np.eye(dim) + np.sin(1.0) * spin + (1 - np.cos(1.0)) * spin @ spin
    arm = np.sqrt([[2.0], [3.0], [5.0]])[:dim]  # along no axis
    gradient = np.square(np.arange(1.0, dim**2 + 1)).reshape(dim, dim)
    here = law.stress(gradient[..., None], origin + arm)[..., 0]
    there = law.stress((turn @ gradient @ turn.T)[..., None], origin + turn @ arm)[..., 0]
    return bool(np.abs(turn @ here @ turn.T - there).max() <= _ASIDE * np.abs(here).max())


def _turns(matrix: Floats, rotation: Rotation) -> bool:
    """Whether a matrix of components is the same in every frame that is turned about the axis."""
    spin = rotation.spin(len(matrix))
    return bool(np.abs(spin @ matrix - matrix @ spin).max() <= _ASIDE * np.abs(matrix).max())


def _are_parallel(one: Iterable[float], other: Iterable[float]) -> bool:
    first, second = (of_size_one(tuple(each)) for each in (one, other))
    sine = np.linalg.norm(np.cross(first, second)) / np.linalg.norm(first) / np.linalg.norm(second)
    return bool(sine <= _ASIDE)


def _is_on_axis(body: BodySpec, point: Iterable[float]) -> bool:
    x = np.array([*point, 0.0])[:3]
    arm = np.cross(body.placement.rotation[:, 2], x - body.placement.translation)
    return bool(np.linalg.norm(arm) <= _ASIDE * body.geometry.extent[0][1])
