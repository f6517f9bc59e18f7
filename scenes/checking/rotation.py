"""What scenes with bodies that rotate must be read with."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact
from cea.errors import ResultWarning
from cea.rotation import Rotation
from scenes.spec.reading import Scene

_SURFACE_WAVES = 0.8
"""Speed relative to shear waves from which rims may outrun surface waves: those of Rayleigh travel
at 0.87 (nu = 0) to 0.96 (nu = 0.5), short ones of a mesh a little slower."""


def rotation_warnings(scene: Scene, contacts: Sequence[Contact]) -> Iterator[ResultWarning]:
    """Warnings of small motions of bodies that rotate, before anything is solved."""
    yield from _centrifugal_stresses(scene)
    yield from _against_rotation(scene, contacts)


def _centrifugal_stresses(scene: Scene) -> Iterator[ResultWarning]:
    """A convective stiffness without the geometric stiffness that goes with it."""
    for name, body in scene.bodies.items():
        rotation = body.rotation
        if rotation is not None and rotation.convective_stiffness and rotation.coriolis:
            yield ResultWarning(
                "centrifugal-stresses",
                f"bodies.{name} has the convective stiffness of its rotation, not the geometric "
                "stiffness of its centrifugal stresses, which is of the same order: lambda is "
                f"uncertain by (rate / |lambda|)^2, and growth rates up to {rotation.rate:g} 1/s "
                "of nearly rigid motions may come of it",
                {"body": name, "rate": rotation.rate},
            )


def _against_rotation(scene: Scene, contacts: Sequence[Contact]) -> Iterator[ResultWarning]:
    """Friction that pushes side a along its motion over side b, as bodies rotate."""
    for name, spec in scene.contacts.items():
        half = next(contact for contact in contacts if contact.pair == name)
        rotations = [scene.bodies[body].rotation for body in (half.a, half.b)]
        acts = spec.mu != 0 or spec.sliding is not None
        if half.friction is None or not acts or not any(rotations):
            continue
        points = half.interface.points
        on_a, on_b = (_velocity(rotation, points.x) for rotation in rotations)
        k = half.friction.direction.at(points.x, points.normal)
        power = float(points.weight @ ((on_a - on_b) * k).sum(axis=1))
        if power > 0:
            yield ResultWarning(
                "against-rotation",
                f"friction_direction_on_a of contacts.{name} is along the velocity of side a "
                "relative to side b as the bodies rotate; friction acts against it",
                {"contact": name, "mean_velocity": power / float(points.weight.sum())},
            )


def faster_than_waves(scene: Scene, bodies: Mapping[str, Body]) -> Iterator[ResultWarning]:
    """Bodies with convective stiffness whose rim may outrun their surface waves; collective.

    Beyond that speed K - Omega^2 Z of a mesh has short waves of negative energy, which grow with
    its rounding and with the waves that it does not resolve, where the exact body is stable.
    """
    for name, body in bodies.items():
        rotation = scene.bodies[name].rotation
        if rotation is None or not rotation.convective_stiffness or body.material.rho is None:
            continue
        speeds = np.linalg.norm(
            _velocity(rotation, body.space.volume_cells().straight().points), axis=1
        )
        speed = float(max(body.comm.allgather(speeds.max(initial=0.0))))
        wave = float(np.sqrt(body.material.means[1] / body.material.rho))
        if speed > _SURFACE_WAVES * wave:
            yield ResultWarning(
                "faster-than-waves",
                f"bodies.{name} moves at up to {speed:.3g} m/s past the frame, near or above the "
                f"speed of its surface waves (shear waves {wave:.3g} m/s): short waves of its mesh "
                "may grow where the body itself is stable",
                {"body": name, "speed": speed, "wave_speed": wave},
            )


def _velocity(rotation: Rotation | None, x: Floats) -> Floats:
    if rotation is None:
        return np.zeros_like(x)
    dim = x.shape[1]
    arm = x - np.asarray(rotation.origin[:dim])
    return np.asarray(rotation.rate * arm @ rotation.spin(dim).T)
