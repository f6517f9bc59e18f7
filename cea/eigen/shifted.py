"""A pencil factorised at a shift: displacements, and contact forces where they are unknowns.

With forces f as unknowns (:mod:`cea.eigen.multipliers`) the matrix at kappa = -lambda^2 is

    A(kappa) = [ K - kappa M   L^T     ]
               [      J        -C   Z  ]
               [               Z^T     ]

and the displacement part of A(kappa)^-1 [r; 0] is what drivers iterate with: multipliers carry no
mass, and Krylov spaces stay ones of displacements. Pieces of C of low rank stay out of the factors,
and so do circulatory pieces of K of damped problems where they are small
(:mod:`cea.eigen.updated_factors`); otherwise they are unknowns beside the forces.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from cea.eigen.multipliers import Multipliers, with_circulatory
from cea.eigen.mumps import Mumps, SingularError
from cea.eigen.pencil import Matrices
from cea.eigen.unformed import CirculatorySum
from cea.eigen.updated_factors import UpdatedFactors
from cea.matrices import destroy, distributed, largest_row, local_part
from cea.petsc import PETSc


class Shifted:
    """A(kappa) + s (C + Y) factorised at a shift kappa (1/s^2) and a rate s (1/s); SingularError.

    With kappa = -s^2 it is that of a quadratic problem; :meth:`quadratic`.
    """

    def __init__(self, matrices: Matrices, kappa: float = 0.0, rate: float = 0.0) -> None:
        self.matrices, self.kappa, self.rate = matrices, kappa, rate
        self._local = matrices.stiffness.getLocalSize()[0]
        turns = bool(rate) and matrices.gyroscopic is not None
        self._symmetric = matrices.symmetric and not turns
        self._forces, circulatory = matrices.multipliers, matrices.circulatory
        if rate and circulatory is not None:
            try:
                self._factorise(circulatory)
            except SingularError:
                self.free()
            else:
                return
        if circulatory is not None:
            self._forces = with_circulatory(matrices.multipliers, circulatory)
        self._factorise(None)

    @classmethod
    def quadratic(cls, matrices: Matrices, rate: float) -> "Shifted":
        """P(s) = s^2 M + s (C + Y) + K factorised at a real s (1/s)."""
        return cls(matrices, -(rate**2), rate)

    def _factorise(self, rest: CirculatorySum | None) -> None:
        """Factors with the forces, and what solves with pieces that stay out of them."""
        operator = self.matrices.operator(self.kappa, rate=self.rate)
        self._scale: Any | None = None
        if self._forces is not None:
            self._scale = force_scale(operator, self._forces)
            whole = bordered(operator, self._forces, self._scale, symmetric=self._symmetric)
            destroy(operator)
            operator = whole
        self._update: UpdatedFactors | None = None
        self._factors: Mumps | None = None
        self._factors = Mumps(operator, symmetric=self._symmetric)
        low_rank = self.matrices.low_rank if self.rate else None
        if low_rank is None and rest is None:
            return
        root = np.zeros((self._local, 0)) if low_rank is None else low_rank.root()
        try:
            self._update = UpdatedFactors(
                self._factors, root, self.rate, rest, symmetric=self._symmetric
            )
        except SingularError:
            self.free()
            raise

    @property
    def multipliers(self) -> int:
        """Number of contact forces on this rank that are unknowns."""
        forces = self.matrices.multipliers
        return 0 if forces is None else int(forces.compliance.getLocalSize()[0])

    def solve(self, b: Any, x: Any) -> None:
        """Displacements x for forces b on the bodies, PETSc vectors."""
        x.array[:] = self.solve_block(np.array(b.array_r)[:, None])[:, 0]

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Displacements for every column of forces, the rows of this rank."""
        return self.solve_with_forces(b, transposed=transposed)[0]

    def solve_with_forces(
        self, b: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Displacements and contact forces for every column of forces, the rows of this rank.

        They are real or complex; the matrix may be the transposed one.
        """
        if np.iscomplexobj(b):
            n, parts = b.shape[1], np.hstack([b.real, b.imag])
            both = self.solve_with_forces(parts, transposed=transposed)
            x, f = (part[:, :n] + 1j * part[:, n:] for part in both)
            return x, f
        solver = self._update or self._factors
        assert solver is not None
        solution = solver.solve_block(b, transposed=transposed)
        forces = solution[self._local : self._local + self.multipliers]
        if self._scale is not None:
            forces = forces * self._scale.array_r[: self.multipliers, None]
        return solution[: self._local], forces

    def parity(self) -> int | None:
        """Whether the number of real eigenvalues beyond the shift is odd (1) or even (0).

        Those are kappa below it, or lambda above it. The determinant has the sign of (-1)^m there,
        m contact forces, far away, and changes it at each real eigenvalue. None where it is not
        known: for symmetric matrices, forces without compliance and pieces outside of the factors.
        """
        forces = self._forces
        if self._symmetric or self._update is not None or (forces is not None and forces.tied):
            return None
        assert self._factors is not None
        return int(self._factors.sign() != (-1) ** (0 if forces is None else forces.size))

    def free(self) -> None:
        """Free the factors."""
        if self._factors is not None:
            self._factors.free()
        if self._scale is not None:
            destroy(self._scale)
        self._factors = self._update = self._scale = None
        if self._forces is not None and self._forces is not self.matrices.multipliers:
            self._forces.free()


def count_below(matrices: Matrices, kappa: float) -> int:
    """Number of eigenvalues of the symmetric part below kappa (1/s^2), by its inertia.

    Each multiplier adds one negative eigenvalue to those of S - kappa M; so it does beside a row
    of Z^T, which takes one of its own sign and one of the other.
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


def bordered(operator: Any, multipliers: Multipliers, scale: Any, *, symmetric: bool) -> Any:
    """[A, L^T s, .; s J, -s C s, s Z; ., Z^T s, .], PETSc AIJ; J is L where it is symmetric."""
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
    whole = PETSc.Mat().createNest(blocks).convert("aij")
    destroy(*made)
    if reaction is not closure:
        destroy(reaction)
    return whole
