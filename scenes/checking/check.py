"""A scene looked at before it is run: bodies meshed, contact points searched, nothing solved."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from cea.body import Body
from cea.contact.contact import Contact
from cea.errors import InputError, ResultWarning
from cea.timing import StageTimer
from scenes.building.build import below, build_bodies, half_passes
from scenes.checking.memory import check_memory, dofs_of
from scenes.checking.skipped import skipped_by
from scenes.checking.warnings import doubtful_numbers, warnings_of
from scenes.spec.problems import Faults
from scenes.spec.reading import Scene


@dataclass(frozen=True)
class Inspection:
    """What can be said of a scene without solving anything.

    Parameters
    ----------
    scene
        The scene.
    faults
        Why it would be refused.
    skipped
        What it does not need, with the reason.
    warnings
        What its result would have to be read with, as far as that is known before.
    bodies
        Its bodies, none where they do not fit into memory or one of them is refused.
    halves
        Its contacts by name of the half pass, but for those that are refused.
    """

    scene: Scene
    faults: Faults
    skipped: Mapping[str, str]
    warnings: tuple[ResultWarning, ...] = ()
    bodies: Mapping[str, Body] = field(default_factory=dict)
    halves: Mapping[str, Contact] = field(default_factory=dict)

    @property
    def dofs(self) -> int:
        """Unknowns: of the bodies as built, else estimated."""
        if not self.bodies:
            return round(sum(map(dofs_of, self.scene.bodies.values())))
        return sum(int(body.expansion.getSize()[1]) for body in self.bodies.values())


def inspect_scene(scene: Scene) -> Inspection:
    """Look at a scene without solving anything; collective.

    Returns
    -------
    Inspection
        With every fault of its memory, bodies and contacts; one that cannot be meshed has no
        contact points.
    """
    faults = Faults()
    bodies: Mapping[str, Body] = {}
    halves: dict[str, Contact] = {}
    try:
        check_memory(scene)
        bodies = build_bodies(scene, StageTimer())
    except InputError as error:
        faults.append(error)
    for name, contact in scene.contacts.items() if bodies else ():
        try:
            contacts = half_passes(name, contact, bodies)
            for half in contacts:
                if half.friction is not None:  # it has a direction everywhere
                    points = half.interface.points
                    with below(f"contacts.{name}"):
                        half.friction.along(points.x, points.normal)
            halves |= {half.name: half for half in contacts}
        except InputError as error:
            faults.append(error)
    found = doubtful_numbers(scene)
    if bodies:
        found = warnings_of(scene, bodies, [] if faults else list(halves.values()))
    return Inspection(scene, faults, skipped_by(scene), tuple(found), bodies, halves)


def gaps(half: Contact) -> np.ndarray:
    """Distances (m) between the sides at all points, apart positive; collective."""
    interface = half.interface
    found = np.concatenate(interface.comm.allgather(interface.initial_gap))
    return np.asarray(found + half.added_gap)


def told(inspection: Inspection) -> Iterator[str]:
    """An inspection in lines; collective."""
    bodies = inspection.scene.bodies.items()
    shown = [f"{name} ({body.geometry.shape}, {body.backend})" for name, body in bodies]
    yield f"bodies: {', '.join(shown)}"
    for name, half in inspection.halves.items():
        statuses = ", ".join(f"{n} {s}" for s, n in half.interface.statuses.items() if n)
        yield (
            f"contacts.{name}: {len(half.interface.points)} points ({statuses}), sides up to "
            f"{np.abs(gaps(half)).max(initial=0.0):.3g} m apart"
        )
    yield f"{'' if inspection.bodies else 'about '}{inspection.dofs} unknowns"
