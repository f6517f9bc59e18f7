"""Modes of a graded pencil, by those of its balanced one (:mod:`cea.eigen.balance`)."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.eigen.balance import Balance
from cea.eigen.modes import Modes
from cea.eigen.pencil import Matrices, Pencil, Role, Term
from cea.eigen.sensitivity import LeftVectors, dual_norms
from cea.matrices import destroy, distributed, local_part, scaled_total


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


def in_own_unknowns(
    modes: Modes,
    balance: Balance,
    pencil: Pencil,
    values: Mapping[str, float],
    matrices: Matrices,
    *,
    left: bool,
) -> Modes:
    """Modes of a balanced pencil as those of the pencil that it was made of.

    Residuals and conditions stay those of the balanced one: in its norms they say something.

    Parameters
    ----------
    modes
        Modes of the balanced pencil, with left vectors.
    balance
        How it was balanced.
    pencil, values, matrices
        What was balanced, the parameters, and its sums there.
    left
        Whether left vectors are wanted.
    """
    x = balance.right[:, None] * modes.vectors
    size = dual_norms(matrices.mass, x)
    vectors = None
    if left and modes.left is not None:
        y = balance.left[:, None] * modes.left.vectors * size
        vectors = LeftVectors(y, modes.left.forces * size)
    return replace(
        modes,
        vectors=x / size,
        left=vectors,
        template=matrices.stiffness.createVecRight(),
        pencil=pencil,
        values=values,
    )
