"""A pencil factorised at a shift: displacements, and contact forces where they are unknowns.

With forces f as unknowns (:mod:`cea.eigen.multipliers`) the matrix at kappa = -lambda^2 is

    A(kappa) = [ K - kappa M   L^T     ]
               [      J        -C   Z  ]
               [               Z^T     ]

and the displacement part of A(kappa)^-1 [r; 0] is what drivers iterate with: multipliers carry no
mass, and Krylov spaces stay ones of displacements. Circulatory pieces of K are unknowns beside the
forces.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array

from cea.arrays import Floats
from cea.eigen.factorisation import Refined
from cea.eigen.multipliers import Multipliers, with_circulatory
from cea.eigen.mumps import Mumps
from cea.eigen.pencil import Matrices
from cea.matrices import destroy, distributed, identity, largest_row, local_part
from cea.petsc import PETSc

_OF_NODES = 6
"""A multiple of the unknowns that a node has, in the plane and in space."""
_NEAR = 100.0
"""Shifts, relative to the first, between which a matrix is moved in place."""


class Shifted:
    """A(kappa) factorised; what a driver solves for displacements with.

    Parameters
    ----------
    matrices
        The pencil at given parameters.
    kappa
        The shift (1/s^2).
    near
        Nearby factors to be refined, instead of factors of its own.

    Raises
    ------
    ConvergenceError
        When A(kappa) is singular.
    """

    def __init__(
        self, matrices: Matrices, kappa: float = 0.0, *, near: "Shifted | None" = None
    ) -> None:
        self.kappa = self._first = kappa
        self.matrices = matrices
        self._multipliers, circulatory = matrices.multipliers, matrices.circulatory
        if circulatory is not None:
            self._multipliers = with_circulatory(matrices.multipliers, circulatory)
        self._local = matrices.stiffness.getLocalSize()[0]
        self._scale: Any | None = None
        self._own_scale = near is None
        operator = self._operator(near)
        self._factors: Mumps | Refined = (
            Refined(operator, near._factors)
            if near
            else Mumps(operator, symmetric=matrices.symmetric)
        )
        self._x: Any | None = None
        self._b: Any | None = None
        if self._multipliers is not None:
            self._x, self._b = operator.createVecRight(), operator.createVecLeft()

    def _operator(self, near: "Shifted | None" = None) -> Any:
        """A(kappa), with the contact forces."""
        operator = self.matrices.operator(self.kappa)
        if self._multipliers is None:
            return operator
        self._scale = near._scale if near else force_scale(operator, self._multipliers)
        whole = bordered(
            operator, self._multipliers, self._scale, symmetric=self.matrices.symmetric
        )
        destroy(operator)
        return whole

    @property
    def multipliers(self) -> int:
        """Number of contact forces on this rank that are unknowns."""
        forces = self.matrices.multipliers
        return 0 if forces is None else int(forces.compliance.getLocalSize()[0])

    def move(self, kappa: float) -> None:
        """Factorise at another shift instead.

        Raises
        ------
        ConvergenceError
            When A(kappa) is singular.
        """
        if kappa == self.kappa:
            return
        assert isinstance(self._factors, Mumps)
        before, self.kappa = self.kappa, kappa
        # Digits of K are lost in a matrix that was shifted far.
        near = max(abs(before), abs(kappa)) <= _NEAR * abs(self._first)
        if self._multipliers is None and near:
            subset = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
            self._factors.matrix.axpy(before - kappa, self.matrices.mass, structure=subset)
            self._factors.factorise()
            return
        self._factors.free()
        if self._scale is not None and self._own_scale:
            destroy(self._scale)
        self._factors = Mumps(self._operator(), symmetric=self.matrices.symmetric)

    def solve(self, b: Any, x: Any, *, transposed: bool = False) -> None:
        """Displacements x for forces b on the bodies, PETSc vectors."""
        if self._x is None or self._b is None:
            self._factors.solve(b, x, transposed=transposed)
            return
        self._b.set(0.0)
        self._b.array[: self._local] = b.array_r
        self._factors.solve(self._b, self._x, transposed=transposed)
        x.array[:] = self._x.array_r[: self._local]

    def solve_block(self, b: Floats, *, transposed: bool = False) -> Floats:
        """Displacements for every column of forces, the rows of this rank."""
        return self.solve_with_forces(b, transposed=transposed)[0]

    def solve_with_forces(self, b: Floats, *, transposed: bool = False) -> tuple[Floats, Floats]:
        """Displacements and contact forces for every column of forces, the rows of this rank.

        Returns
        -------
        tuple
            Shapes (n_local, columns) and (multipliers of this rank, columns).
        """
        whole = b
        if self._b is not None:
            whole = np.zeros((self._b.getLocalSize(), b.shape[1]), order="F")
            whole[: self._local] = b
        solution = self._factors.solve_block(whole, transposed=transposed)
        if self._scale is None:
            return solution, solution[self._local :]
        scale = self._scale.array_r[: self.multipliers, None]
        end = self._local + len(scale)
        return solution[: self._local], solution[self._local : end] * scale

    def parity(self) -> int | None:
        """Whether the number of real eigenvalues kappa below the shift is odd (1) or even (0).

        The determinant of A(kappa) has the sign of (-1)^m, m contact forces, far to the left, and
        changes it at each real eigenvalue. None where that is not known: for a symmetric pencil,
        refined factors, forces without compliance.
        """
        if self.matrices.symmetric or isinstance(self._factors, Refined):
            return None
        forces = 0
        if self._multipliers is not None:
            if self._multipliers.tied:
                return None
            forces = self._multipliers.size
        return int(self._factors.sign() != (-1) ** forces)

    def cost(self) -> tuple[float, float]:
        """Entries of its own factors, and operations that they took."""
        assert isinstance(self._factors, Mumps)
        return self._factors.cost()

    def steps(self) -> int:
        """Steps that a system takes: 1 with factors of its own."""
        return self._factors.steps()

    def free(self) -> None:
        """Free the factors."""
        self._factors.free()
        destroy(*(v for v in (self._x, self._b) if v is not None))
        if self._multipliers is not None and self._multipliers is not self.matrices.multipliers:
            self._multipliers.free()
        if self._scale is not None and self._own_scale:
            destroy(self._scale)


def count_below(matrices: Matrices, kappa: float) -> int:
    """Number of eigenvalues of the symmetric part below kappa (1/s^2), by its inertia.

    Each multiplier adds one negative eigenvalue to those of S - kappa M; so it does beside a row
    of Z^T, which takes one of its own sign and one of the other.

    Raises
    ------
    ConvergenceError
        When the factorisation fails.
    """
    shifted = matrices.operator(kappa, symmetric_part=True)
    extra = 0
    if matrices.multipliers is not None:
        symmetric = replace(matrices.multipliers, reaction=matrices.multipliers.closure)
        scale = force_scale(shifted, symmetric)
        whole = bordered(shifted, symmetric, scale, symmetric=True)
        destroy(shifted, scale)
        shifted, extra = whole, symmetric.size
    factors = Mumps(shifted, symmetric=True, inertia=True)
    negative = factors.negative_eigenvalues()
    factors.free()
    return negative - extra


def force_scale(operator: Any, multipliers: Multipliers) -> Any:
    """Factors on multipliers that make each row of J as large as the rows it touches."""
    diagonal = operator.getDiagonal()
    diagonal.abs()
    sizes, squares = (_entrywise(multipliers.closure, power) for power in (1, 2))
    touched, length = multipliers.closure.createVecLeft(), multipliers.closure.createVecLeft()
    sizes.mult(diagonal, touched)
    one = diagonal.duplicate()
    one.set(1.0)
    squares.mult(one, length)
    largest = diagonal.max()[1] / max(np.sqrt(length.max()[1]), np.finfo(float).tiny)
    rows = length.array_r > 0
    scale = np.full(len(rows), largest if largest > 0 else 1.0)
    scale[rows] = touched.array_r[rows] / length.array_r[rows]
    scale[~(scale > 0)] = 1.0
    length.array[:] = scale
    destroy(diagonal, sizes, squares, touched, one)
    return length


def _entrywise(matrix: Any, power: int) -> Any:
    """Absolute entries to a power."""
    part = local_part(matrix)
    part.data = np.abs(part.data) ** power
    return distributed(part, matrix.getSizes()[1], matrix.comm)


def balanced(border: Any, scale: Any, size: float) -> Any:
    """S Z, its columns as long as rows of the rest are."""
    part = csr_array(diags_array(scale.array_r) @ local_part(border))
    squares = np.zeros(part.shape[1])
    np.add.at(squares, part.indices, part.data**2)
    lengths = np.sqrt(border.comm.tompi4py().allreduce(squares))
    part = csr_array(part @ diags_array(size / lengths))
    return distributed(part, border.getSizes()[1], border.comm)


def nested(blocks: list[list[Any]]) -> Any:
    """Blocks as one PETSc AIJ matrix, the displacements first.

    On one rank rows of their own are put at its end, until they are a multiple of what nodes have:
    the factorisation orders its graph by nodes then (:mod:`cea.eigen.mumps`).
    """
    operator = blocks[0][0]
    rows = sum(next(block for block in row if block).getSize()[0] for row in blocks)
    missing = -rows % _OF_NODES
    if operator.comm.size > 1 or not missing:
        return PETSc.Mat().createNest(blocks).convert("aij")
    alone = identity(missing, operator.comm)
    alone.scale(largest_row(operator) or 1.0)
    last: list[Any] = [*([None] * len(blocks)), alone]
    result = PETSc.Mat().createNest([*([*row, None] for row in blocks), last]).convert("aij")
    destroy(alone)
    return result


def bordered(operator: Any, multipliers: Multipliers, scale: Any, *, symmetric: bool) -> Any:
    """[A, L^T s, .; s J, -s C s, s Z; ., Z^T s, .], PETSc AIJ; with J for L in its symmetric part.

    Further rows may follow (:func:`nested`).

    Parameters
    ----------
    operator
        A.
    multipliers
        L, J, C and Z.
    scale
        s, PETSc vector (multipliers).
    symmetric
        Whether L is J.
    """
    closure = multipliers.closure.copy()
    closure.diagonalScale(L=scale)
    reaction = closure
    if not symmetric:
        reaction = multipliers.reaction.copy()
        reaction.diagonalScale(L=scale)
    transpose = reaction.transpose(PETSc.Mat())
    corner = multipliers.compliance.copy()
    corner.diagonalScale(L=scale, R=scale)
    corner.scale(-1.0)
    blocks = [[operator, transpose], [closure, corner]]
    made = [transpose, corner, closure]
    if multipliers.border is not None:
        border = balanced(multipliers.border, scale, largest_row(closure))
        across = border.transpose(PETSc.Mat())
        blocks = [[operator, transpose, None], [closure, corner, border], [None, across, None]]
        made += [border, across]
    whole = nested(blocks)
    destroy(*made)
    if reaction is not closure:
        destroy(reaction)
    return whole
