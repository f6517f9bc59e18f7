"""What a body that rotates is refused for."""

from collections.abc import Iterable

import numpy as np

from cea.arrays import Floats, of_size_one
from cea.errors import InputError
from cea.rotation import Rotation
from cea.supports.boundary import Support
from cea.supports.frames import Cartesian, Cylindrical
from scenes.spec.body import BodySpec
from scenes.spec.contact_checks import fault_of

_AXISYMMETRIC = ("annulus", "hub", "disc", "ring")
"""Shapes that a rotation about their own axis leaves as they are, and all of their surfaces."""
_ASIDE = 1e-9
"""Distance of an axis from that of a shape, relative to its radius, and sine of their angle."""
_DAMPED = "where a body that rotates is damped"


def rotation_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Rotations that do not leave the body as it is, and what does not suit them.

    Parameters
    ----------
    place
        Path of the body.
    body
        The body.
    """
    rotation, shape = body.rotation, body.geometry.shape
    if rotation is None:
        return
    dim = len(body.geometry.directions)
    yield from fault_of(rotation.check, dim, f"{place}.rotation")
    if shape not in _AXISYMMETRIC:
        yield InputError(f"{place}.geometry.shape", shape, f"{', '.join(_AXISYMMETRIC)} to rotate")
        return
    axis = body.placement.rotation[:, 2]
    if not _are_parallel(axis, rotation.axis):
        yield InputError(f"{place}.rotation.axis", rotation.axis, f"along {axis.tolist()}")
    if not _is_on_axis(body, rotation.origin):
        allowed = f"a point of the axis of the body, as {list(body.placement.translation)}"
        yield InputError(f"{place}.rotation.origin", rotation.origin, allowed)
    if body.rotates_in_equilibrium:
        yield from _value_checks(place, body)
    if body.damping is not None:
        yield from _damping_checks(place, body, rotation)


def _value_checks(place: str, body: BodySpec) -> Iterable[InputError]:
    """Displacements that are prescribed where forces of the rotation would go with them."""
    for i, spec in enumerate(body.supports):
        if spec.support().prescribes:
            allowed = "zero where a body rotates with damping or convective stiffness"
            yield InputError(f"{place}.supports.{i}.value", spec.value, allowed)


def _damping_checks(place: str, body: BodySpec, rotation: Rotation) -> Iterable[InputError]:
    """Supports, and springs of modal damping, that are not alike all round the axis."""
    for i, spec in enumerate(body.supports):
        if not _goes_round(spec.support(), body, rotation):
            allowed = f"alike all round the axis of the rotation {_DAMPED}"
            yield InputError(f"{place}.supports.{i}", list(spec.components), allowed)
    if body.damping is None or body.damping.modal is None:
        return
    dim = len(body.geometry.directions)
    for i, spring in enumerate(body.springs):
        if len(spring.stiffness) == dim and not _turns(np.diag(spring.stiffness), rotation):
            allowed = f"alike all round the axis of the rotation {_DAMPED} mode by mode"
            yield InputError(f"{place}.springs.{i}.stiffness", spring.stiffness, allowed)


def _goes_round(support: Support, body: BodySpec, rotation: Rotation) -> bool:
    """Whether a support of a surface of revolution is the same all round the axis."""
    frame, components = support.frame, support.components
    if components is None:
        return True
    if isinstance(frame, Cartesian):
        held = np.isin(np.arange(len(body.geometry.directions)), components)
        return _turns(np.diag(held.astype(float)), rotation)
    if isinstance(frame, Cylindrical):
        along = _are_parallel(frame.axis or (0.0, 0.0, 1.0), rotation.axis)
        about = (0 in components) == (1 in components)
        return along and (about or _is_on_axis(body, frame.origin or (0.0, 0.0, 0.0)))
    return True


def _turns(matrix: Floats, rotation: Rotation) -> bool:
    """Whether a matrix of components is the same in every frame that is turned about the axis."""
    spin = rotation.spin(len(matrix))
    return bool(np.abs(spin @ matrix - matrix @ spin).max() <= _ASIDE * np.abs(matrix).max())


def _are_parallel(one: Iterable[float], other: Iterable[float]) -> bool:
    """Whether two directions, of any length but zero, are the same or opposite."""
    first, second = (of_size_one(tuple(each)) for each in (one, other))
    sine = np.linalg.norm(np.cross(first, second)) / np.linalg.norm(first) / np.linalg.norm(second)
    return bool(sine <= _ASIDE)


def _is_on_axis(body: BodySpec, point: Iterable[float]) -> bool:
    """Whether a point lies on the axis of a body; in the plane it may have two coordinates."""
    x = np.zeros(3)
    given = tuple(point)
    x[: len(given)] = given
    arm = x - body.placement.translation
    distance = np.linalg.norm(np.cross(body.placement.rotation[:, 2], arm))
    return bool(distance <= _ASIDE * body.geometry.extent[0][1])
