"""Test functions of a pencil with friction that make the stiffness of its contacts symmetric.

They are S x + N z: S of :mod:`cea.eigen.turn`, node by node, is symmetric and turns forces of
contact with friction into normals, and z, displacements along the normals N of contacts, mends what
normals and directions of friction vary between nodes. For each x it has the least

    s z^T K z + e^T C e,     C e = L (S x + N z) - J x,

C the compliance of contacts and L and J as in :mod:`cea.eigen.multipliers`, K the stiffness of the
bodies: z vanishes where contact is soft, and where it is stiff L (S x + N z) = J x, but for what
would take large z, the fewer the larger s. For penalties P K_n = J^T C^-1 J, and e is eliminated.

So (z, e) = Q^-1 W x with Q symmetric. Neither is formed: both are kept among the unknowns, with the
constraint W x = Q (z, e) and its multipliers. Each pair adds a negative eigenvalue, and the inertia
of the whole tells of x. Contact forces f that are unknowns, J x = C f, add to x^T S^T K x

    (L (S x + N z))^T f = f^T C f + e^T J x.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.sparse import coo_array, csr_array

from cea.eigen.multipliers import Multipliers
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import force_scale
from cea.eigen.turn import Turn
from cea.matrices import (
    destroy,
    distributed,
    largest_row,
    local_part,
    one_below_the_other,
    scaled_total,
    symmetrised,
    transposed_product,
)
from cea.petsc import PETSc

_ROUNDING = 1e-13
"""What turning leaves of friction, relative to the largest entry of its row, that is rounding."""


@dataclass(frozen=True)
class Product:
    """A matrix A times turned test functions: x^T S^T A x and z^T N^T A x.

    Parameters
    ----------
    turned
        S^T A, PETSc AIJ.
    normal
        N^T A, PETSc AIJ.
    """

    turned: Any
    normal: Any

    def free(self) -> None:
        """Free both."""
        destroy(self.turned, self.normal)


@dataclass(frozen=True)
class TurnedTests:
    """S, N and what z is for each x.

    Parameters
    ----------
    turn
        S and N.
    inner, outer
        Q and W, PETSc AIJ.
    closure, compliance
        J and C of contact forces that are unknowns, rows scaled alike; None without.
    """

    turn: Turn
    inner: Any
    outer: Any
    closure: Any | None
    compliance: Any | None

    @classmethod
    def of(cls, matrices: Matrices, turn: Turn, weight: float) -> Self:
        """Those of a pencil.

        Parameters
        ----------
        matrices
            The pencil at given parameters; its closures do not depend on each other.
        turn
            S and N.
        weight
            s, 1 or more.
        """
        inner, outer = _of_penalties(matrices, turn, weight)
        if matrices.multipliers is None:
            return cls(turn, inner, outer, None, None)
        scale = force_scale(matrices.stiffness, matrices.multipliers)
        return cls._with_forces(matrices.multipliers, scale, turn, (inner, outer))

    @classmethod
    def _with_forces(
        cls, forces: Multipliers, scale: Any, turn: Turn, without: tuple[Any, Any]
    ) -> Self:
        """Q and W with contact forces, and factors on them; what is given is freed."""
        inner, outer = without
        closure, reaction, compliance = (
            matrix.copy() for matrix in (forces.closure, forces.reaction, forces.compliance)
        )
        closure.diagonalScale(L=scale)
        reaction.diagonalScale(L=scale)
        compliance.diagonalScale(L=scale, R=scale)
        turned = reaction.matMult(turn.matrix)
        rest = _difference(closure, turned)
        across = reaction.matMult(turn.normals)
        corner = scaled_total([(-1.0, compliance)])
        transposed = across.transpose(PETSc.Mat())
        blocks = [[inner, transposed], [across, corner]]
        both = PETSc.Mat().createNest(blocks).convert("aij")
        load = one_below_the_other([outer, rest])
        destroy(scale, reaction, turned, rest, across, corner, transposed, inner, outer)
        return cls(turn, both, load, closure, compliance)

    @property
    def constraints(self) -> int:
        """Number of z and e together."""
        return int(self.inner.getSize()[0])

    @property
    def forces(self) -> int:
        """Number of contact forces that are unknowns."""
        return 0 if self.closure is None else int(self.closure.getSize()[0])

    def product(self, matrix: Any) -> Product:
        """What the test functions make of a matrix on the displacements, PETSc AIJ."""
        return Product(
            transposed_product(self.turn.matrix, matrix),
            transposed_product(self.turn.normals, matrix),
        )

    def symmetric(self, product: Product, *, forces: bool = False) -> Any:
        """Symmetric part with the constraints, PETSc AIJ on (x, z, e, multipliers, f).

        (z, e)^T (Q (z, e) - W x) is added, which is zero where the constraints hold: none of the
        pivots of z is zero then, and ranks find them all.

        Parameters
        ----------
        product
            What is made symmetric.
        forces
            Whether contact forces work too.
        """
        form = symmetrised(product.turned.copy())
        across = self._across(product, forces=forces)
        factor = largest_row(form) / largest_row(self.inner)
        outer, inner = (scaled_total([(factor, each)]) for each in (self.outer, self.inner))
        across.axpy(-factor, self.outer, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        across.scale(0.5)
        against = scaled_total([(-1.0, inner)])
        made = [form, across, outer, inner, against]
        back = [each.transpose(PETSc.Mat()) for each in (across, outer)]
        blocks = [[form, *back], [across, inner, against], [outer, against, None]]
        if forces and self.closure is not None:
            pushed = self.closure.transpose(PETSc.Mat())
            corner = scaled_total([(-1.0, self.compliance)])
            made += [pushed, corner]
            blocks[0] += [pushed]
            blocks = [*blocks[:1], *([*row, None] for row in blocks[1:])]
            blocks.append([self.closure, None, None, corner])
        whole = PETSc.Mat().createNest(blocks).convert("aij")
        destroy(*made, *back)
        return whole

    def _across(self, product: Product, *, forces: bool) -> Any:
        """N^T A below, and J of forces or nothing, a new matrix on the rows of Q."""
        if self.closure is None:
            return product.normal.copy()
        below = self.closure.copy()
        if not forces:
            below.zeroEntries()
        result = one_below_the_other([product.normal, below])
        destroy(below)
        return result

    def free(self) -> None:
        """Free all but S and N."""
        destroy(self.inner, self.outer)
        destroy(*(each for each in (self.closure, self.compliance) if each is not None))


def _of_penalties(matrices: Matrices, turn: Turn, weight: float) -> tuple[Any, Any]:
    """Stiffness N^T (s K + P K_n) N, and N^T (P K_n - (P K_n - mu P K_f)^T S), new matrices."""
    along = transposed_product(turn.normals, matrices.stiffness)
    inner = along.matMult(turn.normals)
    inner.scale(weight)
    destroy(along)
    if not matrices.contacts or matrices.unsymmetric is None:
        outer = turn.normals.transpose(PETSc.Mat())
        outer.zeroEntries()
        return symmetrised(inner), outer
    normal = scaled_total(matrices.contacts)
    contact = scaled_total([(1.0, normal), (1.0, matrices.unsymmetric)])
    turned = transposed_product(contact, turn.matrix)
    rest = _difference(normal, turned)
    outer = transposed_product(turn.normals, rest)
    pressed = transposed_product(turn.normals, normal)
    own = pressed.matMult(turn.normals)
    inner.axpy(1.0 - weight, own, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    destroy(normal, contact, turned, rest, pressed, own)
    return symmetrised(inner), outer


def _difference(one: Any, other: Any) -> Any:
    """A - B without what is rounding beside the rows of A, PETSc AIJ."""
    left, right = local_part(one), local_part(other)
    rest = (left - right).tocoo()
    sizes = abs(left).max(axis=1).toarray().ravel()
    kept = np.abs(rest.data) > _ROUNDING * sizes[rest.row]
    entries = (rest.data[kept], (rest.row[kept], rest.col[kept]))
    rows = csr_array(coo_array(entries, shape=rest.shape))
    return distributed(rows, one.getSizes()[1], one.comm)
