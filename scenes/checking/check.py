"""Inspection of a scene before it runs: meshing and contact search without a solve."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from cea.body import Body
from cea.contact.contact import Contact
from cea.errors import InputError, ResultWarning
from cea.timing import StageTimer
from scenes.building.build import below, build_bodies, check_free, half_passes
from scenes.checking.memory import check_memory, dofs_of
from scenes.checking.skipped import skipped_by
from scenes.checking.warnings import doubtful_numbers, warnings_of
from scenes.spec.problems import Faults
from scenes.spec.reading import Scene


@dataclass(frozen=True)
class Inspection:
    """Faults, warnings, bodies and contacts of a scene, found without a solve.

    Parameters
    ----------
    scene
        The inspected scene.
    faults
        Errors with which a run would be refused.
    skipped
        Stages and inputs that a run does not use, with the reason.
    warnings
        Warnings of a result that are known before the solve.
    bodies
        Bodies by name; empty if they do not fit into memory or one of them is invalid.
    halves
        Half passes of the valid contacts by name.
    """

    scene: Scene
    faults: Faults
    skipped: Mapping[str, str]
    warnings: tuple[ResultWarning, ...] = ()
    bodies: Mapping[str, Body] = field(default_factory=dict)
    halves: Mapping[str, Contact] = field(default_factory=dict)

    @property
    def dofs(self) -> int:
        """Number of unknowns of the bodies, an estimate if they were not built."""
        if not self.bodies:
            return round(sum(map(dofs_of, self.scene.bodies.values())))
        return sum(int(body.expansion.getSize()[1]) for body in self.bodies.values())


def inspect_scene(scene: Scene) -> Inspection:
    """Mesh the bodies of a scene and search its contacts, without a solve; collective.

    Returns
    -------
    Inspection
        With all faults of memory, bodies and contacts. Contacts are searched only if all bodies
        could be built.
    """
    faults = Faults()
    bodies: Mapping[str, Body] = {}
    halves: dict[str, Contact] = {}
    try:
        check_memory(scene)
        bodies = build_bodies(scene, StageTimer())
        check_free(scene, bodies)
    except InputError as error:
        faults.append(error)
    for name, contact in scene.contacts.items() if bodies else ():
        try:
            contacts = half_passes(name, contact, bodies)
            for half in contacts:
                if half.friction is not None:  # raises if the direction vanishes
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


def told(inspection: Inspection) -> Iterator[str]:
    """Yield the lines of a summary of an inspection; collective."""
    bodies = inspection.scene.bodies.items()
    shown = [f"{name} ({body.geometry.shape}, {body.backend})" for name, body in bodies]
    yield f"bodies: {', '.join(shown)}"
    for name, half in inspection.halves.items():
        statuses = ", ".join(f"{n} {s}" for s, n in half.interface.statuses.items() if n)
        yield (
            f"contacts.{name}: {len(half.interface.points)} points ({statuses}), sides up to "
            f"{np.abs(half.initial_gap).max(initial=0.0):.3g} m apart"
        )
    yield f"{'' if inspection.bodies else 'about '}{inspection.dofs} unknowns"
