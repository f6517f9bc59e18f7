"""States of steady sliding: what contacts carry, how they were found, whether they are alone."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from cea.arrays import Floats
from cea.contact.operators import Contact
from cea.petsc import Vec
from cea.warned import ResultWarning

_NEAR = 1e-2
"""Least eigenvalue, of the tangent relative to its symmetric part, that is not nearly zero."""


@dataclass(frozen=True)
class ContactState:
    """One half pass in steady sliding.

    Parameters
    ----------
    closure
        u_n - g_n at all points (m), positive where the contact is closed, shape (n,).
    pressure
        -sigma_n there (N/m^2), shape (n,).
    stiffness
        p there (N/m^3), that small motions meet, shape (n,).
    normal_force
        Integral of the pressure (N).
    friction_force
        Integral of mu times the pressure (N).
    force_on_a
        Resultant of both on side a (N), shape (dim,).
    closed_area
        Area that is closed (m^2).
    area
        Area of the contact (m^2).
    """

    closure: Floats
    pressure: Floats
    stiffness: Floats
    normal_force: float
    friction_force: float
    force_on_a: Floats
    closed_area: float
    area: float

    @property
    def closed_fraction(self) -> float:
        """Part of the area that is closed."""
        return self.closed_area / self.area


@dataclass(frozen=True)
class StepState:
    """The equilibrium under a part of the load.

    Parameters
    ----------
    displacement
        Free displacements (m), PETSc vector.
    contacts
        State of each half pass with a law, by its name.
    margin
        That of :class:`Uniqueness`; None where the tangent is symmetric or singular.
    """

    displacement: Vec
    contacts: Mapping[str, ContactState]
    margin: float | None


@dataclass(frozen=True)
class LoadStep:
    """A part of the load at which the equilibrium was found.

    Parameters
    ----------
    factor
        The part.
    residuals
        Residual of each state of Newton's method, relative to the forces it is the sum of.
    lengths
        Part of each of its steps that was taken.
    closed
        Points that were closed in each state.
    parity
        Whether the number of negative real eigenvalues of the tangent is odd (1) or even (0); None
        where it is symmetric, or that is not known.
    state
        The equilibrium; None where the history was not asked for.
    """

    factor: float
    residuals: tuple[float, ...]
    lengths: tuple[float, ...]
    closed: tuple[int, ...]
    parity: int | None
    state: StepState | None = None


@dataclass(frozen=True)
class Uniqueness:
    """What the tangent of a state says of others near it.

    Parameters
    ----------
    parity
        Whether the number of negative real eigenvalues of the tangent is odd (1) or even (0); None
        where that is not known.
    parities
        The same on the way, by part of the load.
    margin
        Estimate of the least absolute eigenvalue of the tangent relative to its symmetric part: 1
        without friction, 0 where branches meet.
    """

    parity: int | None
    parities: Mapping[float, int | None]
    margin: float

    @property
    def lost(self) -> bool:
        """Whether the determinant has, here or on the way, another sign than without friction."""
        return 1 in (self.parity, *self.parities.values())

    @property
    def near(self) -> bool:
        """Whether the tangent is nearly singular."""
        return self.margin < _NEAR

    def warnings(self) -> tuple[ResultWarning, ...]:
        """What a reader must know of it."""
        data = {
            "parity": self.parity,
            "parities": [[factor, parity] for factor, parity in self.parities.items()],
            "margin": self.margin,
        }
        if self.lost:
            return (
                ResultWarning(
                    "not-unique",
                    "the determinant of the tangent has another sign than without friction: the "
                    "equilibrium is unstable or there are others",
                    data,
                ),
            )
        if self.near:
            return (
                ResultWarning(
                    "nearly-not-unique",
                    f"the tangent is nearly singular ({self.margin:.1e} of that without friction): "
                    "other equilibria are near",
                    data,
                ),
            )
        return ()


@dataclass(frozen=True)
class SteadySliding:
    """A state of steady sliding.

    Parameters
    ----------
    displacement
        Free displacements (m), PETSc vector.
    forces
        Forces of contacts of a linear law that are unknowns (N), the rows of this rank.
    uncertainty
        What rounding the tangent makes of them, relative to the largest.
    residual
        Forces left over by the pencil that is linearised about it, relative to the load.
    contacts
        State of each half pass with a law, by its name.
    path
        Parts of the load on the way.
    uniqueness
        Whether another equilibrium may be near; None where the tangent is symmetric.
    reactions
        Forces (N) of each support on its body, by body, shape (supports, dim).
    """

    displacement: Vec
    forces: Floats
    uncertainty: float
    residual: float
    contacts: Mapping[str, ContactState]
    path: tuple[LoadStep, ...]
    uniqueness: Uniqueness | None
    reactions: Mapping[str, Floats] = field(default_factory=dict)

    @property
    def iterations(self) -> int:
        """Steps of Newton's method, over all parts of the load."""
        return sum(len(step.lengths) for step in self.path)


def contact_state(contact: Contact, closure: Floats) -> ContactState:
    """What a half pass carries at closures of all its points (m), shape (n,)."""
    half, points = contact.half, contact.interface.points
    pressure = half.law.pressure(closure)
    weighted = points.weight * pressure
    force = -(weighted @ points.normal)
    friction = 0.0
    if half.friction is not None and half.friction.acts:
        rubbing = weighted * half.friction.mu
        friction = float(rubbing.sum())
        force = force + rubbing @ half.friction.direction.at(points.x, points.normal)
    return ContactState(
        closure=closure,
        pressure=pressure,
        stiffness=half.law.slope(closure),
        normal_force=float(weighted.sum()),
        friction_force=friction,
        force_on_a=force,
        closed_area=float(points.weight[closure > 0].sum()),
        area=float(points.weight.sum()),
    )
