"""Stiffness and mass of many Lagrange cells at a time, by dense products.

With the gradients g_i of the basis functions, the stiffness of an isotropic solid follows from one
symmetric product over the points of a quadrature,

    G_(ai)(bj) = int d_a phi_i d_b phi_j,
    K_(ai)(bj) = lambda G_(ai)(bj) + mu G_(bi)(aj) + mu delta_ab sum_c G_(ci)(cj)

(T. J. R. Hughes, The Finite Element Method, 2000, sec. 2.8 and 3.10), and the mass is the same
scalar matrix int phi_i phi_j of every component. In the stiffness the components of a function
follow one another.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import basix
import numpy as np

from cea.arrays import Floats, Ints
from fe_cea.facets import geometry_element

_CHUNK_BYTES = 2**20
"""Size of the stiffness of the cells done at a time: it stays in the cache."""


@dataclass(frozen=True)
class _Rule:
    """Points of a quadrature on the reference cell, and what is tabulated there.

    Parameters
    ----------
    weights
        Weights, (points,).
    shape_slopes
        Derivatives of the basis functions of the geometry, (dim, points, nodes).
    products
        Products phi_i phi_j of basis functions, i <= j, (points, pairs).
    slopes
        Derivatives of the basis functions, (points, dim, functions).
    """

    weights: Floats
    shape_slopes: Floats
    products: Floats
    slopes: Floats


class ElementMatrices:
    """Element matrices of a Lagrange space, of cells with straight or curved edges.

    Parameters
    ----------
    V
        Lagrange space (dolfinx), scalar or blocked.
    count
        Number of cells, the first of the mesh.
    chosen
        Which of them are done, and counted from zero; by default all.
    """

    def __init__(self, V: Any, count: int, chosen: Ints | None = None) -> None:
        mesh = V.mesh
        self._element = V.ufl_element().basix_element
        self._geometry = geometry_element(mesh)
        self._cell = mesh.basix_cell()
        self._dim = mesh.geometry.dim
        self._nodes = mesh.geometry.dofmaps[0][:count]
        if chosen is not None:
            self._nodes = self._nodes[chosen]
        self._x = mesh.geometry.x
        self._count = len(self._nodes)
        n = self.size
        self._pair = np.empty((n, n), dtype=np.intp)
        upper = np.triu_indices(n)
        self._pair[upper] = self._pair.T[upper] = np.arange(len(upper[0]))

    @property
    def size(self) -> int:
        """Basis functions of a cell."""
        return int(self._element.dim)

    def chunks(self) -> Iterator[slice]:
        """Cells to do at a time."""
        step = max(1, _CHUNK_BYTES // (8 * (self._dim * self.size) ** 2))
        return (slice(i, min(i + step, self._count)) for i in range(0, self._count, step))

    def rule(self, degree: int) -> _Rule:
        """Quadrature of a degree, and what is tabulated there."""
        points, weights = basix.make_quadrature(self._cell, degree)
        table = self._element.tabulate(1, points)[..., 0]
        shape_slopes = self._geometry.tabulate(1, points)[1:, :, :, 0]
        first, second = np.triu_indices(self.size)
        return _Rule(
            weights,
            np.ascontiguousarray(shape_slopes),
            table[0][:, first] * table[0][:, second],
            np.ascontiguousarray(table[1:].swapaxes(0, 1)),
        )

    def stiffness(self, cells: slice, rule: _Rule, lame: tuple[float, float]) -> Floats:
        """Elastic stiffness of cells (N/m), (cells, functions * dim, functions * dim), symmetric.

        Parameters
        ----------
        cells
            Cells of this rank.
        rule
            Quadrature.
        lame
            Lame parameters (lambda, mu) (N/m^2).
        """
        gradients = self._weighted_gradients(cells, rule)
        count, n, dim, points = gradients.shape
        gradients = gradients.reshape(count, n * dim, points)
        if points == 1:  # matrices so small that long loops must run over the cells
            each = np.ascontiguousarray(gradients[:, :, 0].T)
            K = _isotropic((each[:, None] * each).reshape(n, dim, n, dim, count), lame)
            return np.ascontiguousarray(K.reshape(n * dim, n * dim, count).transpose(2, 0, 1))
        # The product of a matrix with its transpose is symmetric to the last bit.
        G = np.matmul(gradients, gradients.swapaxes(1, 2)).reshape(count, n, dim, n, dim)
        K = _isotropic(np.moveaxis(G, 0, -1), lame)
        return np.moveaxis(K, -1, 0).reshape(count, n * dim, n * dim)

    def _weighted_gradients(self, cells: slice, rule: _Rule) -> Floats:
        """Gradients times roots of weights, (cells, functions, dim, points)."""
        J = self._jacobians(cells, rule)
        cofactors = _cofactors(J)
        det = (J[0] * cofactors[0]).sum(axis=0)
        cofactors *= np.sqrt(rule.weights[:, None] / np.abs(det))  # signs of det drop out of G
        dim, _, points, count = J.shape
        inverse = np.ascontiguousarray(cofactors.transpose(2, 3, 0, 1))
        gradients = inverse.reshape(points, count * dim, dim) @ rule.slopes
        by_cell = gradients.reshape(points, count, dim, -1).transpose(1, 3, 2, 0)
        return np.ascontiguousarray(by_cell)

    def _jacobians(self, cells: slice, rule: _Rule) -> Floats:
        """Derivatives dx_i / dX_c, (dim, dim, points, cells)."""
        x = self._x[self._nodes[cells], : self._dim].transpose(2, 1, 0)
        return np.matmul(rule.shape_slopes[None], x[:, None])

    def mass(self, cells: slice, rule: _Rule, density: float) -> Floats:
        """Scalar mass of cells (kg), (cells, functions, functions), symmetric.

        Parameters
        ----------
        cells
            Cells of this rank.
        rule
            Quadrature.
        density
            Density (kg/m^3).
        """
        J = self._jacobians(cells, rule)
        det = (J[0] * _cofactors(J)[0]).sum(axis=0)
        pairs = (density * rule.weights[:, None] * np.abs(det)).T @ rule.products
        return pairs[:, self._pair]


def _isotropic(G: Floats, lame: tuple[float, float]) -> Floats:
    """K from G, which is overwritten, both (functions, dim, functions, dim, cells)."""
    lam, mu = lame
    dim = G.shape[1]
    K = lam * G
    G *= mu
    trace = sum(G[:, c, :, c] for c in range(dim))
    for a, b in product(range(dim), repeat=2):
        K[:, a, :, b] += G[:, b, :, a]
        if a == b:
            K[:, a, :, a] += trace
    return K


def _cofactors(J: Floats) -> Floats:
    """Cofactors of matrices, both (dim, dim, ...)."""
    if len(J) == 2:
        return np.array([[J[1, 1], -J[1, 0]], [-J[0, 1], J[0, 0]]])
    return np.array([_cross(J[(r + 1) % 3], J[(r + 2) % 3]) for r in range(3)])


def _cross(a: Floats, b: Floats) -> Floats:
    """Cross product of vectors (3, ...)."""
    return np.array([a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)])
