"""Orthonormal bases of a reduced model, and its norms of states and of residuals.

The energy norm of displacements is that of

    X = S(t0) + s M(t0)

with every parameter at its least value: without friction K(t) is at least as stiff in every
direction. The shift s, a hundredth of omega^2 of the window, keeps X
definite where bodies float; it is larger where the stiffness is not positive. Bases are orthonormal
in X for displacements and in C^ for forces. The norm of a residual of forces v and gaps q is

    v^T X^-1 v + q^T (c_c C^ + J X^-1 J^T)^-1 q,

with c_c of the stiffest contacts. Up to a factor of three it is the energy of the displacements and
forces that the residual causes in the saddle problem without friction.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.block_products import beside, times
from cea.eigen.multipliers import Multipliers
from cea.eigen.mumps import Mumps
from cea.eigen.pencil import Pencil
from cea.eigen.shifted import bordered
from cea.eigen.spectrum import SLOW
from cea.errors import InputError
from cea.matrices import block_diagonal, destroy, one_below_the_other, scaled_total
from cea.reduced.pieces import Pieces, Product

_FELT = 1e-10
"""Least compliance of contacts in the norm relative to that of the bodies; with less, nearly
dependent closures would be separated by rounding alone."""
_SHIFTS = 60
"""Largest number of shifts tried, each four times the one before."""
_RESOLVED = 1e-6
"""Norm relative to the largest down to which a Gram matrix resolves directions."""
_PASSES = 6
"""Largest number of passes over a block; each resolves directions down to that fraction."""

_ROUNDING = 0.5
"""Norm of a unit vector after a second orthogonalisation below which it is dropped as rounding."""


class InnerProduct:
    """An inner product; ``image`` applies its matrix to a block, the rows of this rank."""

    def __init__(self, comm: Any, rows: int, image: Callable[[Floats], Floats]) -> None:
        self.comm, self.rows, self.image = comm, rows, image

    def inner(self, left: Floats, right: Floats) -> Floats:
        """Return the sum of L^T R over all ranks, the same on every rank."""
        return self.comm.bcast(self.comm.allreduce(left.T @ right))

    def lengths(self, block: Floats, image: Floats | None = None) -> Floats:
        """Return the norms of columns, the same on every rank; ``image`` may be given."""
        image = self.image(block) if image is None else image
        squares = self.comm.allreduce(np.einsum("ij,ij->j", block, image))
        return np.sqrt(np.maximum(self.comm.bcast(squares), 0.0))


class Norms:
    """Norms of states and residuals, with X and the saddle problem factorised at given parameters.

    The window ends at ``end`` (rad/s).
    ``states`` is the inner product of bases, ``residuals`` that of Riesz representatives of
    residuals (:meth:`caused`); ``solve`` returns X^-1 v, the static displacements under forces.
    """

    def __init__(
        self, pencil: Pencil, pieces: Pieces, values: Mapping[str, float], end: float
    ) -> None:
        matrix, factors, self.shift = _definite(pencil, values, end)
        pieces.kept(matrix)
        pieces.kept(factors)
        own = slice(0, pieces.displacements)
        self._stiffness = pieces.acting(partial(times, matrix), own, own)
        self.solve = pieces.acting(factors.solve_block, own, own)
        self._contacts = [
            (each, max(each.of.inverse_stiffness.at(values), _FELT / each.of.body_stiffness[0]))
            for each in pieces.contacts
        ]
        self._pressed: Product = np.zeros_like
        if self._contacts:
            below = slice(pieces.displacements, pieces.rows)
            self._pressed = pieces.acting(self._saddle(pieces, matrix), below, below)
        self.states = InnerProduct(pieces.comm, pieces.rows, self._image)
        self.residuals = InnerProduct(pieces.comm, pieces.rows, self._image_of_caused)

    def _saddle(self, pieces: Pieces, matrix: Any) -> Product:
        """Return a function that applies (c_c C^ + J X^-1 J^T)^-1 by the frictionless problem."""
        parts = [scaled_total([(soft, each.of.compliance)]) for each, soft in self._contacts]
        closure = one_below_the_other([each.of.closure for each in pieces.contacts])
        compliance = block_diagonal(parts).convert("aij")
        forces = pieces.kept(Multipliers(closure, closure, compliance, None, 0))
        destroy(*parts)
        factors = pieces.kept(
            Mumps(bordered(matrix.copy(), forces, symmetric=True), symmetric=True)
        )
        n = matrix.getLocalSize()[0]

        def pressed(gaps: Floats) -> Floats:
            rows = np.zeros((n + len(gaps), gaps.shape[1]), order="F")
            rows[n:] = gaps
            return -factors.solve_block(rows)[n : n + len(gaps)]

        return pressed

    def _image(self, block: Floats) -> Floats:
        """Return X x and C^ f."""
        image = self._stiffness(block)
        for contact, _ in self._contacts:
            image += contact.compliance(block)
        return image

    def _image_of_caused(self, block: Floats) -> Floats:
        """Return X x and (c_c C^ + J X^-1 J^T) f."""
        image, reactions = self._stiffness(block), np.zeros_like(block)
        for contact, _ in self._contacts:
            reactions += contact.closes.times(block)
        moved = self.solve(reactions)
        for contact, softness in self._contacts:
            image += contact.closes.times(moved) + softness * contact.compliance(block)
        return image

    def caused(self, block: Floats) -> Floats:
        """Return the Riesz representatives X^-1 v and (c_c C^ + J X^-1 J^T)^-1 q of residuals."""
        return self.solve(block) + self._pressed(block)


def _definite(pencil: Pencil, values: Mapping[str, float], end: float) -> tuple[Any, Mumps, float]:
    """Return X, its factors and the shift s, which is increased until X is positive definite."""
    first = (SLOW * end) ** 2
    for shift in (first * 4.0 ** np.arange(_SHIFTS)).tolist():
        parts = []
        for term in pencil.terms:
            if term.symmetric and term.role in ("stiffness", "mass"):
                weight = term.coefficient.at(values) * (shift if term.role == "mass" else 1.0)
                parts.append((weight, term.matrix))
        matrix = scaled_total([part for part in parts if part[0]])
        matrix.setOption(matrix.Option.SYMMETRIC, True)
        factors = Mumps(matrix.copy(), symmetric=True, inertia=True)
        negative = factors.inertia()[0]
        if not negative:
            return matrix, factors, shift
        factors.free()
        destroy(matrix)
    allowed = "a mass matrix without negative eigenvalues"
    raise InputError("mass", f"{negative} negative eigenvalues", allowed)


class Span:
    """An orthonormal basis of the span of all added blocks.

    ``vectors`` are the rows of this rank, shape (n_local, size).
    """

    def __init__(self, norm: InnerProduct) -> None:
        self.norm = norm
        self.vectors: Floats = np.empty((norm.rows, 0), order="F")

    @property
    def size(self) -> int:
        """Number of vectors."""
        return self.vectors.shape[1]

    def add(self, block: Floats, image: Floats, floor: float) -> tuple[Floats, float]:
        """Extend the basis by the span of a block, except directions with norms up to ``floor``.

        Returns the coordinates of the block in the basis, and the 2-norm of the part left out, as
        an operator on coefficients.
        """
        left, products = self._outside(block, image)
        lost = 0.0
        for _ in range(_PASSES):
            sizes, axes = np.linalg.eigh(products)
            largest = float(np.sqrt(max(sizes.max(initial=0.0), 0.0)))
            if largest <= floor:
                break
            kept = sizes > max(_RESOLVED * largest, floor) ** 2
            if not self._append(left @ (axes[:, kept] / np.sqrt(sizes[kept]))):
                lost = max(lost, largest)
            left = left @ axes[:, ~kept]
            left, products = self._outside(left, self.norm.image(left))
        return self.norm.inner(self.vectors, image), max(lost, largest if left.size else 0.0)

    def _outside(self, block: Floats, image: Floats) -> tuple[Floats, Floats]:
        """Return a block minus its projection on the span, and the Gram matrix of the rest."""
        left = block - self.vectors @ self.norm.inner(self.vectors, image)
        products = self.norm.inner(left, self.norm.image(left))
        return left, 0.5 * (products + products.T)

    def _append(self, block: Floats) -> bool:
        """Append vectors, orthonormalised once more; return whether none was mere rounding."""
        left, products = self._outside(block, self.norm.image(block))
        sizes, axes = np.linalg.eigh(products)
        kept = sizes > _ROUNDING**2
        self.vectors = beside(self.vectors, left @ (axes[:, kept] / np.sqrt(sizes[kept])))
        return bool(kept.all())
