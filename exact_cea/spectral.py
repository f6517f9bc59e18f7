"""Continuous piecewise polynomials of high degree on an interval, and their Gauss quadrature."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]

_DEGREES_PER_LAYER = 2
_LOWEST_DEGREE = 4


@dataclass(frozen=True)
class Axis:
    """Basis of hat functions and integrated Legendre polynomials on an interval.

    Only the first and the last function do not vanish at the ends.
    (B. Szabo, I. Babuska, Finite Element Analysis, chapter 6.)
    """

    breaks: tuple[float, ...]  # boundaries of elements, increasing
    degrees: tuple[int, ...]  # polynomial degree of each element, 1 or more
    radial: bool = False  # whether the coordinate is a radius: integrals have the weight r

    @property
    def size(self) -> int:
        """Number of functions."""
        return sum(self.degrees) + 1

    @cached_property
    def points(self) -> Array:
        """Gauss points of all elements, shape (points,)."""
        reference, _ = self._gauss
        ends = np.array(self.breaks)
        middle, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
        return (middle[:, None] + half[:, None] * reference).ravel()

    @cached_property
    def weights(self) -> Array:
        """Quadrature weights, times r if radial, shape (points,)."""
        _, weight = self._gauss
        plain = (np.diff(self.breaks)[:, None] / 2 * weight).ravel()
        return plain * self.points if self.radial else plain

    @cached_property
    def tables(self) -> dict[str, sparse.csr_array]:
        """Functions ("value"), derivatives ("slope"), functions / r ("over_r") at the points."""
        reference, _ = self._gauss
        q = len(reference)
        values = np.zeros((len(self.points), self.size))
        slopes = np.zeros_like(values)
        first = 0
        for e, (degree, h) in enumerate(zip(self.degrees, np.diff(self.breaks), strict=True)):
            here = slice(e * q, (e + 1) * q), slice(first, first + degree + 1)
            shape, slope = _lobatto(degree, reference)
            values[here], slopes[here] = shape, slope * (2 / h)
            first += degree
        tables = {"value": values, "slope": slopes}
        if self.radial:
            tables["over_r"] = values / self.points[:, None]
        return {name: sparse.csr_array(table) for name, table in tables.items()}

    def gram(self, left: str, right: str, factor: Array | float = 1.0) -> sparse.csr_array:
        """Return integrals of products of two tables, times a factor at the points."""
        weighted = sparse.diags_array(self.weights * factor) @ self.tables[right]
        return sparse.csr_array(self.tables[left].T @ weighted)

    @cached_property
    def _gauss(self) -> tuple[Array, Array]:
        # Polynomials need degree + 1 points; 1 / r and sines need a few more.
        return legendre.leggauss(max(self.degrees) + 8)


@dataclass(frozen=True)
class Single:
    """The axis of a coordinate that is not resolved: one constant function."""

    size: int = 1

    def gram(self, left: str, right: str) -> sparse.csr_array:
        """Return the 1 x 1 matrix one."""
        del left, right
        return sparse.csr_array(np.ones((1, 1)))


def graded(
    start: float,
    end: float,
    degree: int,
    layers: int,
    ends: tuple[bool, bool],
    radial: bool = False,
) -> Axis:
    """Return an axis graded towards one or both ends: element sizes by 0.15, degrees by 2.

    This ratio is nearly optimal for corner singularities, and degrees that grow linearly from the
    corner lose no accuracy (I. Babuska, M. Suri, SIAM Review 36 (1994) 578-632).
    """
    if not (layers and any(ends)):
        return Axis((start, end), (degree,), radial)
    width = (end - start) / 2 if all(ends) else end - start
    offsets = width * np.concatenate([[0], 0.15 ** np.arange(layers, -1.0, -1.0)])
    fall = _DEGREES_PER_LAYER * np.arange(layers, -1, -1)
    rising = [int(value) for value in np.maximum(degree - fall, _LOWEST_DEGREE)]
    from_start, from_end = list(start + offsets), list((end - offsets)[::-1])
    if not ends[1]:
        return Axis((*from_start[:-1], end), tuple(rising), radial)
    if not ends[0]:
        return Axis((start, *from_end[1:]), tuple(rising[::-1]), radial)
    return Axis((*from_start, *from_end[1:]), tuple(rising + rising[::-1]), radial)


def _lobatto(degree: int, x: Array) -> tuple[Array, Array]:
    """Shape functions and derivatives on (-1, 1): left hat, bubbles, right hat, (points, n)."""
    shapes, slopes = [(1 - x) / 2], [np.full_like(x, -0.5)]
    for k in range(2, degree + 1):
        # Integral of P_{k-1}, scaled to unit energy: (P_k - P_{k-2}) / sqrt(2 (2k - 1)).
        scale = np.sqrt(2 * (2 * k - 1))
        upper, lower, middle = (np.eye(degree + 1)[i] for i in (k, k - 2, k - 1))
        shapes.append((legendre.legval(x, upper) - legendre.legval(x, lower)) / scale)
        slopes.append(legendre.legval(x, middle) * (2 * k - 1) / scale)
    shapes.append((1 + x) / 2)
    slopes.append(np.full_like(x, 0.5))
    return np.stack(shapes, axis=1), np.stack(slopes, axis=1)
