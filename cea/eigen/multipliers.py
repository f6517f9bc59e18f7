"""Contact forces as unknowns beside the displacements: the saddle form of a contact.

    [ K   L^T ] [x]   [r]
    [ J   -C  ] [f] = [0],     L = J - c_f R,   C = c_c I

with J the normalised gaps, R what friction adds to their reactions, c_f proportional to mu and
c_c = 1/P. Multipliers carry no mass.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cea.eigen.parameters import Coefficient
from cea.matrices import destroy, scaled_total
from cea.petsc import Mat, PETSc, Vec


@dataclass(frozen=True)
class ForcesOfContact:
    """Contact forces of one contact that are unknowns.

    Parameters
    ----------
    closure
        J, PETSc AIJ (forces x displacements).
    slip
        R, PETSc AIJ (forces x displacements); None without friction.
    compliance
        c_c (m/N), 1/P; zero where the sides are tied.
    friction
        c_f.
    """

    closure: Mat
    slip: Mat | None
    compliance: Coefficient
    friction: Coefficient

    def at(self, values: Mapping[str, float], *, leave_out: bool = True) -> "Multipliers":
        """Matrices at given parameters; without friction L is J, if what is zero is left out."""
        factor, reaction = self.friction.at(values), self.closure
        if self.slip is not None and (factor != 0 or not leave_out):
            reaction = scaled_total([(1.0, self.closure), (-factor, self.slip)])
        compliance = self.closure.createVecLeft()
        compliance.set(self.compliance.at(values))
        return Multipliers(self.closure, reaction, compliance)


@dataclass(frozen=True)
class Multipliers:
    """Contact forces as unknowns: K x + L^T f = r, J x - C f = 0.

    Parameters
    ----------
    closure
        J, PETSc AIJ (multipliers x displacements).
    reaction
        L, PETSc AIJ (multipliers x displacements); the same object as J without friction.
    compliance
        Diagonal of C = 1/P (m/N), PETSc vector (multipliers); zero where the sides are tied.
    stacked
        Whether J was made of those of several contacts, rather than being a piece itself.
    """

    closure: Mat
    reaction: Mat
    compliance: Vec
    stacked: bool = False

    @property
    def symmetric(self) -> bool:
        """True without friction."""
        return self.reaction is self.closure

    @property
    def size(self) -> int:
        """Number of multipliers."""
        return int(self.closure.getSize()[0])

    def free(self) -> None:
        """Free what was made of the pieces, not the pieces."""
        if not self.symmetric:
            destroy(self.reaction)
        if self.stacked:
            destroy(self.closure)
        destroy(self.compliance)


def stacked(parts: Sequence[Multipliers]) -> Multipliers | None:
    """Multipliers of several contacts, one below the other on each rank; None of none."""
    if len(parts) < 2:
        return parts[0] if parts else None
    symmetric = all(part.symmetric for part in parts)
    closure = _one_below_the_other([part.closure for part in parts])
    reaction = closure
    if not symmetric:
        reaction = _one_below_the_other([part.reaction for part in parts])
    compliance = closure.createVecLeft()
    first = 0
    for part in parts:
        last = first + part.compliance.getLocalSize()
        compliance.array[first:last] = part.compliance.array_r
        first = last
        part.free()
    return Multipliers(closure, reaction, compliance, stacked=True)


def _one_below_the_other(blocks: Sequence[Mat]) -> Mat:
    return PETSc.Mat().createNest([[block] for block in blocks]).convert("aij")
