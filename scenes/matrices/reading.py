"""Matrices read from files of other programs: MATLAB, Matrix Market, Abaqus, PETSc, scipy.

Whatever a file holds, the result is a real square sparse matrix of finite numbers, or a refusal
that names the file and says what is allowed.
"""

import gzip
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, issparse

from cea.arrays import Ints
from cea.errors import InputError
from meshes.files.sandbox import arrays_of
from scenes.matrices.abaqus import read_abaqus_matrix

LARGEST_SIZE = 50_000_000
"""Rows of a matrix at most: more is a broken header, or nothing that a run could solve."""
_MOST_ENTRIES = 2**31 - 1
"""What indices of 32 bits can count."""
_PROGRAM = Path(__file__).with_name("program.py")
_HDF, _NEWER = b"\x89HDF", b"MATLAB 7.3"
_PETSC_MATRIX = 1211216
"""First number of a matrix in PETSc's binary format."""
_COMPRESSED = ("csr", "csc", "bsr")
"""Forms of sparse matrices whose indices scipy does not look at as it makes them."""
_TEXT = (".mtx", ".mtx.gz")


class _UnreadableError(ValueError):
    """What is wrong with a file, in words that say what is allowed."""


def read_labelled(
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
    path = Path(file)
    shown = f"{file}:{variable}" if variable else str(file)
    try:
        found = _read(path, variable)
        matrix, labels = found if isinstance(found, tuple) else (found, None)
        return _checked(matrix), labels
    except _UnreadableError as error:
        raise InputError(field, shown, str(error)) from None
    except MemoryError:
        raise InputError(field, shown, "a matrix that fits into memory") from None
    except OSError as error:
        reason = f" ({error.strerror})" if error.strerror else ""
        raise InputError(field, shown, f"a whole file that can be read{reason}") from error


def read_matrix(file: str | Path, variable: str | None = None, *, field: str = "file") -> csr_array:
    """The matrix alone, as :func:`read_labelled` reads it."""
    return read_labelled(file, variable, field=field)[0]


def _read(path: Path, variable: str | None) -> Any:
    """What a file holds."""
    if not path.is_file():
        raise _UnreadableError("a file: there is none of this name")
    if path.stat().st_size == 0:
        raise _UnreadableError("a matrix: the file is empty")
    kind, reader = _reader(path)
    if variable is not None and kind != "MATLAB":
        raise _UnreadableError("a .mat file where a variable is named")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # kinds of sparse matrices that scipy will give one day
            return reader(path, variable)
    except (_UnreadableError, OSError, MemoryError):
        raise
    except InputError as error:  # of the program that reads
        raise _UnreadableError(f"a whole {kind} file: {error.allowed}") from None
    except Exception as error:  # readers of foreign formats raise anything where a file is broken
        told = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise _UnreadableError(f"a whole {kind} file: {told}") from error


def _reader(path: Path) -> tuple[str, Callable[[Path, str | None], Any]]:
    """What reads a file, by its ending."""
    name = path.name.lower()
    if name.endswith(".mat"):
        return "MATLAB", _matlab
    if name.endswith(_TEXT):
        return "Matrix Market", _matrix_market
    if name.endswith(".npz"):
        return "scipy", _scipy
    return "PETSc", _petsc


def _matlab(path: Path, variable: str | None) -> Any:
    with path.open("rb") as stream:
        begin = stream.read(len(_NEWER))
    if begin.startswith(_HDF) or begin == _NEWER:
        raise _UnreadableError("MATLAB's format to version 7.2: save it with save(..., '-v7')")
    arrays = arrays_of(_PROGRAM, path)
    names = sorted({entry.rpartition(" ")[0] for entry in arrays})
    if variable is None and len(names) != 1:
        told = ", ".join(names) or "none"
        raise _UnreadableError(f"one matrix, or FILE:VARIABLE; the matrices are {told}")
    if variable is not None and variable not in names:
        raise _UnreadableError(f"a variable among {', '.join(names) or 'none'}")
    return _of_arrays(arrays, variable if variable is not None else names[0])


def _matrix_market(path: Path, _: str | None) -> Any:
    with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as stream:
        if stream.read(2) != b"%%":
            stream.seek(0)
            return read_abaqus_matrix(stream.read())
    return _of_arrays(arrays_of(_PROGRAM, path), "")


def _of_arrays(arrays: dict[str, Any], name: str) -> Any:
    """A matrix of those that the program read."""
    if f"{name} dense" in arrays:
        return arrays[f"{name} dense"]
    data, row, col, shape = (arrays[f"{name} {part}"] for part in ("data", "row", "col", "shape"))
    _check_size(*(int(n) for n in shape))
    return coo_array((data, (row, col)), shape=tuple(int(n) for n in shape))


def _scipy(path: Path, _: str | None) -> Any:
    from scipy.sparse import load_npz

    return load_npz(path)


def _petsc(path: Path, _: str | None) -> Any:
    """PETSc's AIJ matrices: sizes, entries of each row, columns, values; from the highest byte."""
    content = path.read_bytes()
    for whole in (np.dtype(">i4"), np.dtype(">i8")):
        head = np.frombuffer(content, whole, min(4, len(content) // whole.itemsize))
        if len(head) == 4 and head[0] == _PETSC_MATRIX:
            break
    else:
        raise _UnreadableError("a file .mat, .mtx, .mtx.gz, .npz, or a matrix of PETSc")
    rows, columns, entries = (int(number) for number in head[1:])
    _check_size(rows, columns)
    begin = 4 * whole.itemsize
    if entries == -1:  # dense, by rows
        return _values(content, begin, rows * columns).reshape(rows, columns)
    if entries < 0 or len(content) < begin + (rows + entries) * whole.itemsize + 8 * entries:
        raise _UnreadableError("a whole PETSc file: its end is missing")
    counts = np.frombuffer(content, whole, rows, begin).astype(np.int64)
    begin += rows * whole.itemsize
    indices = np.frombuffer(content, whole, entries, begin).astype(np.int64)
    begin += entries * whole.itemsize
    if counts.min(initial=0) < 0 or counts.sum() != entries:
        raise _UnreadableError("a whole PETSc file: rows and entries disagree")
    indptr = np.concatenate([[0], np.cumsum(counts)])
    return csr_array((_values(content, begin, entries), indices, indptr), shape=(rows, columns))


def _values(content: bytes, begin: int, count: int) -> Any:
    """Numbers to the end of a PETSc file."""
    left = len(content) - begin
    if left == 16 * count and count:
        raise _UnreadableError("real numbers, not complex")
    if left != 8 * count:
        raise _UnreadableError(f"a whole PETSc file: {left} bytes for {count} numbers")
    return np.frombuffer(content, ">f8", count, begin).astype(float)


def _check_size(rows: int, columns: int) -> None:
    if rows != columns:
        raise _UnreadableError(f"a square matrix, not {rows} x {columns}")
    if not 0 < rows <= LARGEST_SIZE:
        raise _UnreadableError(f"1 to {LARGEST_SIZE} rows, not {rows}")


def _checked(found: Any) -> csr_array:
    """A matrix of real finite numbers that are not all zero."""
    if not issparse(found):
        found = np.asarray(found)
    elif found.format in _COMPRESSED:
        try:
            found.check_format(full_check=True)
        except ValueError as error:
            raise _UnreadableError(f"a whole matrix: {error}") from None
    if found.ndim != 2:
        raise _UnreadableError(f"a matrix, not an array of {found.ndim} dimensions")
    _check_size(*found.shape)
    if np.issubdtype(found.dtype, np.complexfloating):
        raise _UnreadableError("real numbers, not complex")
    if not (np.issubdtype(found.dtype, np.number) or found.dtype == bool):
        raise _UnreadableError(f"numbers, not {found.dtype}")
    matrix = csr_array(found, dtype=float)
    matrix.sum_duplicates()
    if not np.isfinite(matrix.data).all():
        raise _UnreadableError("finite numbers")
    matrix.eliminate_zeros()
    if matrix.nnz > _MOST_ENTRIES:
        raise _UnreadableError(f"at most {_MOST_ENTRIES} entries, not {matrix.nnz}")
    if not matrix.nnz:
        raise _UnreadableError("a matrix with an entry that is not zero")
    return matrix
