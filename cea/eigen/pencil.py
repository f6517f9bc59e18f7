"""The parametric pencil: matrices as sums of constant terms with parametric coefficients.

    lambda^2 M(t) + lambda C(t) + K(t),    M, C, K = sum_j c_j(t) A_j

with coefficients c_j in named parameters t. K of a body scales with its E, M with its rho, K_n and
K_f of a contact with P and mu P; C holds both damping and gyroscopic terms. Contact forces may be
unknowns beside the displacements (:mod:`cea.eigen.multipliers`); circulatory terms of K are never
formed (:mod:`cea.eigen.unformed`). The same pencil serves single runs, sweeps, thresholds and
derivatives.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.eigen.block_products import times, transposed_times
from cea.eigen.coefficients import CONSTANT, Dependence, Parameter
from cea.eigen.multipliers import AllForces, ForcesOfContact, Multipliers, with_unformed
from cea.eigen.unformed import Circulatory, LowRank, UnformedTerm, Unknowns, low_rank_sum
from cea.errors import InputError
from cea.matrices import destroy, of_entries, scaled_total
from cea.petsc import Mat

Role = Literal["mass", "damping", "stiffness"]
POWERS: dict[Role, int] = {"mass": 2, "damping": 1, "stiffness": 0}
"""Power of lambda of each role."""


@dataclass(frozen=True)
class Term:
    """One term of a pencil: c(t) A."""

    role: Role  # the sum it belongs to
    matrix: Mat  # A, PETSc AIJ (n x n)
    coefficient: Dependence = CONSTANT  # c
    symmetric: bool = True  # whether A is exactly symmetric
    contact: bool = False  # whether A is the stiffness K_n of a contact, or its friction K_f


@dataclass(frozen=True)
class Matrices:
    """Matrices of a pencil at given parameters, PETSc AIJ; None where a sum has no terms."""

    stiffness: Mat  # symmetric part S of K (N/m)
    unsymmetric: Mat | None  # the rest of K, due to friction and damping of rotating bodies
    mass: Any  # M (kg), symmetric positive definite; None in statics
    contacts: Multipliers | None  # contact forces that are unknowns
    multipliers: Multipliers | None  # the same, followed by the unknowns of circulatory terms
    damping: Mat | None = None  # symmetric part of C (N s/m)
    gyroscopic: Mat | None = None  # the rest of C, due to rotation (N s/m)
    low_rank: LowRank | None = None  # low-rank terms of C (N s/m), not included in the above
    # returns matrices of few dofs near contacts that bound K and M from below, or None
    near: "Callable[[Matrices], Matrices | None] | None" = None

    @property
    def symmetric(self) -> bool:
        """True without friction and circulatory terms: K and the multipliers are symmetric."""
        forces = self.multipliers
        return self.unsymmetric is None and (forces is None or forces.symmetric)

    @property
    def conservative(self) -> bool:
        """True without friction, circulatory terms and damping; gyroscopic terms are allowed."""
        return self.symmetric and self.damping is None and self.low_rank is None

    @property
    def quadratic(self) -> bool:
        """True with damping or rotation, where the problem is not linear in kappa = -lambda^2."""
        return not (self.damping is None and self.gyroscopic is None and self.low_rank is None)

    @property
    def size(self) -> int:
        """Number of displacements over all ranks."""
        return int(self.stiffness.getSize()[0])

    @property
    def tied(self) -> int:
        """Number of independent constraints, which is the number of infinite kappa."""
        return 0 if self.multipliers is None else self.multipliers.tied

    def drag(self, x: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Return (C + Y) x, or (C + Y)^T x, for every column, the rows of this rank."""
        force = np.zeros_like(x)
        if self.damping is not None:
            force += times(self.damping, x)
        if self.gyroscopic is not None:
            force += (transposed_times if transposed else times)(self.gyroscopic, x)
        if self.low_rank is not None:
            force += self.low_rank.times(x, self.mass.comm)
        return force

    def operator(
        self, kappa: float = 0.0, rate: float = 0.0, *, symmetric_part: bool = False
    ) -> Mat:
        """Return K - kappa M + rate (C + Y) as a new PETSc AIJ matrix, K or its symmetric part S.

        Low-rank and circulatory terms are not included.
        """
        parts = [(1.0, self.stiffness)]
        if self.unsymmetric is not None and not symmetric_part:
            parts.append((1.0, self.unsymmetric))
        if kappa and self.mass is not None:
            parts.append((-kappa, self.mass))
        if rate:
            parts += [(rate, each) for each in (self.damping, self.gyroscopic) if each is not None]
        return scaled_total(parts)


