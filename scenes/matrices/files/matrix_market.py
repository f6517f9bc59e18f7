"""Matrices in the Matrix Market format, read within the bounds of the file.

A broken file of this format, too, can make scipy's reader crash the process.
"""

from io import BytesIO
from typing import Any

import numpy as np
from scipy.sparse import coo_array

_FIELDS = ("real", "integer", "double")
_MIRRORED = {"general": 0.0, "symmetric": 1.0, "skew-symmetric": -1.0}
"""Factor on the mirror image of each entry that is given, by symmetry."""
_BANNER = 5
"""Words of the first line."""


def read_matrix_market(content: bytes) -> Any:
    """The real matrix of a file, sparse or an array.

    Parameters
    ----------
    content
        The file, unpacked.

    Raises
    ------
    ValueError
        When it is no such file, or broken; where its numbers are not real, in these words.
    """
    first, _, rest = content.partition(b"\n")
    words = first.decode("ascii", "replace").lower().split()
    if len(words) != _BANNER or words[:2] != ["%%matrixmarket", "matrix"]:
        raise ValueError("its first line is not '%%MatrixMarket matrix ...'")
    form, field, symmetry = words[2:]
    if field not in _FIELDS:
        raise ValueError(f"real numbers, not {field}")
    if symmetry not in _MIRRORED or form not in ("coordinate", "array"):
        raise ValueError(f"'{form}' and '{symmetry}' are no form and symmetry of it")
    while rest.startswith(b"%") or rest[:1].isspace():
        _, _, rest = rest.partition(b"\n")
    line, _, rest = rest.partition(b"\n")
    sizes = [int(word) for word in line.split()]
    if form == "coordinate":
        return _sparse(rest, sizes, _MIRRORED[symmetry])
    return _dense(rest, sizes, _MIRRORED[symmetry])


def _sparse(body: bytes, sizes: list[int], mirrored: float) -> Any:
    if len(sizes) != 3:
        raise ValueError("its sizes are not rows, columns and entries")
    rows, columns, count = sizes
    if mirrored and rows != columns:
        raise ValueError("a symmetric matrix that is not square")
    entries = _table(body, 3)
    if len(entries) != count:
        raise ValueError(f"{len(entries)} entries where it says {count}")
    i, j = entries[:, 0], entries[:, 1]
    if not ((i % 1 == 0) & (j % 1 == 0) & (i >= 1) & (i <= rows) & (j >= 1) & (j <= columns)).all():
        raise ValueError("an entry lies outside of the matrix")
    i, j, values = i.astype(np.int64) - 1, j.astype(np.int64) - 1, entries[:, 2]
    if mirrored:
        aside = i != j
        values = np.concatenate([values, mirrored * values[aside]])
        i, j = np.concatenate([i, j[aside]]), np.concatenate([j, i[aside]])
    return coo_array((values, (i, j)), shape=(rows, columns))


def _dense(body: bytes, sizes: list[int], mirrored: float) -> Any:
    if len(sizes) != 2:
        raise ValueError("its sizes are not rows and columns")
    rows, columns = sizes
    values = _table(body, 1)[:, 0]
    if not mirrored:
        if len(values) != rows * columns:
            raise ValueError(f"{len(values)} numbers where it says {rows * columns}")
        return values.reshape(rows, columns, order="F")
    if rows != columns:
        raise ValueError("a symmetric matrix that is not square")
    least = 0 if mirrored > 0 else 1  # the diagonal of a skew matrix is not given
    if len(values) != rows * (rows + 1 - 2 * least) // 2:
        raise ValueError(f"{len(values)} numbers in a triangle of {rows} rows")
    matrix = np.zeros((rows, rows))
    upper = np.triu_indices(rows, least)  # by rows, as the lower triangle by columns
    matrix[upper[1], upper[0]] = values
    matrix[upper] = mirrored * values
    return matrix


def _table(body: bytes, columns: int) -> Any:
    """Numbers of the lines, shape (lines, columns)."""
    if not body.strip():
        return np.empty((0, columns))
    table = np.loadtxt(BytesIO(body), comments="%", ndmin=2, encoding="ascii")
    if table.shape[1] != columns:
        raise ValueError(f"lines of {table.shape[1]} numbers, not {columns}")
    return table
