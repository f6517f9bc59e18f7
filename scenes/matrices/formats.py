"""Script that reads the matrices of a file of another program and writes them as arrays (.npz).

It runs in a separate process (:mod:`meshes.files.reading`), since a broken file may crash a reader.
It writes shape, rows, columns and entries of each matrix by name, which is "" except for MATLAB
files; for Abaqus matrices with labels also the node and degree of freedom of each row.
"""

import gzip
import sys
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat, mminfo, mmread
from scipy.sparse import coo_array, issparse, load_npz

_PETSC_MATRIX = 1211216
"""First number of a matrix in PETSc's binary format."""
_COORDINATES, _LABELS = 3, 5
"""Numbers per line of the two Abaqus formats."""


def main(file: str, arrays: str) -> None:
    """Read a file in the format given by its extension."""
    try:
        labels, name = None, file.lower()
        if name.endswith(".mat"):
            found = _matlab(file)
        elif name.endswith((".mtx", ".mtx.gz")):
            with gzip.open(file) if name.endswith(".gz") else Path(file).open("rb") as stream:
                begin = stream.read(2)
                content = b"" if begin == b"%%" else begin + stream.read()
            matrix, labels = _abaqus(content) if content else (_matrix_market(file), None)
            found = {"": matrix}
        elif name.endswith(".npz"):
            found = {"": load_npz(file)}
        else:
            found = {"": _petsc(Path(file).read_bytes())}
        parts = {} if labels is None else {"labels": labels}
        for each, matrix in found.items():
            whole: Any = coo_array(matrix)
            parts[f"{each} shape"] = np.array(whole.shape)
            parts[f"{each} row"], parts[f"{each} col"] = whole.coords
            parts[f"{each} data"] = whole.data
        np.savez(arrays, **parts)
    except Exception as error:  # readers raise various errors for broken files
        sys.exit(str(error).splitlines()[0] if str(error) else type(error).__name__)


def _matlab(file: str) -> dict[str, Any]:
    """Return matrices by name; skip tables, texts and arrays of more dimensions."""
    return {
        name: matrix
        for name, matrix in loadmat(file).items()
        if issparse(matrix)
        or (isinstance(matrix, np.ndarray) and matrix.ndim == 2 and matrix.dtype.kind in "biufc")
    }


def _matrix_market(file: str) -> Any:
    field = mminfo(file)[4]
    if field in ("complex", "pattern"):
        raise ValueError(f"real numbers, not {field}")
    return mmread(file)


def _abaqus(content: bytes) -> tuple[Any, Any]:
    """Return a matrix of `*MATRIX GENERATE` and the labels of its rows; the file has no header.

    Lines of three numbers are row, column and entry (FORMAT=COORDINATE); lines of five are node and
    degree of freedom of the row, the same of the column, and the entry (MATRIX INPUT, LABELS). The
    latter format defines a symmetric matrix by either triangle or by both.
    """
    try:
        table = np.loadtxt(BytesIO(content.replace(b",", b" ")), comments="*", ndmin=2)
    except ValueError as error:
        raise ValueError(f"neither '%%MatrixMarket ...' nor lines of Abaqus: {error}") from error
    if table.shape[1] not in (_COORDINATES, _LABELS):
        raise ValueError(f"lines of 3 or 5 numbers, not {table.shape[1]}")
    if not (np.abs(table[:, :-1]) < 2**53).all() or (table[:, :-1] % 1 != 0).any():
        raise ValueError("whole numbers of nodes, degrees of freedom, rows and columns")
    places, values = table[:, :-1].astype(np.int64), table[:, -1]
    if table.shape[1] == _COORDINATES:
        if places.min() < 1:
            raise ValueError("rows and columns counted from 1")
        labels, size, ends = None, int(places.max()), places.T - 1
    else:
        labels, row = np.unique(places.reshape(-1, 2), axis=0, return_inverse=True)
        size, ends = len(labels), row.reshape(-1, 2).T
    if len(np.unique(ends[0] * size + ends[1])) < len(values):
        raise ValueError("each entry once; a file that begins with its sizes needs the first line")
    return coo_array((values, tuple(ends)), shape=(size, size)), labels


def _petsc(content: bytes) -> Any:
    """Read a PETSc AIJ matrix: big-endian sizes, entries per row, columns, values; or dense."""
    for whole in (np.dtype(">i4"), np.dtype(">i8")):
        head = np.frombuffer(content[: 4 * whole.itemsize], whole)
        if len(head) == 4 and head[0] == _PETSC_MATRIX:
            break
    else:
        raise ValueError("a file .mat, .mtx, .mtx.gz, .npz, or a matrix of PETSc")
    rows, columns, entries = (int(number) for number in head[1:])
    if rows < 0 or columns < 0 or entries < -1:
        raise ValueError(f"{rows} x {columns} with {entries} entries")
    begin = 4 * whole.itemsize
    if entries == -1:  # dense, by rows
        return np.frombuffer(content, ">f8", offset=begin).astype(float).reshape(rows, columns)
    end = begin + (rows + entries) * whole.itemsize
    counts, indices = np.split(np.frombuffer(content[begin:end], whole).astype(np.int64), [rows])
    values = np.frombuffer(content, ">f8", offset=end).astype(float)
    if len(values) == 2 * entries > 0:
        raise ValueError("real numbers, not complex")
    return coo_array((values, (np.repeat(np.arange(rows), counts), indices)), shape=(rows, columns))


main(*sys.argv[1:])