class Pencil:
    """Terms of M, C and K with their coefficients in named parameters.

    Parameters
    ----------
    terms
        Terms; at least one of the stiffness is symmetric.
    parameters
        Every parameter that a coefficient depends on.
    forces
        Contact forces that are unknowns, by contact.
    low_rank, circulatory
        Low-rank terms of the damping, and circulatory terms of the stiffness.
    near
        Returns matrices near contacts that bound K and M from below, for given parameters and the
        matrices there, or None (:mod:`cea.system.near_contacts`).

    Raises
    ------
    InputError
        When a coefficient depends on a parameter that is not given.
    """

    def __init__(
        self,
        terms: Iterable[Term],
        parameters: Iterable[Parameter] = (),
        forces: Sequence[ForcesOfContact] = (),
        low_rank: Iterable[UnformedTerm[LowRank]] = (),
        circulatory: Iterable[UnformedTerm[Circulatory]] = (),
        near: Callable[[Mapping[str, float], Matrices], Matrices | None] | None = None,
    ) -> None:
        self.terms = tuple(terms)
        self.parameters = {parameter.name: parameter for parameter in parameters}
        self.forces = tuple(forces)
        self.low_rank = tuple(low_rank)
        self.circulatory = tuple(circulatory)
        self._near = near
        self._all_forces = AllForces(self.forces) if self.forces else None
        unknown = self.names - set(self.parameters)
        if unknown:
            raise InputError("parameters", sorted(self.parameters), f"with {sorted(unknown)}")

    @classmethod
    def of(cls, stiffness: Mat, mass: Mat | None = None) -> "Pencil":
        """Return the pencil lambda^2 M + K of PETSc AIJ matrices, K symmetric, M positive definite.

        K is in N/m, M in kg.
        """
        return cls([Term("stiffness", stiffness), *([Term("mass", mass)] if mass else [])])

    def at_rest(self) -> "Pencil":
        """Return the pencil of the stiffness alone, for static equilibria."""
        return Pencil(
            [term for term in self.terms if term.role == "stiffness"],
            self.parameters.values(),
            self.forces,
            circulatory=self.circulatory,
        )

    @property
    def names(self) -> frozenset[str]:
        """Parameters that the terms depend on."""
        every: list[Dependence] = [each.coefficient for each in self.terms]
        every += [each.coefficient for each in self.low_rank]
        every += [each.coefficient for each in self.circulatory]
        every += [c for each in self.forces for c in (each.inverse_stiffness, each.friction)]
        return frozenset(name for each in every for name in each.names)

    @property
    def damped(self) -> bool:
        """Whether there are damping or gyroscopic terms, for any parameters."""
        return bool(self.low_rank) or any(term.role == "damping" for term in self.terms)

    @property
    def comm(self) -> Any:
        """Communicator (petsc4py)."""
        return self.terms[0].matrix.comm

    def values(self, changes: Mapping[str, float] | None = None) -> dict[str, float]:
        """Return the values of all parameters with changes; InputError when one is not allowed."""
        values = {name: parameter.value for name, parameter in self.parameters.items()}
        for name, value in (changes or {}).items():
            values[name] = self.parameter(name).check(value)
        return values

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of a name; InputError when there is none."""
        if name not in self.parameters:
            allowed = ", ".join(sorted(self.parameters)) or "none: the pencil has no parameters"
            raise InputError("parameter", name, f"one of {allowed}")
        return self.parameters[name]

    def at(self, changes: Mapping[str, float] | None = None) -> Matrices:
        """Return the matrices at given parameters; others have their default values."""
        values = self.values(changes)
        stiffness = self._sum("stiffness", values, symmetric=True)
        if stiffness is None:
            raise InputError("terms", len(self.terms), "a symmetric piece of the stiffness")
        contacts = self._all_forces.at(values) if self._all_forces else None
        return Matrices(
            stiffness=stiffness,
            unsymmetric=self._sum("stiffness", values, symmetric=False),
            mass=self._sum("mass", values, symmetric=True),
            damping=self._sum("damping", values, symmetric=True),
            gyroscopic=self._sum("damping", values, symmetric=False),
            low_rank=self.low_rank_at(values),
            contacts=contacts,
            multipliers=with_unformed(contacts, self.circulatory_unknowns(values)),
            near=partial(self._near, values) if self._near else None,
        )

    def products(self) -> Iterator[tuple[Role, Dependence, Callable[[Any], Any]]]:
        """Yield role, coefficient and product with blocks of vectors of all terms but forces."""
        for term in self.terms:
            yield term.role, term.coefficient, partial(times, term.matrix)
        for piece in self.circulatory:
            yield "stiffness", piece.coefficient, piece.piece.times
        for of_modes in self.low_rank:
            yield "damping", of_modes.coefficient, partial(of_modes.piece.times, comm=self.comm)

    def circulatory_unknowns(self, values: Mapping[str, float]) -> list[Unknowns]:
        """Return the unknowns of circulatory terms that do not vanish at given parameters."""
        parts = [(term.coefficient.at(values), term.piece) for term in self.circulatory]
        return [piece.unknowns(factor) for factor, piece in parts if factor]

    def low_rank_at(self, values: Mapping[str, float]) -> LowRank | None:
        """Return the sum B B^T of low-rank terms at given parameters; None where all vanish."""
        parts = [(term.coefficient.at(values), term.piece) for term in self.low_rank]
        return low_rank_sum(parts, self.terms[0].matrix.getLocalSize()[0])

    def _sum(self, role: Role, values: Mapping[str, float], *, symmetric: bool) -> Mat | None:
        parts = [
            (coefficient, term.matrix)
            for term in self.terms
            if term.role == role
            and term.symmetric == symmetric
            and (coefficient := term.coefficient.at(values)) != 0
        ]
        if not parts:
            return None
        total = scaled_total(parts)
        if symmetric:
            total.setOption(total.Option.SYMMETRIC, True)
        return total


def release(matrices: Matrices) -> None:
    """Free the matrices, but not the terms of the pencil."""
    sums = (matrices.stiffness, matrices.unsymmetric, matrices.mass)
    destroy(*(m for m in (*sums, matrices.damping, matrices.gyroscopic) if m))
    contacts, multipliers = matrices.contacts, matrices.multipliers
    if contacts is not None:
        contacts.free()
    if multipliers is not None and multipliers is not contacts:
        multipliers.free()


def internal_forces(
    matrices: Matrices, x: NDArray[Any], f: NDArray[Any], *, transposed: bool = False
) -> NDArray[Any]:
    """Return K x + L^T f, or K^T x + J^T f, for blocks of displacements and multipliers."""
    force = times(matrices.stiffness, x)
    if matrices.unsymmetric is not None:
        force += (transposed_times if transposed else times)(matrices.unsymmetric, x)
    if (forces := matrices.multipliers) is not None:
        force += transposed_times(forces.closure if transposed else forces.reaction, f)
    return force


class Sizes:
    """Absolute values of the entries of a pencil, for estimates of rounding."""

    def __init__(self, matrices: Matrices) -> None:
        forces = matrices.multipliers
        self._stiffness = _absolute(matrices.stiffness, matrices.unsymmetric)
        self._damping = _absolute(matrices.damping, matrices.gyroscopic)
        self._mass = _absolute(matrices.mass)
        self._reaction = _absolute(None if forces is None else forces.reaction)
        self._low_rank = matrices.low_rank
        self._comm = matrices.stiffness.comm

    def forces(
        self, x: NDArray[Any], f: NDArray[Any], values: NDArray[Any] | float = 0.0
    ) -> Floats:
        """Return abs(P(lambda)) [abs(x); abs(f)], the rows of this rank, shape (n_local, n)."""
        size, speed = np.abs(x), np.abs(values)
        total = np.zeros(size.shape, order="F")
        for part in self._stiffness:
            total += times(part, size)
        for part in self._reaction:
            total += transposed_times(part, np.abs(f))
        if not np.any(speed):
            return total
        for part in self._mass:
            total += times(part, size) * speed**2
        for part in self._damping:
            total += times(part, size) * speed
        if self._low_rank is not None:
            total += self._low_rank.sizes(size, self._comm) * speed
        return total

    def free(self) -> None:
        """Free the matrices."""
        destroy(*self._stiffness, *self._damping, *self._mass, *self._reaction)


def _absolute(*matrices: Mat | None) -> list[Any]:
    """Return the absolute values of the entries of matrices that are not None."""
    return [of_entries(np.abs, each) for each in matrices if each is not None]
