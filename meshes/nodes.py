"""Nodes of curved cells: polynomials through Gauss-Lobatto points, given at equispaced nodes.

A polynomial of degree k through the equispaced points of an arc errs by h^(k+1), with a mean that
does not vanish when k is odd, and so do the eigenvalues of a body so bounded. Through the
Gauss-Lobatto points the mean error is h^(2k), the order at which eigenvalues of elements of
degree k converge. Mesh files hold equispaced nodes: those here lie on that polynomial. Up to
order 2 the two sets of points are one.
"""

from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.special import roots_jacobi

Floats = NDArray[np.float64]


def lobatto(order: int) -> Floats:
    """Gauss-Lobatto points of the unit interval, ends included, shape (order + 1,)."""
    inner = roots_jacobi(order - 1, 1, 1)[0] if order > 1 else np.empty(0)
    return (np.concatenate([[-1.0], inner, [1.0]]) + 1) / 2


def interpolate_arc(angles: Floats, order: int) -> Floats:
    """Points of the unit circle at the nodes of arcs of a given order.

    Parameters
    ----------
    angles
        Ends of the arcs (rad), rising, shape (n + 1,).
    order
        Degree of the polynomials.

    Returns
    -------
    ndarray
        Nodes, ``order`` to an arc and the last end, shape (n * order + 1, 2).
    """
    between = angles[:-1, None] + np.diff(angles)[:, None] * lobatto(order)
    circle = np.stack([np.cos(between), np.sin(between)], axis=-1)
    if order > 2:
        nodes = np.arange(order + 1)[:, None] / order
        circle = np.einsum("ij,njd->nid", _change(lobatto(order)[:, None], nodes, order), circle)
    return np.concatenate([circle[:, :-1].reshape(-1, 2), circle[-1, -1:]])


def simplex_changes(equispaced: Floats, order: int) -> tuple[Floats, Floats]:
    """Matrices from values at the equispaced nodes of a simplex to Lobatto-like ones, and back.

    The Lobatto-like node of index (i, j, ..) has barycentric coordinates (g_i, g_j, ..) / sum with
    g the Lobatto points of the interval: on each edge they are those points, and what lies on a
    face depends on the face alone.

    Parameters
    ----------
    equispaced
        Nodes of the reference simplex, shape (n, dim).
    order
        Degree of the polynomials.
    """
    last = 1 - equispaced.sum(axis=1, keepdims=True)
    index = np.rint(order * np.column_stack([equispaced, last])).astype(int)
    barycentric = lobatto(order)[index]
    warped = (barycentric / barycentric.sum(axis=1, keepdims=True))[:, :-1]
    return _change(equispaced, warped, order), _change(warped, equispaced, order)


def _change(known: Floats, wanted: Floats, order: int) -> Floats:
    """Matrix from values of a polynomial at known points to those at wanted points."""
    return np.linalg.solve(_monomials(known, order).T, _monomials(wanted, order).T).T


def _monomials(points: Floats, order: int) -> Floats:
    powers = [p for p in product(range(order + 1), repeat=points.shape[1]) if sum(p) <= order]
    return np.prod((2 * points[:, None] - 1) ** np.array(powers), axis=2)
