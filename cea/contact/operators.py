"""Contact matrices of one interface: penalty at points, lumped, mortar, bonded.

    K_n = G^T D G,   K_f = T^T diag(mu) D G,   D = diag(w p)

The saddle form keeps G, T and D and leaves the products out (:mod:`cea.contact.saddle`); mortar
and bonded contact do so in either form.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cea.body import Body, Floats
from cea.contact.coupling import Coupling, Form
from cea.contact.interface import Interface, jump_along
from cea.contact.laws import Friction, NormalLaw
from cea.contact.lumping import lumped_matrices
from cea.contact.mortar import MortarProjection, eliminated, repeated
from cea.contact.reactions import MortarReactions, PointReactions, Reactions
from cea.errors import InputError
from cea.matrices import (
    destroy,
    gather,
    one_below_the_other,
    product,
    symmetric_product,
    system_operator,
)
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
        Penalty or saddle form; None leaves the choice to :func:`cea.contact.forms.chosen_forms`.
    pair
        Name of the contact it belongs to, where that is not its own: a full pass has two halves.
    added_gap
        What is added to the distance of the sides (m), at all points, shape (n,), or one number; a
        linear law takes the sides to touch.
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
    form: Form | None = None
    pair: str | None = None
    added_gap: Floats | float = 0.0
    penetration: Floats | None = None

    def __post_init__(self) -> None:
        tied = np.isinf(self.stiffness).any()
        if tied and (self.form == "penalty" or self.coupling == "lumped"):
            allowed = "finite; or, in the saddle form, infinite everywhere"
            raise InputError("p", float("inf"), allowed)
        if self.coupling == "bonded" and self.friction is not None and self.friction.acts:
            mu = float(np.max(self.friction.mu))
            raise InputError("mu", mu, "0 where both sides are bonded")
        if self.coupling == "lumped" and self.form == "saddle":
            allowed = "penalty: lumped contact is not of the form G^T D G"
            raise InputError("form", self.form, allowed)
        if not self.law.linear:
            self._check_law()

    def _check_law(self) -> None:
        """Refuse what cannot meet its gaps by a law that is not linear."""
        if self.coupling in ("lumped", "bonded"):
            allowed = "pointwise or mortar for a law of the gap: here no gap at the points decides"
            raise InputError("coupling", self.coupling, allowed)
        if self.projected and self.form == "saddle":
            allowed = "penalty where a law meets projected gaps: open parts have no compliance"
            raise InputError("form", self.form, allowed)

    @property
    def stiffness(self) -> Floats:
        """Contact stiffness p at all points (N/m^3): the law's slope, shape (n,)."""
        points = len(self.interface.points)
        return self.law.slope(np.zeros(points) if self.penetration is None else self.penetration)

    @property
    def projected(self) -> bool:
        """Whether gaps are projected on the traces of side a."""
        return self.coupling in ("mortar", "bonded")

    @property
    def pressure(self) -> Floats:
        """Contact pressure at all points in the state that is linearised about (N/m^2), (n,).

        Raises
        ------
        InputError
            Where no such state is known: the law is linear, or was not linearised yet.
        """
        if self.penetration is None:
            raise InputError("penetration", None, "that of a steady sliding state")
        return self.law.pressure(self.penetration)


