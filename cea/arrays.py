"""Array types, checked conversion of input to arrays, slices for chunked work, and groups."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cea.errors import InputError, require

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Complexes = NDArray[np.complex128]

_CHUNK_BYTES = 64_000_000


def chunks(count: int, bytes_each: float) -> Iterator[slice]:
    """Yield slices that cover ``range(count)``, each with about 64 MB of temporaries."""
    step = max(1, int(_CHUNK_BYTES / bytes_each))
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


def numbers(values: ArrayLike, field: str, allowed: str) -> NDArray[Any]:
    """Return real numbers as an array, keeping their type.

    Raise :class:`InputError`, which quotes ``allowed``, for text, booleans, complex numbers and
    ragged sequences.
    """
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        raise InputError(field, values, allowed) from error
    require(array.dtype.kind in "iuf", field, values, allowed)
    return array


def finite_numbers(values: ArrayLike, field: str, allowed: str) -> NDArray[np.float64]:
    """Return finite real numbers as an array of floats; raise as :func:`numbers` does."""
    array = numbers(values, field, allowed).astype(np.float64, copy=False)
    require(bool(np.isfinite(array).all()), field, values, allowed)
    return array


def of_size_one(vector: ArrayLike) -> NDArray[np.float64]:
    """Scale a vector by a power of two, without rounding, so that its norm cannot overflow."""
    values = np.asarray(vector, dtype=np.float64)
    return np.ldexp(values, -int(np.frexp(np.abs(values).max())[1]))


def arms_about(axis: ArrayLike, origin: Sequence[float], x: Floats) -> tuple[Floats, Floats]:
    """Return the unit vector of an axis, (3,), and lever arms from it to x (m), (n, 3)."""
    direction = of_size_one(axis)
    direction /= np.linalg.norm(direction)
    dim, arm = x.shape[1], np.zeros((len(x), 3))
    arm[:, :dim] = x - np.asarray(origin[:dim] or np.zeros(dim), dtype=np.float64)
    return direction, arm - np.outer(arm @ direction, direction)


def connected(pairs: Ints, count: int) -> Ints:
    """Return the group of each of ``count`` entries, from 0, such that pairs share a group."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def real_product(product: Callable[[Floats], Floats], block: NDArray[Any]) -> NDArray[Any]:
    """Return a real matrix, given by its product with real blocks, times a real or complex block.

    NumPy and LAPACK would convert the matrix to a complex one.
    """
    if not np.iscomplexobj(block):
        return product(block)
    image = product(np.ascontiguousarray(block).view(float))
    return np.ascontiguousarray(image).view(complex)
