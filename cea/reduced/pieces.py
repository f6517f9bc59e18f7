"""Terms of a pencil as operators on states: displacements followed by contact forces.

    [ K   J^T - c_f R^T ] [x]
    [ J      -c_c C^    ] [f],    M and D on displacements alone

with K, M and D sums c_j(t) A_j; D holds damping and gyroscopic terms, modal damping as a product of
its factors. Contact forces are unknowns also where sides are tied: c_c is zero then
(:mod:`cea.eigen.multipliers`). Terms with equal coefficients are summed once.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.block_products import column_blocks, times, transposed_times
from cea.eigen.coefficients import CONSTANT, Coefficient, Dependence
from cea.eigen.multipliers import ForcesOfContact
from cea.eigen.mumps import Mumps
from cea.eigen.pencil import Pencil, Role
from cea.matrices import destroy, scaled_total
from cea.petsc import PETSc

Values = Mapping[str, float]
"""Values of all parameters of a pencil."""
Product = Callable[[Floats], Floats]
"""Function that applies an operator to a block of vectors, the rows of this rank."""


@dataclass(frozen=True)
class Piece:
    """A term c(t) A of a pencil, with functions that apply A and A^T to blocks of states."""

    role: Role
    coefficient: Dependence
    times: Product
    transposed: Product

    @property
    def symmetric(self) -> bool:
        """Whether A is symmetric."""
        return self.times is self.transposed


@dataclass(frozen=True, eq=False)
class ContactPiece:
    """A contact: rows of its forces in a state, products with C^ and its inverse, and J."""

    of: ForcesOfContact
    rows: slice
    compliance: Product
    inverse: Product
    closes: Piece


class Pieces:
    """All terms of a pencil with ``free`` parameters; states have ``rows`` rows on this rank."""

    def __init__(self, pencil: Pencil, free: Iterable[str]) -> None:
        self._made: list[Any] = []
        self._fixed, self.comm = pencil.values(), pencil.comm.tompi4py()
        self._free = frozenset(pencil.parameter(name).name for name in free)
        self.displacements = int(pencil.terms[0].matrix.getLocalSize()[0])
        forces = sum(each.closure.getLocalSize()[0] for each in pencil.forces)
        self.rows = self.displacements + int(forces)
        self.all = list(self._of_terms(pencil))
        for damping in pencil.low_rank:
            product: Product = partial(damping.piece.times, comm=pencil.comm)
            self.all.append(self._piece("damping", damping.coefficient, product, product))
        for term in pencil.circulatory:
            turned = partial(term.piece.times, transposed=True)
            self.all.append(self._piece("stiffness", term.coefficient, term.piece.times, turned))
        self.contacts, first = [], self.displacements
        for each in pencil.forces:
            rows = slice(first, first + each.closure.getLocalSize()[0])
            self.contacts.append(self._of_contact(each, rows))
            first = rows.stop

    def acting(self, product: Product, source: slice, target: slice) -> Product:
        """Return a product from some rows of states to others, which skips zero columns."""

        def acts(block: Floats) -> Floats:
            image = np.zeros((self.rows, block.shape[1]), order="F")
            some = np.flatnonzero(self.comm.allreduce(block[source].any(axis=0).astype(int)))
            for part in column_blocks(len(some)):
                image[target, some[part]] = product(np.asfortranarray(block[source, some[part]]))
            return image

        return acts

    def free(self) -> None:
        """Free all matrices and factors that were made from the terms of the pencil."""
        for each in self._made:
            each.free() if hasattr(each, "free") else destroy(each)
        self._made.clear()

    def _piece(self, role: Role, of: Dependence, product: Product, turned: Product) -> Piece:
        """Return a term that acts on displacements alone."""
        own = slice(0, self.displacements)
        image = self.acting(product, own, own)
        return Piece(role, of, image, image if turned is product else self.acting(turned, own, own))

    def _of_terms(self, pencil: Pencil) -> Iterator[Piece]:
        """Yield terms with matrices, summed where their coefficients are equal."""
        groups: dict[Any, tuple[Dependence, list[tuple[float, Any]]]] = {}
        for term in pencil.terms:
            varies = bool(term.coefficient.names & self._free)
            weight = 1.0 if varies else term.coefficient.at(self._fixed)
            if weight:
                of = term.coefficient if varies else CONSTANT
                key = term.role, term.symmetric, repr(of)
                groups.setdefault(key, (of, []))[1].append((weight, term.matrix))
        for (role, symmetric, _), (of, parts) in groups.items():
            matrix = self.kept(scaled_total(parts))
            product = partial(times, matrix)
            turned = product
            if not symmetric:
                turned = partial(times, self.kept(matrix.transpose(PETSc.Mat())))
            yield self._piece(role, of, product, turned)

    def _of_contact(self, forces: ForcesOfContact, rows: slice) -> ContactPiece:
        """Return a contact whose forces are unknowns; its terms are appended to ``all``."""
        bodies = slice(0, self.displacements)

        def across(matrix: Any) -> tuple[Product, Product]:
            gaps = self.acting(partial(times, matrix), bodies, rows)
            return gaps, self.acting(partial(transposed_times, matrix), rows, bodies)

        gaps, reactions = across(forces.closure)

        def both(block: Floats) -> Floats:
            return gaps(block) + reactions(block)

        closes = Piece("stiffness", CONSTANT, both, both)
        self.all.append(closes)
        if forces.slip is not None:
            slip, friction = across(forces.slip)
            self.all.append(Piece("stiffness", _negative(forces.friction), friction, slip))
        compliance = self.acting(partial(times, forces.compliance), rows, rows)
        softness = _negative(forces.inverse_stiffness)
        self.all.append(Piece("stiffness", softness, compliance, compliance))
        factors = self.kept(Mumps(forces.compliance.copy(), symmetric=True))
        inverse = self.acting(factors.solve_block, rows, rows)
        return ContactPiece(forces, rows, compliance, inverse, closes)

    def kept[T](self, made: T) -> T:
        """Return a matrix, or factors, that :meth:`free` frees."""
        self._made.append(made)
        return made


def _negative(coefficient: Coefficient) -> Coefficient:
    return replace(coefficient, factor=-coefficient.factor)
