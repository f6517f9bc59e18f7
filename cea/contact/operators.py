"""Contact matrices of one interface: penalty at points, lumped, mortar, bonded.

    K_n = G^T D G,   K_f = T^T diag(mu) D G,   D = diag(w p)

The saddle form keeps G, T and D and leaves the products out (:mod:`cea.contact.saddle`).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from scipy.sparse import csr_array, vstack

from cea.body import Body, Floats
from cea.contact.interface import Interface, PointRule
from cea.contact.lumping import lumped_matrices
from cea.contact.mortar import MortarProjection
from cea.errors import InputError
from cea.matrices import destroy, gather, product, symmetric_product, system_operator
from cea.ranks import agreed

Coupling = Literal["pointwise", "lumped", "mortar", "bonded"]
"""What becomes of the gaps at the points of an interface.

``pointwise``: a penalty at each; ``lumped``: the same, the blocks of each side summed onto their
diagonal; ``mortar``: the gap projected on the traces of side a; ``bonded``: as mortar, with every
component of the jump tied.
"""

Form = Literal["penalty", "saddle"]
"""Whether contact forces are eliminated (penalty) or unknowns of their own (saddle)."""


class TangentField(Protocol):
    """Direction of the friction traction on side a."""

    def at(self, x: Floats, normal: Floats) -> Floats:
        """Unit tangents (n, dim) at positions x (m) with unit normals."""
        ...


@dataclass(frozen=True)
class ContactLaw:
    """Contact stiffness and friction of an interface.

    Parameters
    ----------
    stiffness
        Contact stiffness p at all points of the interface (N/m^3), shape (n,) or one number;
        infinite everywhere or nowhere, and in the saddle form only.
    mu
        Friction coefficient there, shape (n,) or one number; 0 without friction.
    direction
        Direction of the friction traction on side a; needed when mu is not zero.
    coupling
        What becomes of the gaps at the points.
    form
        Penalty or saddle form.
    """

    stiffness: Floats | float
    mu: Floats | float = 0.0
    direction: TangentField | None = None
    coupling: Coupling = "pointwise"
    form: Form = "penalty"

    def __post_init__(self) -> None:
        p, mu = np.asarray(self.stiffness), np.asarray(self.mu)
        if not (p > 0).all():
            raise InputError("p", float(p.min()), "positive (N/m^3)")
        if np.isinf(p).any() and not (self.form == "saddle" and np.isinf(p).all()):
            allowed = "finite; or, in the saddle form, infinite everywhere"
            raise InputError("p", float("inf"), allowed)
        if not (mu >= 0).all():
            raise InputError("mu", float(mu.min()), "zero or positive")
        if self.frictional and self.direction is None:
            raise InputError("friction_direction_on_a", None, "needed when mu is not zero")
        if self.frictional and self.coupling == "bonded":
            raise InputError("mu", float(mu.max()), "0 where both sides are bonded")
        if self.coupling == "lumped" and self.form == "saddle":
            allowed = "penalty: lumped contact is not of the form G^T D G"
            raise InputError("form", self.form, allowed)

    @property
    def frictional(self) -> bool:
        """True where there is any friction."""
        return bool(np.any(np.asarray(self.mu) != 0))


@dataclass(frozen=True)
class Contact:
    """Contact of one half pass in the unknowns of the whole system.

    Parameters
    ----------
    name
        Name of the half pass.
    pair
        Name of the contact it belongs to; a full pass has two halves.
    body_a, body_b
        Names of the bodies on its two sides.
    interface
        Its points.
    law
        Its stiffness and friction.
    rule
        What makes rows of G of the points: the points themselves, or multipliers.
    gap
        G, PETSc AIJ (rows x free dofs).
    slip
        diag(mu) T, PETSc AIJ (rows x free dofs), None without friction.
    weight
        Diagonal of D, PETSc vector (rows); in the saddle form divided by ``scale``.
    scale
        P, the integral of p (N/m), where it is kept apart from D; 1 in the penalty form.
    stiffness
        K_n, PETSc AIJ, symmetric positive semidefinite (N/m); None in the saddle form.
    friction
        K_f, PETSc AIJ, unsymmetric (N/m); None without friction and in the saddle form.
    """

    name: str
    pair: str
    body_a: str
    body_b: str
    interface: Interface
    law: ContactLaw
    rule: PointRule | MortarProjection
    gap: Any
    slip: Any | None
    weight: Any
    scale: float
    stiffness: Any | None
    friction: Any | None

    def pressure(self, x: Any) -> Floats:
        """Contact pressure (N/m^2) at every point, on every rank, for unknowns x.

        Raises
        ------
        InputError
            In the saddle form, whose forces are unknowns, and where the sides are bonded.
        """
        if self.law.form == "saddle" or self.law.coupling == "bonded":
            raise InputError(self.name, self.law.form, "a penalty contact that is not bonded")
        closed = self.gap.createVecLeft()
        self.gap.mult(x, closed)
        pressure = self.rule.pressure(gather(closed))
        destroy(closed)
        return pressure


def assemble_contact(
    bodies: Mapping[str, Body],
    name: str,
    pair: str,
    sides: tuple[str, str],
    interface: Interface,
    law: ContactLaw,
    *,
    leave_out: bool = True,
) -> Contact:
    """Contact matrices of one half pass.

    Parameters
    ----------
    bodies
        All bodies of the system by name, in the order of the unknowns.
    name, pair
        Names of the half pass and of its contact.
    sides
        Names of bodies a and b.
    interface
        Its points.
    law
        Its stiffness and friction.
    leave_out
        Whether the slip operator and K_f are left out where mu = 0.
    """
    points = interface.local_points
    stiffness, scale = _scaled(law, interface)
    projected = law.coupling in ("mortar", "bonded")
    rule = (MortarProjection.of if projected else PointRule)(interface, stiffness)
    one = np.ones(len(points))
    directions = [points.normal]
    if law.coupling == "bonded":
        directions = [np.tile(axis, (len(points), 1)) for axis in np.eye(interface.a.dim)]
    jumps = [rule.jump(direction, one) for direction in directions]
    gap = _system_operator(bodies, sides, _stacked(jumps))
    weight = gap.createVecLeft()
    weight.array[:] = np.tile(rule.weight, len(directions))

    slip = direction = None
    mu = np.broadcast_to(law.mu, len(interface.points))[interface.rows]
    if law.direction is not None and (law.frictional or not leave_out):
        with agreed(interface.comm):
            direction = law.direction.at(points.x, points.normal)
        slip = _system_operator(bodies, sides, rule.jump(direction, mu))

    normal = friction = None
    if law.coupling == "lumped":
        normal, friction = lumped_matrices(bodies, sides, interface, rule.weight, direction, mu)
    elif law.form == "penalty":
        normal = symmetric_product(gap, weight)
        friction = product(slip, gap, weight) if slip is not None else None
    return Contact(
        name=name,
        pair=pair,
        body_a=sides[0],
        body_b=sides[1],
        interface=interface,
        law=law,
        rule=rule,
        gap=gap,
        slip=slip,
        weight=weight,
        scale=scale,
        stiffness=normal,
        friction=friction,
    )


def _scaled(law: ContactLaw, interface: Interface) -> tuple[Floats, float]:
    """Stiffness at all points, and the factor kept apart from it."""
    weight = interface.points.weight
    stiffness = np.broadcast_to(np.asarray(law.stiffness, dtype=float), len(weight))
    if law.form == "penalty":
        return stiffness, 1.0
    if np.isinf(stiffness).all():
        return np.full(len(weight), 1 / weight.sum()), np.inf
    scale = float(weight @ stiffness)
    return stiffness / scale, scale


def _stacked(jumps: list[tuple[csr_array, csr_array]]) -> tuple[csr_array, csr_array]:
    """Rows of several jumps one below the other."""
    part_a, part_b = (csr_array(vstack(parts)) for parts in zip(*jumps, strict=True))
    return part_a, part_b


def _system_operator(
    bodies: Mapping[str, Body], sides: tuple[str, str], jump: tuple[csr_array, csr_array]
) -> Any:
    """Parts of a jump on a and b as one operator on the unknowns of the whole system."""
    return system_operator(bodies, dict(zip(sides, jump, strict=True)), jump[0].shape[0])
