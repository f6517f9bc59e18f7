"""A pencil factorised at a shift: displacements, and contact forces where they are unknowns.

With forces f as unknowns (:mod:`cea.eigen.multipliers`) the matrix at kappa = -lambda^2 is

    A(kappa) = [ K - kappa M   L^T     ]
               [      J        -C   Z  ]
               [               Z^T     ]

and the displacement part of A(kappa)^-1 [r; 0] is what drivers iterate with: multipliers carry no
mass, and Krylov spaces stay ones of displacements. Circulatory pieces of K are unknowns beside the
forces. Pieces of C of low rank stay out of the factors: of A factorised and B of few columns, with
Z = A^-1 B (Sherman, Morrison and Woodbury)

    (A + s B B^T)^-1 = A^-1 - s Z (1 + s B^T Z)^-1 B^T A^-1.

Steps of iterative refinement, x + (A + s B B^T)^-1 (b - (A + s B B^T) x), bring back the digits
that cancel where A is nearly singular and the sum is not. How many it takes is measured once, on a
solution of A in which what is nearly singular stands out.
"""

from functools import partial
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve

from cea.arrays import Floats
from cea.eigen.blocks import by_parts, column_blocks, norms, times, transposed_times
from cea.eigen.multipliers import Multipliers, with_circulatory
from cea.eigen.mumps import Mumps, SingularError, inertia
from cea.eigen.pencil import Matrices
from cea.matrices import destroy
from cea.petsc import PETSc

_MOST_STEPS = 8
"""Most steps of refinement."""
_WORTH, _EXACT = 3.0, 1e-13
"""Factor by which more steps must lessen an error to be taken, and one that is small enough."""
_UNSOLVED = 1e-2
"""Error beyond which the sum counts as singular."""


class Shifted:
    """A(kappa) + s (C + Y) factorised at a shift kappa (1/s^2) and a rate s (1/s); SingularError.

    With kappa = -s^2 it is that of a quadratic problem; :meth:`quadratic`.
    """

    def __init__(self, matrices: Matrices, kappa: float = 0.0, rate: float = 0.0) -> None:
        self.matrices, self.kappa, self.rate = matrices, kappa, rate
        self._local = matrices.stiffness.getLocalSize()[0]
        turns = bool(rate) and matrices.gyroscopic is not None
        self._symmetric = symmetric = matrices.symmetric and not turns
        self._forces = matrices.multipliers
        if matrices.circulatory is not None:
            self._forces = with_circulatory(matrices.multipliers, matrices.circulatory)
        whole = bordered(matrices.operator(kappa, rate=rate), self._forces, symmetric=symmetric)
        self._factors = Mumps(whole, symmetric=symmetric)
        self._update: UpdatedFactors | None = None
        if rate and matrices.low_rank is not None:
            root = matrices.low_rank.vectors
            self._update = UpdatedFactors(self._factors, root, rate, symmetric=symmetric)

    @classmethod
    def quadratic(cls, matrices: Matrices, rate: float) -> "Shifted":
        """P(s) = s^2 M + s (C + Y) + K factorised at a real s (1/s)."""
        return cls(matrices, -(rate**2), rate)

    @property
    def multipliers(self) -> int:
        """Number of contact forces on this rank that are unknowns."""
        forces = self.matrices.multipliers
        return 0 if forces is None else int(forces.compliance.getLocalSize()[0])

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Displacements for every column of forces, the rows of this rank."""
        return self.solve_with_forces(b, transposed=transposed)[0]

    def solve_with_forces(
        self, b: NDArray[Any], *, transposed: bool = False
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Displacements and contact forces for every column of forces, the rows of this rank.

        They are real or complex; the matrix may be the transposed one.
        """
        solver = self._update or self._factors
        solution = solver.solve_block(b, transposed=transposed)
        return solution[: self._local], solution[self._local : self._local + self.multipliers]

    def parity(self) -> int | None:
        """Whether the number of real eigenvalues beyond the shift is odd (1) or even (0).

        Those are kappa below it, or lambda above it. The determinant has the sign of (-1)^m there,
        m contact forces, far away, and changes it at each real eigenvalue. None where it is not
        known: for symmetric matrices and forces without compliance.
        """
        if self._symmetric or (self._forces is not None and self._forces.tied):
            return None
        sign = self._factors.sign() * (1 if self._update is None else self._update.sign())
        return int(sign != (-1) ** (0 if self._forces is None else self._forces.size))

    def free(self) -> None:
        """Free the factors."""
        self._factors.free()
        if self._forces is not None and self._forces is not self.matrices.multipliers:
            self._forces.free()


