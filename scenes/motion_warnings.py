"""What results of scenes with rotating bodies must be read with, a function for each kind."""

from collections.abc import Iterator, Sequence

import numpy as np

from cea.arrays import Floats
from cea.contact.operators import Contact
from cea.rotation import Rotation
from cea.warned import ResultWarning
from scenes.read import Scene


def centrifugal_stresses(scene: Scene) -> Iterator[ResultWarning]:
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


def against_rotation(scene: Scene, contacts: Sequence[Contact]) -> Iterator[ResultWarning]:
    """Friction that pushes side a along its motion over side b, as bodies rotate."""
    for name, spec in scene.contacts.items():
        half = next(contact.half for contact in contacts if contact.pair == name)
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


def _velocity(rotation: Rotation | None, x: Floats) -> Floats:
    """Velocities of a body at points x (m/s), shape (n, dim)."""
    if rotation is None:
        return np.zeros_like(x)
    dim = x.shape[1]
    arm = x - np.asarray(rotation.origin[:dim])
    return np.asarray(rotation.rate * arm @ rotation.spin(dim).T)
