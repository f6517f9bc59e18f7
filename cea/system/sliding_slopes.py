"""How stiff closed contacts are: springs to begin from, laws too stiff for rounding."""

import numpy as np

from cea.arrays import Floats
from cea.contact.interface import Interface
from cea.errors import ConvergenceError
from cea.petsc import MPI
from cea.system.sliding_problem import SlidingProblem

OPENS = "the load opens the contact: no point is closed"
_OVERLAP = 1e-9
"""Overlap of the sides, relative to the mesh size, that rounding and facets may make."""
_RESOLVED = 1e-6
"""Rounding of displacements, in parts of the pressure it makes, up to which states are found."""


def closed_slopes(problem: SlidingProblem, factor: float) -> list[Floats]:
    """Secant slope of each contact where a part of the load presses all of it evenly (N/m^3).

    Raises
    ------
    ConvergenceError
        When nothing presses.
    """
    slopes = []
    for number, (nearest, area) in enumerate(zip(problem.nearest, problem.areas, strict=True)):
        law, interface = problem.law(number), problem.contacts[number].interface
        closure = max(law.closure(factor * problem.load / area), _overlap(nearest, interface))
        if not closure > 0:
            raise ConvergenceError(f"{OPENS}; nothing presses the sides together", best=None)
        pressure = float(law.pressure(np.array(closure)))
        slopes.append(np.full(len(interface.points), pressure / closure))
    return slopes


def _overlap(nearest: float, interface: Interface) -> float:
    """By how much the sides overlap before any load (m); zero where rounding may make it."""
    size = min(interface.a.mesh_size, interface.b.mesh_size)
    return -nearest if -nearest > _OVERLAP * size else 0.0


def too_stiff(problem: SlidingProblem, factor: float, x: Floats) -> str | None:
    """Whether rounding of displacements comes to too much of a pressure, and what would not.

    Parameters
    ----------
    problem
        The equations.
    factor
        The part of the load.
    x
        Displacements about as large as those under it (m), the rows of this rank.
    """
    largest = problem.comm.allreduce(float(np.abs(x).max(initial=0.0)), MPI.MAX)
    for number, contact in enumerate(problem.contacts):
        law = problem.law(number)
        pressure = factor * problem.load / problem.areas[number]
        slope = float(law.slope(np.array(law.closure(pressure))))
        part = slope * np.finfo(float).eps * largest / pressure
        if part > _RESOLVED:
            allowed = law.c * (_RESOLVED / part) ** law.m
            return (
                f"contacts.{contact.pair} is so stiff that rounding of displacements comes to "
                f"{part:.1e} of its pressure: c_n = {law.c:.3g}, about {allowed:.1g} or less is "
                "allowed; or P or p in its place, in the saddle form up to infinity"
            )
    return None
