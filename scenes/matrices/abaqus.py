"""Matrices as Abaqus writes them (`*MATRIX GENERATE`): lines of numbers without a header.

Lines of three numbers are row, column and entry (FORMAT=COORDINATE); lines of five are node and
degree of freedom of the row, the same of the column, and the entry (MATRIX INPUT, LABELS). The
latter format defines a symmetric matrix by either triangle or by both.
"""

from io import BytesIO
from typing import Any

import numpy as np
from scipy.sparse import coo_array

from cea.arrays import Ints
from scenes.matrices.symmetry import half_of, mirrored

_COORDINATES, _LABELS = 3, 5
"""Numbers in a line."""


def read_abaqus_matrix(content: bytes) -> tuple[Any, Ints | None]:
    """The matrix of a file, and the node and degree of freedom of each row."""
    try:
        table = np.loadtxt(BytesIO(content.replace(b",", b" ")), comments="*", ndmin=2)
    except ValueError as error:
        raise ValueError(
            f"neither '%%MatrixMarket matrix ...' nor lines of Abaqus: {error}"
        ) from None
    if table.shape[1] not in (_COORDINATES, _LABELS):
        raise ValueError(f"lines of 3 or 5 numbers, not {table.shape[1]}")
    if not (np.abs(table[:, :-1]) < 2**53).all() or (table[:, :-1] % 1 != 0).any():
        raise ValueError("whole numbers of nodes, degrees of freedom, rows and columns")
    places, values = table[:, :-1].astype(np.int64), table[:, -1]
    labels: Ints | None
    if table.shape[1] == _COORDINATES:
        if places.min() < 1:
            raise ValueError("rows and columns counted from 1")
        size = int(places.max())
        labels, ends = None, places.T - 1
    else:
        labels, row = np.unique(places.reshape(-1, 2), axis=0, return_inverse=True)
        size, ends = len(labels), row.reshape(-1, 2).T
    if len(np.unique(ends[0] * size + ends[1])) < len(values):
        raise ValueError("each entry once; a file that begins with its sizes needs the first line")
    matrix = coo_array((values, (ends[0], ends[1])), shape=(size, size))
    if labels is None:
        return matrix, None
    whole = matrix.tocsr()
    return (mirrored(whole) if half_of(whole) else whole), labels
