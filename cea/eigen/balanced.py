"""Modes of a graded pencil, by those of its balanced one (:mod:`cea.eigen.balance`)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.eigen.balance import Balance, balance_of
from cea.eigen.modes import Modes
from cea.eigen.pencil import Matrices, Pencil, Role, Term
from cea.eigen.sensitivity import LeftVectors, dual_norms
from cea.errors import ConvergenceError
from cea.matrices import destroy, distributed, local_part, scaled_total


@dataclass(frozen=True)
class Asked:
    """What is solved.

    Parameters
    ----------
    pencil, values, matrices
        A pencil, parameters, and its sums there.
    max_frequency, min_growth
        The window (Hz, 1/s), as :meth:`cea.eigen.krylov_schur.KrylovSchur.solve` takes it.
    left
        Whether left vectors are wanted.
    """

    pencil: Pencil
    values: Mapping[str, float]
    matrices: Matrices
    max_frequency: float
    min_growth: float | None
    left: bool


def modes_with_balance(
    asked: Asked, plain: Callable[[], Modes], of_balanced: Callable[[Pencil], Modes]
) -> Modes:
    """Modes of a pencil as it stands, or by its balanced one where it is graded.

    A grading that stands out is taken out beforehand. One that hides beside larger entries is
    looked for where modes could not be told.

    Parameters
    ----------
    asked
        What is solved.
    plain
        Solves it as it stands.
    of_balanced
        Solves another pencil, left vectors included.

    Raises
    ------
    ConvergenceError
        When neither can be solved.
    """
    modes, failure, end = None, None, 2 * np.pi * asked.max_frequency
    balance = balance_of(asked.matrices, end)
    if balance is None:
        try:
            modes = plain()
        except ConvergenceError as error:
            failure = error
        symmetric = asked.matrices.symmetric and not asked.matrices.quadratic
        if not symmetric and (modes is None or not modes.trusted.all()):
            balance = balance_of(asked.matrices, end, local=True)
    if balance is not None:
        try:
            found = of_balanced(balanced_pencil(asked.matrices, balance))
            own = in_own_unknowns(found, balance, asked)
            if modes is None or own.trusted.sum() > modes.trusted.sum():
                modes = own
        except ConvergenceError as error:
            failure = failure or error
    if modes is None:
        assert failure is not None
        raise failure
    return modes


def balanced_pencil(matrices: Matrices, balance: Balance) -> Pencil:
    """The balanced pencil, the diagonals of its sums and the rest as pieces of their own.

    Parameters
    ----------
    matrices
        A pencil at given parameters.
    balance
        Its balance.
    """
    terms = [Term("mass", _scaled([matrices.mass], balance))]
    sums: tuple[tuple[Role, list[Any]], ...] = (
        ("stiffness", [matrices.stiffness, matrices.unsymmetric]),
        ("damping", [matrices.damping, matrices.gyroscopic]),
    )
    for role, parts in sums:
        given = [part for part in parts if part is not None]
        if given:
            diagonal, rest = _split(_scaled(given, balance))
            terms += [Term(role, diagonal), Term(role, rest, symmetric=False)]
    return Pencil(terms)


def _scaled(parts: list[Any], balance: Balance) -> Any:
    """A sum with its rows and columns scaled, a new matrix."""
    whole = scaled_total([(1.0, part) for part in parts])
    left, right = whole.createVecLeft(), whole.createVecRight()
    left.array[:], right.array[:] = balance.left, balance.right
    whole.diagonalScale(L=left, R=right)
    destroy(left, right)
    return whole


def _split(matrix: Any) -> tuple[Any, Any]:
    """The diagonal of a matrix and the rest; the matrix is freed."""
    first, _ = matrix.getOwnershipRange()
    whole = local_part(matrix).tocoo()
    rows, columns = whole.coords
    diagonal = rows + first == columns
    parts = [
        csr_array((whole.data[chosen], (rows[chosen], columns[chosen])), shape=whole.shape)
        for chosen in (diagonal, ~diagonal)
    ]
    made = [distributed(part, matrix.getSizes()[1], matrix.comm) for part in parts]
    destroy(matrix)
    return made[0], made[1]


def in_own_unknowns(modes: Modes, balance: Balance, asked: Asked) -> Modes:
    """Modes of a balanced pencil as those of the pencil that it was made of.

    Residuals and conditions stay those of the balanced one: in its norms they say something.

    Parameters
    ----------
    modes
        Modes of the balanced pencil, with left vectors.
    balance
        How it was balanced.
    asked
        What was balanced.
    """
    x = balance.right[:, None] * modes.vectors
    size = dual_norms(asked.matrices.mass, x)
    left = None
    if asked.left and modes.left is not None:
        y = balance.left[:, None] * modes.left.vectors * size
        left = LeftVectors(y, modes.left.forces * size)
    return replace(
        modes,
        vectors=x / size,
        left=left,
        template=asked.matrices.stiffness.createVecRight(),
        pencil=asked.pencil,
        values=asked.values,
    )
