"""Products of real matrices with complex vectors, most of which are real."""

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats


def real_times(matrix: Floats, vectors: NDArray[np.inexact]) -> Complexes:
    """A x in real arithmetic: imaginary parts of those columns alone that have one."""
    vectors = np.asarray(vectors)
    turning = np.flatnonzero(vectors.imag.any(axis=0))
    image = matrix @ np.hstack([vectors.real, vectors.imag[:, turning]])
    columns = vectors.shape[1]
    result = image[:, :columns].astype(complex)
    result.imag[:, turning] = image[:, columns:]
    return result
