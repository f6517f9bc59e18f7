"""Matrices read from files of other programs: MATLAB, Matrix Market, Abaqus, PETSc, scipy.

Whatever a file holds, the result is a real square sparse matrix of finite numbers, or a refusal
that names the file and says what is allowed.
"""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array

from cea.arrays import Ints
from cea.errors import InputError
from meshes.files.sandbox import arrays_of
from scenes.matrices.symmetry import half_of, mirrored

LARGEST_SIZE = 50_000_000
"""Rows of a matrix at most: more is a broken header, or nothing that a run could solve."""
_MOST_ENTRIES = 2**31 - 1
"""What indices of 32 bits can count."""
_PROGRAM = Path(__file__).with_name("formats.py")


def read_matrix(
    file: str | Path, variable: str | None = None, *, field: str = "file"
) -> tuple[csr_array, Ints | None]:
    """Read a matrix and what its rows stand for.

    Parameters
    ----------
    file
        ``.mat``: MATLAB, versions 5 to 7.2. ``.mtx``, ``.mtx.gz``: Matrix Market, or Abaqus where
        there is no header. ``.npz``: a sparse matrix of scipy. Any other ending: PETSc's binary
        format, indices of 32 or 64 bits.
    variable
        Name in a ``.mat`` file; None takes the only matrix there.
    field
        What refusals call it.

    Returns
    -------
    matrix : csr_array
        Shape (n, n), real, finite; entries summed and in order, without stored zeros.
    labels : ndarray or None
        Node and degree of freedom of each row, (n, 2), where the file tells them.

    Raises
    ------
    InputError
        When there is no such file or variable, or it is no such matrix.
    """
    path, shown = Path(file), f"{file}:{variable}" if variable else str(file)
    try:
        if not path.is_file() or not path.stat().st_size:
            raise InputError(field, shown, "a file that is there and not empty")
        arrays = arrays_of(_PROGRAM, path)
        labels = arrays.pop("labels", None)
        names = sorted({entry.rpartition(" ")[0] for entry in arrays})
        if variable is None and len(names) != 1:
            told = ", ".join(names) or "none"
            raise InputError(field, shown, f"one matrix, or FILE:VARIABLE; the matrices are {told}")
        if variable is not None and variable not in names:
            told = ", ".join(filter(None, names)) or "none, which only .mat files have"
            raise InputError(field, shown, f"a variable among {told}")
        matrix = _checked(arrays, names[0] if variable is None else variable)
    except InputError as error:
        raise InputError(field, shown, error.allowed) from None
    except MemoryError:
        raise InputError(field, shown, "a matrix that fits into memory") from None
    except OSError as error:
        raise InputError(field, shown, f"a file that can be read ({error.strerror})") from error
    return (mirrored(matrix) if labels is not None and half_of(matrix) else matrix), labels


def _checked(arrays: dict[str, Any], name: str) -> csr_array:
    """A matrix of real finite numbers that are not all zero."""
    data, row, col, shape = (arrays[f"{name} {part}"] for part in ("data", "row", "col", "shape"))
    rows, columns = (int(n) for n in shape)
    for wrong, allowed in (
        (rows != columns, f"a square matrix, not {rows} x {columns}"),
        (not 0 < rows <= LARGEST_SIZE, f"1 to {LARGEST_SIZE} rows, not {rows}"),
        (data.dtype.kind not in "biuf", f"real numbers, not {data.dtype}"),
        (len(data) > _MOST_ENTRIES, f"at most {_MOST_ENTRIES} entries, not {len(data)}"),
    ):
        if wrong:
            raise InputError("file", name, allowed)
    matrix = csr_array(coo_array((data, (row, col)), shape=(rows, columns)), dtype=float)
    matrix.sum_duplicates()
    if not np.isfinite(matrix.data).all():
        raise InputError("file", name, "finite numbers")
    matrix.eliminate_zeros()
    if not matrix.nnz:
        raise InputError("file", name, "a matrix with an entry that is not zero")
    return matrix