class UpdatedFactors:
    """A + s B B^T, solved by means of A factorised, B of few columns.

    B (``root``, m x r) is on the first rows of this rank, of which A may have more. ``symmetric``
    says that A is. SingularError when A or the sum is singular, or as good as that.
    """

    def __init__(self, matrix: Mumps, root: Floats, shift: float, *, symmetric: bool) -> None:
        self._matrix, self._root, self._shift = matrix, root, shift
        self._rows, self._comm = matrix.matrix.getLocalSize()[0], matrix.matrix.comm
        self._symmetric = symmetric
        self._small: dict[bool, tuple[Floats, Any]] = {}
        self._steps: dict[bool, int] = {}
        self._prepare(transposed=False)

    def solve_block(self, b: NDArray[Any], *, transposed: bool = False) -> NDArray[Any]:
        """Solutions for every column of b, the first rows of this rank, as of :class:`Mumps`."""
        transposed = transposed and not self._symmetric
        if transposed not in self._steps:
            self._prepare(transposed=transposed)
        return by_parts(partial(self._refined, transposed=transposed), b)

    def _refined(self, b: Floats, *, transposed: bool) -> Floats:
        b = np.vstack([b, np.zeros((self._rows - len(b), b.shape[1]))])
        x = self._once(b, transposed)
        for _ in range(self._steps[transposed]):
            x = x + self._once(b - self._times(x, transposed), transposed)
        return x

    def sign(self) -> int:
        """Sign of det(A + s B B^T) / det A."""
        factors, pivots = self._small[False][1]
        swaps = int((pivots != np.arange(len(pivots))).sum())
        return int(np.prod(np.sign(np.diag(factors)))) * (-1) ** swaps

    def _prepare(self, *, transposed: bool) -> None:
        """Find Z, 1 + s B^T Z and the steps; with the Z of A the formula for A^T is unstable."""
        image = np.zeros((self._rows, self._root.shape[1]), order="F")
        for each in column_blocks(image.shape[1]):
            image[:, each] = self._matrix.solve_block(self._root[:, each], transposed=transposed)
        small = np.eye(image.shape[1]) + self._shift * self._inner(image)
        if not np.isfinite(small).all():
            raise SingularError("a matrix is singular without a piece of low rank")
        with catch_warnings():
            simplefilter("ignore", LinAlgWarning)  # a singular one solves nothing below
            self._small[transposed] = image, lu_factor(small, check_finite=False)
        self._steps[transposed] = self._needed(transposed)

    def _needed(self, transposed: bool) -> int:
        """Steps of refinement that lessen the error of a known solution."""
        rng = np.random.default_rng([1, self._comm.rank])
        start = rng.standard_normal((self._rows, 1))
        known = self._matrix.solve_block(start, transposed=transposed)
        known = np.asfortranarray(known / norms(known, self._comm))
        b, x, errors = self._times(known, transposed), np.zeros_like(known), []
        for _ in range(_MOST_STEPS + 1):
            x = x + self._once(b - self._times(x, transposed), transposed)
            errors.append(float(np.nan_to_num(norms(x - known, self._comm)[0], nan=np.inf)))
        least = min(errors)
        if not least <= _UNSOLVED:
            raise SingularError(f"a matrix with updates is singular ({least})")
        return next(i for i, each in enumerate(errors) if each <= max(_WORTH * least, _EXACT))

    def _once(self, b: Floats, transposed: bool) -> Floats:
        """Solutions without refinement."""
        x = self._matrix.solve_block(b, transposed=transposed)
        image, small = self._small[transposed]
        inner = lu_solve(small, self._inner(x), check_finite=False)
        return np.asarray(x - image @ (self._shift * inner))

    def _times(self, x: Floats, transposed: bool) -> Floats:
        """(A + s B B^T) x, or its transpose."""
        result = (transposed_times if transposed else times)(self._matrix.matrix, x)
        result[: len(self._root)] += self._shift * (self._root @ self._inner(x))
        return result

    def _inner(self, x: Floats) -> Floats:
        """B^T x, the same on every rank."""
        return np.asarray(self._comm.tompi4py().allreduce(self._root.T @ x[: len(self._root)]))


def count_below(matrices: Matrices, kappa: float) -> int:
    """Number of eigenvalues of the symmetric part below kappa (1/s^2), by its inertia.

    Each multiplier adds one negative eigenvalue to those of S - kappa M; so it does beside a row
    of Z^T, which takes one of its own sign and one of the other.
    """
    forces, shifted = matrices.multipliers, matrices.operator(kappa, symmetric_part=True)
    negative, _ = inertia(bordered(shifted, forces, symmetric=True))
    return negative - (0 if forces is None else forces.size)


def bordered(operator: Any, multipliers: Multipliers | None, *, symmetric: bool) -> Any:
    """[A, L^T, .; J, -C, Z; ., Z^T, .], PETSc AIJ, in the place of A, which is destroyed.

    MUMPS scales it; L is J where symmetric. A itself without multipliers.
    """
    if multipliers is None:
        return operator
    closure = multipliers.closure
    reaction = closure if symmetric else multipliers.reaction
    transpose, corner = reaction.transpose(PETSc.Mat()), multipliers.compliance.copy()
    corner.scale(-1.0)
    blocks, made = [[operator, transpose], [closure, corner]], [operator, transpose, corner]
    if (border := multipliers.border) is not None:
        across = border.transpose(PETSc.Mat())
        blocks = [[operator, transpose, None], [closure, corner, border], [None, across, None]]
        made.append(across)
    whole = PETSc.Mat().createNest(blocks).convert("aij")
    destroy(*made)
    return whole
