"""Matrices read from files of other programs: MATLAB, Matrix Market, Abaqus, PETSc, scipy.

The result is always a real square sparse matrix of finite numbers, or an InputError. Matrices are
split into a symmetric and a remaining part.
"""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from cea.arrays import Ints
from cea.errors import InputError
from meshes.files.sandbox import arrays_of

LARGEST_SIZE = 50_000_000
"""Largest number of rows; more indicates a broken header."""
_MOST_ENTRIES = 2**31 - 1
"""Largest number of entries, the limit of 32-bit indices."""
_PROGRAM = Path(__file__).with_name("formats.py")
_ROUNDING = 16 * np.finfo(float).eps
"""Relative difference of an entry and its mirror image below which it is treated as rounding."""

type Parts = list[tuple[csr_array, bool]]
"""Summands of a matrix, each with whether it is exactly symmetric."""


def read_matrix(
    file: str | Path, variable: str | None = None, *, field: str = "file"
) -> tuple[csr_array, Ints | None]:
    """Read a matrix, and the node and degree of freedom of each row, (n, 2), if the file has them.

    ``.mat``: MATLAB, versions 5 to 7.2, its only matrix or the named variable. ``.mtx``,
    ``.mtx.gz``: Matrix Market, or Abaqus if there is no header. ``.npz``: a sparse matrix of scipy.
    Other extensions: PETSc's binary format with 32- or 64-bit indices. Duplicate entries are
    summed, entries are sorted, and zeros are removed. An InputError names ``field``.
    """
    path, shown = Path(file), f"{file}:{variable}" if variable else str(file)
    try:
        if not path.is_file() or not path.stat().st_size:
            raise InputError(field, shown, "an existing file that is not empty")
        arrays = arrays_of(_PROGRAM, path)
        labels = arrays.pop("labels", None)
        names = sorted({entry.rpartition(" ")[0] for entry in arrays})
        if variable is None and len(names) != 1:
            told = ", ".join(names) or "none"
            raise InputError(field, shown, f"one matrix, or FILE:VARIABLE; the matrices are {told}")
        if variable is not None and variable not in names:
            told = ", ".join(filter(None, names)) or "none: only .mat files have variables"
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
    """Return a matrix of the arrays; raise an InputError unless it is real, finite and nonzero."""
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


def half_of(matrix: csr_array) -> str | None:
    """Return which half of a symmetric matrix this may be: no off-diagonal entry is mirrored.

    Return None if one has, for a diagonal matrix, and for an empty diagonal, e.g. that of friction
    forces along one direction due to pressures along another.
    """
    if not matrix.diagonal().any():
        return None
    rows, columns = matrix.tocoo().coords
    below, above = bool((rows > columns).any()), bool((rows < columns).any())
    if not (below or above):
        return None
    if below != above:
        return "lower triangle" if below else "upper triangle"
    pattern = csr_array((matrix - diags_array(matrix.diagonal())) != 0)
    return None if pattern.multiply(pattern.T).count_nonzero() else "half of mirrored entries"


def mirrored(half: csr_array) -> csr_array:
    """Return the symmetric matrix with the given half."""
    return csr_array(half + half.T - diags_array(half.diagonal()))


def parts_of(matrix: csr_array) -> tuple[str, float, Parts]:
    """Return the symmetry of a square matrix, its asymmetry, and its summands.

    The symmetry is ``symmetric``, ``symmetric to rounding`` (the part is then the mean with the
    transpose), ``skew`` or ``general`` (the parts are then the entries that equal their mirror
    image and the others, unchanged). The asymmetry is the largest difference of an entry and its
    mirror image, relative to the larger of both, or to sqrt(abs(a_ii a_jj)) if that is larger; this
    does not depend on the scaling of unknowns.
    """
    transpose = matrix.T.tocsr()
    difference = csr_array(matrix - transpose)
    difference.eliminate_zeros()
    if not difference.nnz:
        return "symmetric", 0.0, [(matrix, True)]
    rows, columns = difference.tocoo().coords
    root = np.sqrt(np.abs(matrix.diagonal()))
    larger = csr_array(abs(matrix)).maximum(csr_array(abs(transpose)))
    sizes = np.maximum(root[rows] * root[columns], np.asarray(larger[rows, columns]).ravel())
    worst = float((np.abs(difference.data) / sizes).max())
    if worst <= _ROUNDING:
        mean = csr_array(0.5 * matrix + 0.5 * transpose)
        return "symmetric to rounding", worst, [(mean, True)]
    rest = csr_array(matrix.multiply(difference != 0))
    equal = csr_array(matrix - rest)
    equal.eliminate_zeros()
    kind = "general" if (matrix + transpose).count_nonzero() else "skew"
    return kind, worst, [(part, part is equal) for part in (equal, rest) if part.nnz]
