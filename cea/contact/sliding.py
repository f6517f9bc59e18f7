"""What friction at a sliding speed makes of small velocities: damping, of either sign.

The traction of friction on side a is mu(v) sigma k, with the contact pressure sigma, the speed v of
steady sliding and k against the velocity of a relative to b. A small velocity changes speed and
direction of sliding, and with T_k and T_t, which take dofs to slips along k and along the tangent
t = n x k across it (in space only), the force - C dx/dt on the bodies has

    C = T_t^T diag(w mu sigma / v) T_t  +  T_k^T diag(w sigma mu'(v)) T_k

The first part, of the turning direction, always damps; the second one feeds energy in where
friction falls with the speed, mu' < 0 (Herve, Sinou, Mahe and Jezequel, European Journal of
Mechanics A/Solids 27, 2008, 141-160).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.body.unknowns import system_operator
from cea.contact.half_pass import friction_at
from cea.contact.interface import jump_along
from cea.contact.operators import Contact
from cea.errors import InputError
from cea.matrices import destroy, product, symmetric_product, symmetrised
from cea.petsc import PETSc
from cea.ranks import agreed


@dataclass(frozen=True)
class Sliding:
    """Steady sliding, as far as small velocities feel it.

    Parameters
    ----------
    speed
        v (m/s) at all points, positive, shape (n,); None where the direction of sliding is taken as
        if it did not turn.
    mu_slope
        mu'(v) (s/m) at all points, shape (n,); None for zero.
    pressure
        sigma (N/m^2) at all points, zero or positive, shape (n,); None takes that of the law at the
        penetrations of the state that is linearised about.
    """

    speed: Floats | None = None
    mu_slope: Floats | None = None
    pressure: Floats | None = None

    def __post_init__(self) -> None:
        if self.speed is not None and not (self.speed > 0).all():
            raise InputError("sliding.speed", float(self.speed.min()), "positive (m/s)")
        if self.pressure is not None and not (self.pressure >= 0).all():
            allowed = "zero or positive (N/m^2)"
            raise InputError("sliding.pressure", float(self.pressure.min()), allowed)


@dataclass(frozen=True)
class SlidingDamping:
    """Damping of one half pass that slides.

    Parameters
    ----------
    contact
        The half pass.
    sliding
        How it slides.
    turning
        C of the turning direction, PETSc AIJ (N s/m), symmetric, not negative; None without.
    slope
        C of the slope of friction, PETSc AIJ (N s/m), symmetric; None without.
    """

    contact: Contact
    sliding: Sliding
    turning: Any | None
    slope: Any | None

    @property
    def sizes(self) -> dict[str, float]:
        """Speed, slope and pressure that it was made with; 1 for those that vary."""
        given = {
            "speed": self.sliding.speed if self.turning is not None else None,
            "mu_slope": self.sliding.mu_slope,
            "pressure": self.sliding.pressure,
        }
        return {
            name: float(values[0]) if len(values) and np.ptp(values) == 0 else 1.0
            for name, values in given.items()
            if values is not None
        }


def damping_of(
    bodies: Mapping[str, Body], contacts: Sequence[Contact], sliding: Mapping[str, Sliding]
) -> tuple[SlidingDamping, ...]:
    """Damping of the half passes that slide; the halves of a full pass share the pressure.

    Parameters
    ----------
    bodies
        All bodies of the system by name, in the order of the unknowns.
    contacts
        All half passes.
    sliding
        How they slide, by name of the half pass, where that damps.

    Raises
    ------
    InputError
        As for :func:`sliding_damping`.
    """
    pairs = [contact.pair for contact in contacts]
    return tuple(
        sliding_damping(bodies, contact, sliding[contact.name], 1 / pairs.count(contact.pair))
        for contact in contacts
        if contact.name in sliding
    )


def sliding_damping(
    bodies: Mapping[str, Body], contact: Contact, sliding: Sliding, share: float = 1.0
) -> SlidingDamping:
    """Damping of a half pass that slides.

    Parameters
    ----------
    bodies
        All bodies of the system by name, in the order of the unknowns.
    contact
        The half pass, with friction or at least its direction.
    sliding
        How it slides.
    share
        Part of the pressure that is its own: one half of each half of a full pass.

    Raises
    ------
    InputError
        When the speed is given in the plane, the contact is bonded, or no pressure is known.
    """
    half, interface = contact.half, contact.interface
    if half.coupling == "bonded" or half.friction is None:
        raise InputError("sliding", half.coupling, "left out where nothing slides")
    if sliding.speed is not None and interface.a.dim < 3:
        allowed = "left out in the plane, where the direction of sliding cannot turn"
        raise InputError("sliding.speed", float(sliding.speed.flat[0]), allowed)
    points, rows = interface.local_points, interface.rows
    load = points.weight * _pressure(contact, sliding, share)[rows]
    with agreed(interface.comm):
        along = half.friction.direction.at(points.x, points.normal)

    def damping(direction: Floats, weight: Floats) -> Any:
        parts = dict(zip((half.a, half.b), jump_along(interface, direction), strict=True))
        slip = system_operator(bodies, parts, len(points))
        diagonal = slip.createVecLeft()
        diagonal.array[:] = weight
        matrix = _weighted(slip, diagonal)
        destroy(slip, diagonal)
        return matrix

    return SlidingDamping(
        contact,
        sliding,
        turning=_turning(damping, contact, sliding, load, along),
        slope=(
            damping(along, load * sliding.mu_slope[rows]) if sliding.mu_slope is not None else None
        ),
    )


def _turning(
    damping: Callable[[Floats, Floats], Any],
    contact: Contact,
    sliding: Sliding,
    load: Floats,
    along: Floats,
) -> Any | None:
    """C of the turning direction; none without speed, or where friction was left out."""
    if sliding.speed is None or contact.slip is None:
        return None
    field, _ = friction_at(contact.half)
    across = np.cross(contact.interface.local_points.normal, along)
    return damping(across, load * field / sliding.speed[contact.interface.rows])


def _pressure(contact: Contact, sliding: Sliding, share: float) -> Floats:
    """Contact pressure at all points (N/m^2), the share of the half pass."""
    if sliding.pressure is not None:
        return share * sliding.pressure
    if contact.half.penetration is None:
        allowed = "needed where no state of steady sliding tells it (N/m^2)"
        raise InputError("sliding.pressure", None, allowed)
    return np.maximum(contact.half.law.pressure(contact.half.penetration), 0.0)


def _weighted(slip: Any, weight: Any) -> Any:
    """T^T diag(w) T, symmetric to the last bit, for weights of any sign."""
    smallest = weight.min()[1]
    if smallest >= 0:
        return symmetric_product(slip, weight)
    matrix = symmetrised(product(slip, slip, weight))
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return matrix
