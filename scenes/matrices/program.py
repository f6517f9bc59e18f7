"""A program: the matrices of a MATLAB or Matrix Market file, read by scipy, as arrays (.npz).

It is run apart from this one (:mod:`meshes.files.sandbox`), since a broken file may crash a reader.
"""

import sys
from typing import Any

import numpy as np
from scipy.io import loadmat, mminfo, mmread
from scipy.sparse import issparse


def main(file: str, arrays: str) -> None:
    """Write names of the matrices, and of each its entries."""
    try:
        matrices = loadmat(file) if file.endswith(".mat") else {"": _matrix_market(file)}
        parts: dict[str, Any] = {}
        for name, matrix in matrices.items():
            if issparse(matrix):
                whole: Any = matrix.tocoo()
                parts[f"{name} shape"] = np.array(whole.shape)
                parts[f"{name} row"], parts[f"{name} col"] = whole.row, whole.col
                parts[f"{name} data"] = whole.data
            elif isinstance(matrix, np.ndarray) and matrix.dtype.kind in "biufc":
                parts[f"{name} dense"] = matrix
        np.savez(arrays, **parts)
    except Exception as error:  # a reader raises anything where a file is broken
        sys.exit(str(error).splitlines()[0] if str(error) else type(error).__name__)


def _matrix_market(file: str) -> Any:
    """The matrix of a file that is packed or not."""
    field = mminfo(file)[4]
    if field in ("complex", "pattern"):
        raise ValueError(f"real numbers, not {field}")
    return mmread(file)


main(*sys.argv[1:])
