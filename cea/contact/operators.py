"""Contact matrices of one interface: penalty at points, lumped, mortar, bonded.

    K_n = G^T D G,   K_f = T^T diag(mu) D G,   D = diag(w p)

The saddle form keeps G, T and D and leaves the products out (:mod:`cea.contact.saddle`); mortar
and bonded contact do so in either form.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.contact.half_pass import HalfPass
from cea.contact.interface import Interface
from cea.contact.mortar import MortarProjection, eliminated, repeated
from cea.contact.reactions import MortarReactions, PointReactions, Reactions
from cea.errors import InputError
from cea.matrices import destroy, gather, product, symmetric_product


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
