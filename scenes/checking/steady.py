"""What a state of steady sliding must be read with."""

from collections.abc import Iterator

import numpy as np

from cea.contact.contact import Contact
from cea.contact.laws import NormalCompliance
from cea.matrices import destroy
from cea.petsc import Vec
from cea.system.coupled import CoupledSystem
from cea.system.steady_equations import LEFT_OVER
from cea.system.steady_state import ContactState, SteadySliding
from cea.warned import ResultWarning
from scenes.checking.closed_zone import coarse_closed_zone
from scenes.checking.geometry_error import geometry_error
from scenes.spec.reading import Scene

STATE_KEPT = "steady-state-kept"
"""Kind of the warning that a state is not the one at other parameters."""
_NOISE = 4.0
"""Closures, in parts of what rounding makes of displacements, that are neither open nor closed."""


def steady_warnings(
    scene: Scene, system: CoupledSystem, steady: SteadySliding
) -> tuple[ResultWarning, ...]:
    """What a state of steady sliding must be read with; collective."""
    found = list(steady.uniqueness.warnings()) if steady.uniqueness is not None else []
    found += _residual(steady)
    largest = _largest(steady.displacement)
    for contact in system.contacts:
        if contact.name in steady.contacts:
            state = steady.contacts[contact.name]
            found += _open(contact, state)
            found += _undecided(contact, state, _NOISE * steady.uncertainty * largest)
            found += geometry_error(system, steady, contact, state)
            halves = sum(each.pair == contact.pair for each in system.contacts)
            found += coarse_closed_zone(scene.bodies, contact, state, halves)
    return tuple(found)


def kept_state_warning(parameters: str) -> ResultWarning:
    """What is told where such parameters change and the state is kept.

    Parameters
    ----------
    parameters
        In words.
    """
    return ResultWarning(
        STATE_KEPT,
        f"the state of steady sliding depends on {parameters}, and is kept in derivatives and "
        "thresholds: closed zones and contact stiffness are those of the scene; a threshold with "
        "follow_steady_state seeks it at each value",
        {"parameters": parameters},
    )


def _largest(x: Vec) -> float:
    """Largest absolute entry of a PETSc vector."""
    sizes = x.duplicate()
    x.copy(sizes)
    sizes.abs()
    largest = sizes.max()[1]
    destroy(sizes)
    return float(largest)


def _residual(steady: SteadySliding) -> Iterator[ResultWarning]:
    """Forces that rounding leaves over, where the contact is very stiff."""
    if steady.residual > LEFT_OVER:
        yield ResultWarning(
            "equilibrium-rounding",
            f"rounding leaves {steady.residual:.1e} of the load of steady sliding over: contact "
            "pressures have no more digits",
            {"residual": steady.residual},
        )


def _open(contact: Contact, state: ContactState) -> Iterator[ResultWarning]:
    """A contact that is open while others are not."""
    if not state.closed_area:
        yield ResultWarning(
            "contact-open",
            f"contacts.{contact.name} is open in steady sliding: it carries nothing",
            {"contact": contact.pair, "half": contact.name},
        )


def _undecided(contact: Contact, state: ContactState, noise: float) -> Iterator[ResultWarning]:
    """Points that rounding makes open or closed, where their stiffness jumps."""
    law = contact.law
    if not isinstance(law, NormalCompliance) or law.m > 1:
        return
    points = np.abs(state.closure) <= noise
    area = float(contact.interface.points.weight[points].sum())
    if area:
        yield ResultWarning(
            "closure-undecided",
            f"rounding decides whether {area / state.area:.2g} of the area of "
            f"contacts.{contact.name} is open; with m_n = 1 its stiffness jumps there",
            {"contact": contact.pair, "half": contact.name, "fraction": area / state.area},
        )
