"""Norms of a reduced model: of states, and of residuals, the norm of the saddle problem.

    X = S(t0) + s M(t0)

with every parameter at its least value: K(t) is no softer in any direction while friction is left
aside. The shift s, a hundredth of omega^2 of the window, keeps X definite where bodies float. Bases
are orthonormal in X for displacements and in C^ for forces. A residual of forces v and gaps q is
measured by

    v^T X^-1 v + q^T (c_c C^ + J X^-1 J^T)^-1 q,

c_c where contacts are stiffest: up to a factor of three the energy of the displacements and forces
that it causes in the saddle problem without friction.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.blocks import times, transposed_times
from cea.eigen.multipliers import Multipliers
from cea.eigen.mumps import Mumps
from cea.eigen.pencil import Pencil
from cea.eigen.shifted import bordered
from cea.eigen.spectrum import SLOW
from cea.errors import InputError
from cea.matrices import block_diagonal, destroy, one_below_the_other, scaled_total
from cea.reduced.pieces import Pieces, Product

_FELT = 1e-10
"""Least compliance of contacts in the norm, relative to that of the bodies: closures that depend on
each other, or nearly, are told apart by rounding alone."""


class InnerProduct:
    """What bases are orthonormal in: ``image`` is its matrix times a block of this rank's rows."""

    def __init__(self, comm: Any, rows: int, image: Callable[[Floats], Floats]) -> None:
        self.comm, self.rows, self.image = comm, rows, image

    def inner(self, left: Floats, right: Floats) -> Floats:
        """L^T R, shape (columns of L, columns of R), the same on every rank."""
        return self.comm.bcast(self.comm.allreduce(left.T @ right))

    def lengths(self, block: Floats, image: Floats | None = None) -> Floats:
        """Norms of the columns of a block, whose image may be known, the same on every rank."""
        image = self.image(block) if image is None else image
        squares = self.comm.allreduce(np.einsum("ij,ij->j", block, image))
        return np.sqrt(np.maximum(self.comm.bcast(squares), 0.0))


class Norms:
    """Both norms with X and the saddle problem factorised, at some values of all parameters.

    ``states`` is that of bases, ``residuals`` that of what residuals cause
    (:meth:`caused`). Raises InputError when X is not positive definite.
    """

    def __init__(
        self, pencil: Pencil, pieces: Pieces, values: Mapping[str, float], max_frequency: float
    ) -> None:
        self.shift = (SLOW * 2 * np.pi * max_frequency) ** 2
        parts = []
        for term in pencil.terms:
            if term.symmetric and term.role in ("stiffness", "mass"):
                weight = term.coefficient.at(values) * (self.shift if term.role == "mass" else 1.0)
                parts.append((weight, term.matrix))
        matrix = scaled_total([part for part in parts if part[0]])
        matrix.setOption(matrix.Option.SYMMETRIC, True)
        self._made: list[Any] = [matrix]
        own, self._forces = slice(0, pieces.displacements), slice(pieces.displacements, pieces.rows)
        self._stiffness = pieces.acting(lambda block: times(matrix, block), own, own)
        factors = self._kept(Mumps(matrix.copy(), symmetric=True, inertia=True))
        if negative := factors.inertia()[0]:
            self.free()
            told = f"{negative} negative eigenvalues of its symmetric part"
            raise InputError("stiffness", told, "none, for a map, where parameters are least")
        self._flexible = pieces.acting(factors.solve_block, own, own)
        self._contacts = pieces.contacts
        nothing: Product = np.zeros_like
        self._gaps = self._reactions = self._softness = self._pressed = nothing
        if pencil.forces:
            self._factorise_saddle(pencil, pieces, values, matrix)
        comm = pieces.comm
        self.states = InnerProduct(comm, pieces.rows, self._image)
        self.residuals = InnerProduct(comm, pieces.rows, self._image_of_caused)

    def _factorise_saddle(
        self, pencil: Pencil, pieces: Pieces, values: Mapping[str, float], matrix: Any
    ) -> None:
        """What gaps and forces do without friction."""
        softness = [
            (max(each.inverse_stiffness.at(values), _FELT / each.body_stiffness[0]), each)
            for each in pencil.forces
        ]
        parts = [scaled_total([(c, each.compliance)]) for c, each in softness]
        closure = one_below_the_other([each.closure for each in pencil.forces])
        compliance = block_diagonal(parts).convert("aij")
        forces = Multipliers(closure, closure, compliance, None, 0)
        destroy(*parts)
        factors = self._kept(Mumps(bordered(matrix.copy(), forces, symmetric=True), symmetric=True))
        n = pieces.displacements
        self._made.append(forces)

        def pressed(gaps: Floats) -> Floats:
            """(c_c C^ + J X^-1 J^T)^-1 q."""
            rows = np.zeros((n + len(gaps), gaps.shape[1]), order="F")
            rows[n:] = gaps
            return -factors.solve_block(rows)[n : n + len(gaps)]

        own, below = slice(0, n), self._forces
        self._gaps = pieces.acting(lambda block: times(forces.closure, block), own, below)
        self._reactions = pieces.acting(
            lambda block: transposed_times(forces.closure, block), below, own
        )
        self._softness = pieces.acting(lambda block: times(forces.compliance, block), below, below)
        self._pressed = pieces.acting(pressed, below, below)

    def _image(self, block: Floats) -> Floats:
        """X x and C^ f."""
        image = self._stiffness(block)
        for contact in self._contacts:
            image += contact.compliance(block)
        return image

    def _image_of_caused(self, block: Floats) -> Floats:
        """X x and (c_c C^ + J X^-1 J^T) f."""
        moved = self._flexible(self._reactions(block))
        return self._stiffness(block) + self._gaps(moved) + self._softness(block)

    def solve(self, block: Floats) -> Floats:
        """X^-1 v, the static displacements under forces."""
        return self._flexible(block)

    def caused(self, block: Floats) -> Floats:
        """X^-1 v and (c_c C^ + J X^-1 J^T)^-1 q: inner products in ``residuals`` are of these."""
        return self._flexible(block) + self._pressed(block)

    def _kept[T](self, made: T) -> T:
        self._made.append(made)
        return made

    def free(self) -> None:
        """Free the factors."""
        for each in self._made:
            each.free() if hasattr(each, "free") else destroy(each)
        self._made.clear()
