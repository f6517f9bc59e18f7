"""Products of real matrices with complex vectors, most of which are real."""

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats


def real_times(matrix: Floats, vectors: NDArray[np.inexact]) -> Complexes:
    """A x in real arithmetic: imaginary parts of those columns alone that have one.

    Parameters
    ----------
    matrix
        A, shape (rows, k).
    vectors
        x, shape (k, columns).
    """
    vectors = np.asarray(vectors)
    turning = np.flatnonzero(vectors.imag.any(axis=0))
    image = matrix @ np.hstack([vectors.real, vectors.imag[:, turning]])
    columns = vectors.shape[1]
    result = image[:, :columns].astype(complex)
    result.imag[:, turning] = image[:, columns:]
    return result


def like_times[T: (Floats, Complexes)](matrix: Floats, vectors: T) -> T:
    """A x, complex where x is, each part in real arithmetic."""
    if not np.iscomplexobj(vectors):
        return matrix @ vectors
    image: T = np.empty((len(matrix), vectors.shape[1]), dtype=vectors.dtype)
    image.real, image.imag = matrix @ vectors.real, matrix @ vectors.imag
    return image
