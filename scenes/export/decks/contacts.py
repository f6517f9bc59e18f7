"""Contacts of a deck: surface interactions, pairs, and how they are closed before modes are sought.

A scene knows its contacts to be closed. A deck has to close them: the sides overlap by a closure so
small that nothing deforms, and all pressures are the contact stiffness times that closure.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cea.errors import InputError
from scenes.export.decks.bodies import DeckBody, set_name
from scenes.export.decks.lines import keyword, number, numbers
from scenes.spec.contact import ContactSpec


@dataclass(frozen=True)
class DeckContact:
    """A contact as decks have it.

    Parameters
    ----------
    name
        Name in the scene.
    spec
        What the scene says of it; side a is the slave, where integration points lie.
    stiffness
        Contact stiffness p (N/m^3), uniform.
    mu
        Friction coefficient.
    closure
        How far the sides overlap (m).
    """

    name: str
    spec: ContactSpec
    stiffness: float
    mu: float
    closure: float

    @property
    def interaction(self) -> str:
        """Name of its surface interaction."""
        return f"{self.name}-interaction"

    @property
    def slave(self) -> str:
        """Name of the surface that is side a."""
        return set_name(self.spec.a)

    @property
    def master(self) -> str:
        """Name of the surface that is side b."""
        return set_name(self.spec.b)

    def behaviour_lines(self, friction: list[float]) -> list[str]:
        """Its surface interaction: a linear law, and the numbers of friction where there is any."""
        rubbing = [keyword("FRICTION"), numbers(friction)] if self.mu else []
        return [
            keyword("SURFACE INTERACTION", NAME=self.interaction),
            "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
            number(self.stiffness),
            *rubbing,
        ]

    def pair_lines(self, *parameters: str) -> list[str]:
        """The pair, slave first."""
        options = ", ".join(["TYPE=SURFACE TO SURFACE", *parameters])
        return [f"*CONTACT PAIR, INTERACTION={self.interaction}, {options}", self._sides]

    def clearance_line(self) -> str:
        """The overlap in the place of whatever distance the nodes have."""
        value = number(-self.closure)
        return keyword("CLEARANCE", MASTER=self.master, SLAVE=self.slave, VALUE=value)

    @property
    def _sides(self) -> str:
        return f"{self.slave}, {self.master}"


def deck_contacts(
    contacts: Mapping[str, ContactSpec], bodies: Mapping[str, DeckBody], relative_closure: float
) -> list[DeckContact]:
    """Contacts of a scene that was checked before."""
    points = np.concatenate([body.mesh.points for body in bodies.values()])
    closure = relative_closure * float(np.ptp(points, axis=0).max())
    return [
        DeckContact(name, spec, _stiffness(name, spec, bodies), float(spec.mu), closure)
        for name, spec in contacts.items()
    ]


def _stiffness(name: str, spec: ContactSpec, bodies: Mapping[str, DeckBody]) -> float:
    """p, or P over the area of side a."""
    if spec.P is None:
        return float(spec.p or 0.0)
    body, surface = spec.a.split(".")
    area = bodies[body].area_of(surface)
    if not area > 0:
        raise InputError(f"contacts.{name}.a", spec.a, "a surface with an area")
    return spec.P / area