@dataclass(frozen=True)
class Contact:
    """Contact of one half pass in the unknowns of the whole system.

    Parameters
    ----------
    name
        Name of the half pass.
    half
        What it was made of.
    gap
        G, PETSc AIJ (points x free dofs); projected, B (multipliers x free dofs).
    slip
        diag(mu) T or B_k, PETSc AIJ as the gap, None without friction.
    mu
        Friction coefficient that ``slip`` was made with; 1 where it varies, or is zero and was not
        left out: it is then that of a factor 1, or of mu = 1.
    projection
        Projection on the traces of side a; None where points stand for themselves.
    lumped
        K_n and K_f of lumped contact; None of others.
    prescribed
        What displacements that supports prescribe close of the gap at all points (m), shape (n,);
        None where they close nothing.
    """

    name: str
    half: HalfPass
    gap: Any
    slip: Any | None
    mu: float
    projection: MortarProjection | None = None
    lumped: tuple[Any, Any | None] | None = None
    prescribed: Floats | None = None

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

    @property
    def has_pressure(self) -> bool:
        """Whether gaps tell the contact pressure: the sides are neither tied nor bonded."""
        return self.half.coupling != "bonded" and bool(np.isfinite(self.P))

    @property
    def keeps_forces(self) -> bool:
        """Whether its forces are unknowns of what is solved.

        Where a law meets projected gaps they are not: open parts have no compliance.
        """
        projected = self.projection is not None and self.half.law.linear
        return projected or self.half.form == "saddle"

    @property
    def stiffness(self) -> Any:
        """K_n, PETSc AIJ, symmetric positive semidefinite (N/m); full where gaps are projected."""
        return self._eliminated[0]

    @property
    def friction(self) -> Any | None:
        """K_f, PETSc AIJ, unsymmetric (N/m); None without friction."""
        return self._eliminated[1]

    @cached_property
    def _eliminated(self) -> tuple[Any, Any | None]:
        """K_n and K_f, made when they are first asked for."""
        if self.lumped is not None:
            return self.lumped
        if not self.half.law.linear:
            return self.reactions.tangent(self.half.stiffness)
        if self.projection is not None:
            compliance = self.compliance(self.half.stiffness)
            matrices = eliminated(compliance, self.gap, self.slip)
            destroy(compliance)
            return matrices
        weight = self.weight(self.half.stiffness)
        normal = symmetric_product(self.gap, weight)
        friction = product(self.slip, self.gap, weight) if self.slip is not None else None
        destroy(weight)
        return normal, friction

    @cached_property
    def reactions(self) -> Reactions:
        """What it does at any state, for a law that is not linear."""
        if self.projection is not None:
            return MortarReactions(self.projection, self.gap, self.slip)
        return PointReactions(self.interface, self.gap, self.slip)

    def weight(self, stiffness: Floats) -> Any:
        """Diagonal of D = w p (N/m), PETSc vector, for a stiffness p at all points (N/m^3)."""
        weight = self.gap.createVecLeft()
        rows = self.interface.rows
        weight.array[:] = self.interface.local_points.weight * stiffness[rows]
        return weight

    def compliance(self, stiffness: Floats) -> Any:
        """M where gaps are projected, PETSc AIJ, for a stiffness p at all points (N/m^3)."""
        assert self.projection is not None
        one = self.projection.compliance(stiffness)
        if self.half.coupling != "bonded":
            return one
        every = repeated(one, self.interface.a.dim)
        destroy(one)
        return every

    def pressure(self, x: Any) -> Floats:
        """Contact pressure (N/m^2) at every point, on every rank, for unknowns x.

        It is made of gaps, which hold the fewer digits the stiffer the contact. Of a law that is
        not linear it is the change of pressure that small motions x make.

        Raises
        ------
        InputError
            Where the sides are tied, and no gap tells the pressure, or bonded.
        """
        if not self.has_pressure:
            raise InputError(self.name, self.P, "a finite stiffness, and sides that are not bonded")
        if not self.half.law.linear:
            return self.half.stiffness * self.reactions.approach(x)
        closed = self.gap.createVecLeft()
        self.gap.mult(x, closed)
        if self.projection is None:
            pressure = self.half.stiffness * gather(closed)
        else:
            pressure = self.projection.pressure(self.half.stiffness, closed)
        destroy(closed)
        return pressure


def assemble_contact(
    bodies: Mapping[str, Body], name: str, half: HalfPass, *, leave_out: bool = True
) -> Contact:
    """Contact operators of one half pass.

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
    projection = None
    if half.projected:
        # Of a linear law, open points have no part in the projection: their compliance is infinite.
        bearing = half.stiffness > 0 if half.law.linear else None
        projection = MortarProjection.of(interface, bearing)

    def operator(direction: Floats) -> Any:
        parts = dict(zip(sides, jump_along(interface, direction), strict=True))
        jump = system_operator(bodies, parts, len(points))
        if projection is None:
            return jump
        integrals = projection.integrals(jump)
        destroy(jump)
        return integrals

    if half.coupling == "bonded":
        axes = [operator(np.tile(axis, (len(points), 1))) for axis in np.eye(interface.a.dim)]
        gap = one_below_the_other(axes)
        destroy(*axes)
    else:
        gap = operator(points.normal)
    slip = direction = None
    field, mu = friction_at(half)
    keeps = not leave_out and half.coupling != "bonded"
    if half.friction is not None and (half.friction.acts or keeps):
        with agreed(interface.comm):
            direction = half.friction.direction.at(points.x, points.normal)
        slip = operator(field[:, None] * direction)
    lumped = None
    if half.coupling == "lumped":
        weight = points.weight * half.stiffness[interface.rows]
        lumped = lumped_matrices(bodies, sides, interface, weight, direction, field)
    closed = prescribed_closure(bodies, half)
    return Contact(name, half, gap, slip, mu, projection, lumped, closed)


def prescribed_closure(bodies: Mapping[str, Body], half: HalfPass) -> Floats | None:
    """What displacements that supports prescribe close of the gap at all points (m), shape (n,).

    None where nothing is prescribed, or nothing of it reaches the contact.
    """
    interface = half.interface
    jumps = jump_along(interface, interface.local_points.normal)
    closed = np.zeros(len(interface.local_points))
    for name, jump in zip((half.a, half.b), jumps, strict=True):
        prescribed = bodies[name].prescribed
        if prescribed is not None:
            closed += jump @ gather(prescribed)
    every = np.concatenate(interface.comm.allgather(closed))
    return every if every.any() else None


def friction_at(half: HalfPass) -> tuple[Floats, float]:
    """Friction coefficient at the points of this rank, and what of it is its size.

    Where it is zero everywhere, 1 stands in its place.
    """
    interface = half.interface
    mu = np.asarray(half.friction.mu if half.friction is not None else 0.0, dtype=float)
    varies = np.ptp(mu) != 0
    if not varies and not mu.any():
        mu = np.ones_like(mu)
    field = np.broadcast_to(mu, len(interface.points))[interface.rows]
    return field, 1.0 if varies else float(mu.flat[0])
