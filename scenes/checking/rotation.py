"""What scenes with bodies that rotate must be read with."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact
from cea.errors import ResultWarning
from cea.motion import Rotation
from scenes.spec.body import BodySpec
from scenes.spec.reading import Scene

_SURFACE_WAVES = 0.8
"""Speed relative to shear waves from which rims may outrun surface waves: those of Rayleigh travel
at 0.87 (nu = 0) to 0.96 (nu = 0.5), short ones of a mesh a little slower."""


def rotation_warnings(scene: Scene, contacts: Sequence[Contact]) -> Iterator[ResultWarning]:
    """Warnings of small motions of bodies that rotate, before anything is solved."""
    for name, body in scene.bodies.items():
        rotation = body.rotation
        if rotation is not None and rotation.convective_stiffness and rotation.coriolis:
            told = (
                f"bodies.{name} has the convective stiffness of its rotation without the geometric "
                "stiffness of its centrifugal stresses: lambda is uncertain by (rate / |lambda|)^2"
            )
            data = {"body": name, "rate": rotation.rate}
            yield ResultWarning("centrifugal-stresses", told, data)
    for name, spec in scene.contacts.items():
        half = next(contact for contact in contacts if contact.pair == name)
        if half.friction is not None and (spec.mu != 0 or spec.sliding is not None):
            yield from _against_rotation(name, half, scene.bodies)


def _against_rotation(
    name: str, half: Contact, bodies: Mapping[str, BodySpec]
) -> Iterator[ResultWarning]:
    """Friction that pushes side a along its motion over side b, as bodies rotate."""
    assert half.friction is not None
    points = half.interface.points
    on_a, on_b = (_velocity(bodies[body].rotation, points.x) for body in (half.a, half.b))
    k = half.friction.along(points.x, points.normal)
    power = float(points.weight @ ((on_a - on_b) * k).sum(axis=1))
    if power > 0:
        told = (
            f"friction_direction_on_a of contacts.{name} is along the velocity of side a "
            "relative to side b as the bodies rotate; friction acts against it"
        )
        data = {"contact": name, "mean_velocity": power / float(points.weight.sum())}
        yield ResultWarning("against-rotation", told, data)


def faster_than_waves(scene: Scene, bodies: Mapping[str, Body]) -> Iterator[ResultWarning]:
    """Bodies with convective stiffness whose rim may outrun their surface waves; collective.

    Beyond that speed K - Omega^2 Z of a mesh has short waves of negative energy, which grow with
    its rounding and with the waves that it does not resolve, where the exact body is stable.
    """
    for name, body in bodies.items():
        rotation = scene.bodies[name].rotation
        if rotation is None or not rotation.convective_stiffness or body.material.rho is None:
            continue
        velocities = _velocity(rotation, body.space.volume_cells().straight().points)
        fastest = np.linalg.norm(velocities, axis=1).max(initial=0.0)
        speed = float(max(body.comm.allgather(fastest)))
        wave = float(np.sqrt(body.material.means[1] / body.material.rho))
        if speed > _SURFACE_WAVES * wave:
            told = (
                f"bodies.{name} moves at up to {speed:.3g} m/s, near the speed of its surface "
                f"waves or above (shear waves {wave:.3g} m/s): short waves of its mesh may grow"
            )
            data = {"body": name, "speed": speed, "wave_speed": wave}
            yield ResultWarning("faster-than-waves", told, data)


def _velocity(rotation: Rotation | None, x: Floats) -> Floats:
    if rotation is None:
        return np.zeros_like(x)
    dim = x.shape[1]
    arm = x - np.asarray(rotation.origin[:dim])
    return np.asarray(rotation.rate * arm @ rotation.spin(dim).T)
