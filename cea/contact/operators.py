"""Contact matrices of one interface: penalty at points, lumped, mortar, bonded.

    K_n = G^T D G,   K_f = T^T diag(mu) D G,   D = diag(w p)

The saddle form keeps G, T and D and leaves the products out (:mod:`cea.contact.saddle`).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, vstack

from cea.body import Body, Floats
from cea.contact.coupling import Coupling, Form
from cea.contact.interface import Interface, PointRule
from cea.contact.laws import Friction, NormalLaw
from cea.contact.lumping import lumped_matrices
from cea.contact.mortar import MortarProjection
from cea.errors import InputError
from cea.matrices import destroy, gather, product, symmetric_product, system_operator
from cea.ranks import agreed


@dataclass(frozen=True)
class HalfPass:
    """One side's points against the other, and what happens between them.

    Parameters
    ----------
    a, b
        Names of the bodies on its two sides.
    interface
        Its points, which lie on a.
    law
        What penetrations meet.
    friction
        Friction of steady sliding; None without.
    coupling
        What becomes of the gaps at the points.
    form
        Penalty or saddle form.
    pair
        Name of the contact it belongs to, where that is not its own: a full pass has two halves.
    penetration
        Penetrations at all points in the state that is linearised about (m), shape (n,); a linear
        law needs none.

    Raises
    ------
    InputError
        When law, friction, coupling and form do not go together.
    """

    a: str
    b: str
    interface: Interface
    law: NormalLaw
    friction: Friction | None = None
    coupling: Coupling = "pointwise"
    form: Form = "penalty"
    pair: str | None = None
    penetration: Floats | None = None

    def __post_init__(self) -> None:
        if self.form == "penalty" and np.isinf(self.stiffness).any():
            allowed = "finite; or, in the saddle form, infinite everywhere"
            raise InputError("p", float("inf"), allowed)
        if self.coupling == "bonded" and self.friction is not None and self.friction.acts:
            mu = float(np.max(self.friction.mu))
            raise InputError("mu", mu, "0 where both sides are bonded")
        if self.coupling == "lumped" and self.form == "saddle":
            allowed = "penalty: lumped contact is not of the form G^T D G"
            raise InputError("form", self.form, allowed)

    @property
    def stiffness(self) -> Floats:
        """Contact stiffness p at all points (N/m^3): the law's slope, shape (n,)."""
        points = len(self.interface.points)
        return self.law.slope(np.zeros(points) if self.penetration is None else self.penetration)


@dataclass(frozen=True)
class Contact:
    """Contact of one half pass in the unknowns of the whole system.

    Parameters
    ----------
    name
        Name of the half pass.
    half
        What it was made of.
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
    mu
        Friction coefficient that ``slip`` and ``friction`` were made with; 1 where it varies, or
        is zero and was not left out: they are then those of a factor 1, or of mu = 1.
    """

    name: str
    half: HalfPass
    rule: PointRule | MortarProjection
    gap: Any
    slip: Any | None
    weight: Any
    scale: float
    stiffness: Any | None
    friction: Any | None
    mu: float

    @property
    def pair(self) -> str:
        """Name of the contact it belongs to."""
        return self.half.pair or self.name

    @property
    def interface(self) -> Interface:
        """Its points."""
        return self.half.interface

    @property
    def P(self) -> float:
        """Global contact stiffness, the integral of p (N/m)."""
        return float(self.interface.points.weight @ self.half.stiffness)

    def pressure(self, x: Any) -> Floats:
        """Contact pressure (N/m^2) at every point, on every rank, for unknowns x.

        Raises
        ------
        InputError
            In the saddle form, whose forces are unknowns, and where the sides are bonded.
        """
        if self.half.form == "saddle" or self.half.coupling == "bonded":
            raise InputError(self.name, self.half.form, "a penalty contact that is not bonded")
        closed = self.gap.createVecLeft()
        self.gap.mult(x, closed)
        pressure = self.rule.pressure(gather(closed))
        destroy(closed)
        return pressure


def assemble_contact(
    bodies: Mapping[str, Body], name: str, half: HalfPass, *, leave_out: bool = True
) -> Contact:
    """Contact matrices of one half pass.

    Parameters
    ----------
    bodies
        All bodies of the system by name, in the order of the unknowns.
    name
        Name of the half pass.
    half
        The half pass.
    leave_out
        Whether the slip operator and K_f are left out where mu = 0.
    """
    interface, sides = half.interface, (half.a, half.b)
    points = interface.local_points
    stiffness, scale = _scaled(half)
    projected = half.coupling in ("mortar", "bonded")
    rule = (MortarProjection.of if projected else PointRule)(interface, stiffness)
    one = np.ones(len(points))
    directions = [points.normal]
    if half.coupling == "bonded":
        directions = [np.tile(axis, (len(points), 1)) for axis in np.eye(interface.a.dim)]
    jumps = [rule.jump(direction, one) for direction in directions]
    gap = _system_operator(bodies, sides, _stacked(jumps))
    weight = gap.createVecLeft()
    weight.array[:] = np.tile(rule.weight, len(directions))

    slip = direction = None
    field, mu = _friction_at(half)
    keeps = not leave_out and half.coupling != "bonded"
    if half.friction is not None and (half.friction.acts or keeps):
        with agreed(interface.comm):
            direction = half.friction.direction.at(points.x, points.normal)
        slip = _system_operator(bodies, sides, rule.jump(direction, field))

    normal = friction = None
    if half.coupling == "lumped":
        normal, friction = lumped_matrices(bodies, sides, interface, rule.weight, direction, field)
    elif half.form == "penalty":
        normal = symmetric_product(gap, weight)
        friction = product(slip, gap, weight) if slip is not None else None
    return Contact(name, half, rule, gap, slip, weight, scale, normal, friction, mu)


def _friction_at(half: HalfPass) -> tuple[Floats, float]:
    """Friction coefficient at the points of this rank, and what of it is its size."""
    interface = half.interface
    mu = np.asarray(half.friction.mu if half.friction is not None else 0.0, dtype=float)
    varies = np.ptp(mu) != 0
    if not varies and not mu.any():
        mu = np.ones_like(mu)
    field = np.broadcast_to(mu, len(interface.points))[interface.rows]
    return field, 1.0 if varies else float(mu.flat[0])


def _scaled(half: HalfPass) -> tuple[Floats, float]:
    """Stiffness at all points, and the factor kept apart from it."""
    weight, stiffness = half.interface.points.weight, half.stiffness
    if half.form == "penalty":
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
