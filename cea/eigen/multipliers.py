"""Contact forces as unknowns beside the displacements.

    [ K   L^T     ] [x]   [r]
    [ J   -C   Z  ] [f] = [0],     L = J - c_f R,   C = c_c C^
    [     Z^T     ] [e]   [0]

with J the closures (contact constraints), c_f R the friction part of the reactions, c_f
proportional to mu, and c_c = 1/P. Multipliers carry no mass. Where closures are linearly dependent,
Z removes the forces that they leave undetermined (:mod:`cea.eigen.dependent_closures`), and e is
zero.

Terms that are never formed, c L N^-1 J, may follow as unknowns of the same form, w = N^-1 J x
(:mod:`cea.eigen.unformed`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from cea.eigen.coefficients import Coefficient
from cea.eigen.dependent_closures import Dependence
from cea.eigen.unformed import Unknowns
from cea.matrices import block_diagonal, destroy, one_below_the_other, scaled_total, zeros
from cea.petsc import Mat, PETSc

_YIELDING = 1e-3
"""Compliance relative to that of the bodies above which dependent closures are harmless."""
_RIGID = 1e-13
"""Compliance relative to that of the bodies below which it counts as zero: the sides are tied."""
_DEPENDENT = 1e-11
"""Singular value of unit closures below which they count as dependent."""
_NEARLY_DEPENDENT = 1e-7
"""The same where all contacts are tied, so that rounding would determine their forces."""


@dataclass(frozen=True)
class ForcesOfContact:
    """Contact forces of one contact that are unknowns."""

    closure: Mat  # J, PETSc AIJ (forces x displacements)
    slip: Mat | None  # R, the same; None without friction
    compliance: Mat  # C^, PETSc AIJ (forces x forces), symmetric positive semidefinite
    inverse_stiffness: Coefficient  # c_c (m/N), 1/P, zero where the sides are tied
    friction: Coefficient  # c_f
    # P (N/m) at which the stiffest, and the softest, part of the contact is as stiff as the bodies
    body_stiffness: tuple[float, float]

    def reaction(self, values: Mapping[str, float]) -> Mat | None:
        """Return L at given parameters; None without friction."""
        factor = self.friction.at(values)
        if self.slip is None or not factor:
            return None
        return scaled_total([(1.0, self.closure), (-factor, self.slip)])

    def is_tied(self, values: Mapping[str, float]) -> bool:
        """Whether the compliance is zero up to rounding of that of the bodies."""
        return self.inverse_stiffness.at(values) * self.body_stiffness[1] < _RIGID


@dataclass(frozen=True)
class Multipliers:
    """Contact forces as unknowns: K x + L^T f = r, J x - C f + Z e = 0, Z^T f = 0."""

    closure: Mat  # J, PETSc AIJ (multipliers x displacements)
    reaction: Mat  # L, the same shape; without friction the same object as J
    compliance: Mat  # C (m/N), multipliers x multipliers; zero where the sides are tied
    border: Mat | None  # Z, multipliers x dependences; None where closures are independent
    tied: int  # number of independent constraints: closures without compliance

    @property
    def symmetric(self) -> bool:
        """True without friction."""
        return self.reaction is self.closure

    @property
    def size(self) -> int:
        """Number of multipliers."""
        return int(self.closure.getSize()[0])

    @property
    def dependent(self) -> int:
        """Number of closures that depend on others."""
        return 0 if self.border is None else int(self.border.getSize()[1])

    def free(self) -> None:
        """Free the matrices, but not the terms they were made of."""
        if not self.symmetric:
            destroy(self.reaction)
        if self.border is not None:
            destroy(self.border)
        destroy(self.closure, self.compliance)


class AllForces:
    """Contact forces of every contact whose forces are unknowns, at least one."""

    def __init__(self, parts: Sequence[ForcesOfContact]) -> None:
        self.parts = tuple(parts)
        self._dependences: dict[float, Dependence] = {}

    def at(self, values: Mapping[str, float]) -> Multipliers:
        """Return the matrices at given parameters, those of all contacts stacked."""
        scales = [part.inverse_stiffness.at(values) for part in self.parts]
        held = [part.is_tied(values) for part in self.parts]
        closures = [part.closure for part in self.parts]
        closure = reaction = one_below_the_other(closures)
        reactions = [part.reaction(values) for part in self.parts]
        if made := [each for each in reactions if each is not None]:
            both = zip(reactions, closures, strict=True)
            reaction = one_below_the_other([J if L is None else L for L, J in both])
            destroy(*made)
        compliances, tied, least = [], 0, inf
        for part, scale, is_tied in zip(self.parts, scales, held, strict=True):
            compliances.append(part.compliance.copy())
            compliances[-1].scale(0.0 if is_tied else scale)
            tied += part.closure.getSize()[0] if is_tied else 0
            least = min(least, scale * part.body_stiffness[0])
        compliance = block_diagonal(compliances).convert("aij")
        destroy(*compliances)
        border = None
        if least <= _YIELDING:
            tolerance = _NEARLY_DEPENDENT if all(held) else _DEPENDENT
            if tolerance not in self._dependences:
                rows = [each.getLocalSize()[0] for each in closures]
                self._dependences[tolerance] = Dependence.of(closure, rows, tolerance)
            dependence = self._dependences[tolerance]
            if dependence.size:
                border = dependence.border([part.compliance for part in self.parts], scales)
                tied -= dependence.within(held)
        return Multipliers(closure, reaction, compliance, border, tied)


def with_unformed(contacts: Multipliers | None, unknowns: Sequence[Unknowns]) -> Multipliers | None:
    """Return new matrices of contact forces followed by further unknowns, which are freed.

    Without further unknowns the contact forces are returned themselves.
    """
    if not unknowns:
        return contacts
    closures, reactions, compliances = (list(each) for each in zip(*unknowns, strict=True))
    made = [*closures, *reactions, *compliances]
    rows = sum(each.getLocalSize()[0] for each in closures)
    border = None
    if contacts is not None:
        closures.insert(0, contacts.closure)
        reactions.insert(0, contacts.reaction)
        compliances.insert(0, contacts.compliance)
        if contacts.border is not None:
            columns: Any = contacts.border.getSizes()[1]
            below = zeros((rows, PETSc.DETERMINE), columns, contacts.closure.comm)
            border = one_below_the_other([contacts.border, below])
            destroy(below)
    closure, reaction = one_below_the_other(closures), one_below_the_other(reactions)
    compliance = block_diagonal(compliances).convert("aij")
    destroy(*made)
    return Multipliers(closure, reaction, compliance, border, contacts.tied if contacts else 0)
