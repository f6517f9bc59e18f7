"""States of steady sliding: contact forces, solution history, uniqueness.

The pressure law is monotone: without friction the tangent is symmetric positive definite and the
equilibrium is unique. With friction it may become singular, where branches of equilibria meet, and
beyond it has an odd number of negative real eigenvalues, which the sign of the determinant shows.
If bodies rotate above a critical rate, only those in excess of its symmetric part count.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cea.arrays import Floats
from cea.contact.contact import Contact
from cea.eigen.block_products import norms, times
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted, count_below
from cea.errors import ResultWarning
from cea.petsc import Vec

_NEAR = 1e-2
"""Smallest eigenvalue of the tangent, relative to its symmetric part, that is not near zero."""
_STEPS = 12  # inverse iterations


@dataclass(frozen=True)
class ContactState:
    """One half pass in steady sliding."""

    closure: Floats  # u_n - g_n at all points (m), positive where it is closed, shape (n,)
    pressure: Floats  # -sigma_n there (N/m^2), shape (n,)
    stiffness: Floats  # contact stiffness p there (N/m^3), shape (n,)
    normal_force: float  # integral of the pressure (N)
    friction_force: float  # integral of mu times the pressure (N)
    force_on_a: Floats  # resultant of both on side a (N), shape (dim,)
    closed_area: float  # closed area (m^2)
    area: float  # area of the contact (m^2)

    @property
    def closed_fraction(self) -> float:
        """Closed fraction of the area."""
        return self.closed_area / self.area


@dataclass
class LoadStep:
    """A load step, with the history of Newton's method."""

    factor: float  # load factor
    # residual of each state, relative to the largest of its terms
    residuals: list[float] = field(default_factory=list)
    lengths: list[float] = field(default_factory=list)  # damping factor of each step
    closed: list[int] = field(default_factory=list)  # number of closed points in each state
    # whether the number of negative real eigenvalues of the last tangent is odd (1) or even (0);
    # None if it is symmetric, or unknown
    parity: int | None = None
    # the equilibrium, if the history was requested: free displacements (m), PETSc vector, and the
    # state of each half pass with a law, by its name
    displacement: Vec | None = None
    contacts: Mapping[str, ContactState] = field(default_factory=dict)


@dataclass(frozen=True)
class Uniqueness:
    """Information on other equilibria from the tangent of a state."""

    # whether the number of negative real eigenvalues of the tangent is odd (1) or even (0); None
    # if unknown
    parity: int | None
    parities: Mapping[float, int | None]  # the same at each load factor of the path
    # estimate of the least absolute eigenvalue of the tangent relative to its symmetric part: 1
    # without friction, 0 where branches meet
    margin: float

    @property
    def lost(self) -> bool:
        """Whether the determinant has, at any load factor, another sign than without friction."""
        return 1 in (self.parity, *self.parities.values())

    def warnings(self) -> tuple[ResultWarning, ...]:
        """Return warnings of lost, or nearly lost, uniqueness."""
        if self.lost:
            kind = "not-unique"
            message = (
                "the determinant of the tangent has another sign than without friction: the "
                "equilibrium is unstable or there are others"
            )
        elif self.margin < _NEAR:
            kind = "nearly-not-unique"
            message = (
                f"the tangent is nearly singular ({self.margin:.1e} of that without friction): "
                "other equilibria are near"
            )
        else:
            return ()
        parities = [[factor, parity] for factor, parity in self.parities.items()]
        data = {"parity": self.parity, "parities": parities, "margin": self.margin}
        return (ResultWarning(kind, message, data),)


@dataclass(frozen=True)
class SteadySliding:
    """A state of steady sliding."""

    displacement: Vec  # free displacements (m), PETSc vector
    forces: Floats  # Lagrange multipliers of linear contacts (N), the rows of this rank
    uncertainty: float  # rounding error of displacements, relative to the largest
    residual: float  # residual, relative to the load
    contacts: Mapping[str, ContactState]  # of each half pass with a law, by its name
    path: tuple[LoadStep, ...]  # load steps
    # uniqueness of the equilibrium; None if the tangent is symmetric
    uniqueness: Uniqueness | None
    # forces (N) of each support on its body, by body, shape (supports, dim)
    reactions: Mapping[str, Floats] = field(default_factory=dict)

    @property
    def iterations(self) -> int:
        """Number of Newton steps of all load steps."""
        return sum(len(step.lengths) for step in self.path)


def contact_state(contact: Contact, closure: Floats) -> ContactState:
    """Return the contact state of a half pass at closures of all its points (m), shape (n,)."""
    points = contact.interface.points
    pressure = contact.law.pressure(closure)
    weighted = points.weight * pressure
    force = -(weighted @ points.normal)
    friction = 0.0
    if contact.friction is not None and contact.has_friction:
        tangential = weighted * contact.friction.mu
        friction = float(tangential.sum())
        force = force + tangential @ contact.friction.along(points.x, points.normal)
    return ContactState(
        closure=closure,
        pressure=pressure,
        stiffness=contact.law.slope(closure),
        normal_force=float(weighted.sum()),
        friction_force=friction,
        force_on_a=force,
        closed_area=float(points.weight[closure > 0].sum()),
        area=float(points.weight.sum()),
    )


def uniqueness_at(
    tangent: Matrices, factors: Shifted, parities: Mapping[float, int | None], *, unstable: bool
) -> Uniqueness | None:
    """Return uniqueness information from a tangent; None if it is symmetric."""
    if tangent.symmetric:
        return None
    parity = parity_of(tangent, factors, unstable=unstable)
    return Uniqueness(parity, parities, _margin(tangent, factors))


def parity_of(tangent: Matrices, factors: Shifted, *, unstable: bool) -> int | None:
    """Return whether a tangent has an odd (1) or even (0) number of negative real eigenvalues.

    If ``unstable``, those of its symmetric part are subtracted; None if unknown.
    """
    parity = factors.parity()
    if parity is None or not unstable:
        return parity
    return (parity + count_below(tangent, 0.0)) % 2


def _margin(tangent: Matrices, factors: Shifted) -> float:
    """Return the inverse growth rate of A^-1 S, S the symmetric part of A, by power iteration."""
    S, growths = tangent.stiffness, []
    x = np.random.default_rng(S.comm.rank).standard_normal((S.getLocalSize()[0], 1))
    x /= norms(x, S.comm)
    for _ in range(_STEPS):
        x = factors.solve_block(times(S, x))
        growths.append(norms(x, S.comm)[0])
        x /= growths[-1]
    return float(1 / np.exp(np.log(growths[_STEPS // 2 :]).mean()))
