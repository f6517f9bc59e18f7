"""Matrices read from files of other programs: MATLAB, Matrix Market, Abaqus, PETSc, scipy.

Whatever a file holds, the result is a real square sparse matrix of finite numbers, or a refusal
that names the file and says what is allowed. What a matrix is the sum of tells how symmetric it is.
"""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from cea.arrays import Ints
from cea.errors import InputError
from meshes.files.sandbox import arrays_of

LARGEST_SIZE = 50_000_000
"""Rows of a matrix at most: more is a broken header, or nothing that a run could solve."""
_MOST_ENTRIES = 2**31 - 1
"""What indices of 32 bits can count."""
_PROGRAM = Path(__file__).with_name("formats.py")
_ROUNDING = 16 * np.finfo(float).eps
"""Difference of an entry and its mirror image that rounding explains, relative to their size."""

type Parts = list[tuple[csr_array, bool]]
"""Matrices whose sum is meant, each with whether it is symmetric to the last bit."""


def read_matrix(
    file: str | Path, variable: str | None = None, *, field: str = "file"
) -> tuple[csr_array, Ints | None]:
    """Read a matrix, and the node and degree of freedom of each row, (n, 2), where a file has them.

    ``.mat``: MATLAB, versions 5 to 7.2, the only matrix there or that of a variable. ``.mtx``,
    ``.mtx.gz``: Matrix Market, or Abaqus where there is no header. ``.npz``: a sparse matrix of
    scipy. Any other ending: PETSc's binary format, indices of 32 or 64 bits. Entries are summed and
    in order, without stored zeros. Refusals call the file by the field.
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


def half_of(matrix: csr_array) -> str | None:
    """Which half of a symmetric matrix this may be: no entry beside the diagonal has its mirror.

    None where one has, of a diagonal matrix, and where the diagonal is empty, as of friction forces
    along one direction from pressures along another.
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
    """The symmetric matrix of which one half is given."""
    return csr_array(half + half.T - diags_array(half.diagonal()))


def parts_of(matrix: csr_array) -> tuple[str, float, Parts]:
    """How symmetric a square matrix is, its asymmetry, and what it is the sum of.

    It is ``symmetric``, ``symmetric to rounding``, and then taken as the mean with its transpose,
    ``skew`` or ``general``: then its parts are the entries that equal their mirror image, and the
    others, and no bit is changed. The asymmetry is the largest difference of an entry and its
    mirror image, relative to their size: the larger of both, or the mean of the diagonal entries of
    their row and column, sqrt(abs(a_ii a_jj)), which scaling of unknowns leaves alone.
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
