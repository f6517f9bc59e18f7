"""Univariate B-splines: basis, derivatives, knot insertion, degree elevation.

Knot vectors are open (first and last knot degree + 1 times). Points x, of shape (n,), lie in the
range of the knots.
References: Piegl & Tiller, The NURBS Book; Cohen, Lyche & Riesenfeld, Discrete B-splines (1980).
"""

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints

_HALVINGS = 60
"""Number of bisections, after which the bracket is below the spacing of floating point."""


def basis_functions(
    knots: Floats, degree: int, x: Floats, *, slopes: bool = False
) -> tuple[Ints, Floats]:
    """Return values, and optionally slopes, of the nonzero functions (Cox-de Boor).

    The results are the number of the first of the ``degree + 1`` functions at each point, shape
    (n,), and for function ``first + j`` the value in ``[0, :, j]``, the slope in ``[1, :, j]``.
    """
    x = np.asarray(x, dtype=float)
    # The nonempty span knots[i] <= x < knots[i + 1]; the last is closed.
    span = np.searchsorted(knots, x, side="right") - 1
    span = np.clip(span, degree, len(knots) - degree - 2)
    values = np.zeros((1 + slopes, len(x), degree + 1))
    lower = np.ones((len(x), 1))
    for q in range(1, degree + 1):
        # A function of degree q - 1 on the knots [left, right] contributes to two of degree q.
        after = span[:, None] + 1 + np.arange(q)
        left, right = knots[after - q], knots[after]
        share = lower / (right - left)
        lower = np.zeros((len(x), q + 1))
        lower[:, :-1] += (right - x[:, None]) * share
        lower[:, 1:] += (x[:, None] - left) * share
    if slopes and degree:  # from the last ``share``, of functions of degree - 1
        values[1, :, :-1] -= degree * share
        values[1, :, 1:] += degree * share
    values[0] = lower
    return span - degree, values


def basis_matrix(knots: Floats, degree: int, x: Floats, *, slopes: bool = False) -> csr_array:
    """Return all functions, or their slopes, at given points, shape (n, functions)."""
    first, values = basis_functions(knots, degree, x, slopes=slopes)
    columns = first[:, None] + np.arange(degree + 1)
    rows = np.arange(0, values[0].size + 1, degree + 1)
    shape = (len(first), len(knots) - degree - 1)
    return csr_array((values[int(slopes)].ravel(), columns.ravel(), rows), shape=shape)


def greville(knots: Floats, degree: int) -> Floats:
    """Return the Greville abscissae: means of ``degree`` successive knots, one per function."""
    windows = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree)
    # Rounding must not move a mean out of the range.
    return np.clip(windows.mean(axis=1), knots[0], knots[-1])


def insertion_matrix(knots: Floats, degree: int, refined: Floats) -> Floats:
    """Return the map of coefficients from knots to refined knots, which contain them (Oslo).

    Rows are discrete B-splines, convex combinations, shape (refined, coarse functions).
    """
    n = len(knots) - 1
    rows = len(refined) - degree - 1
    start = refined[:rows, None]
    values = ((knots[:-1] <= start) & (start < knots[1:])).astype(float)
    for q in range(1, degree + 1):
        width = knots[q:] - knots[:-q]
        share = values[:, : n - q + 1] / np.where(width > 0, width, 1.0)
        next_knot = refined[q : q + rows, None]
        rising = (next_knot - knots[: n - q]) * share[:, :-1]
        falling = (knots[q + 1 :] - next_knot) * share[:, 1:]
        values = rising + falling
    return values


def elevation_matrix(knots: Floats, degree: int, target: int) -> tuple[Floats, Floats]:
    """Return elevated knots, and the map of coefficients from the knots to them.

    Multiplicities grow with the degree. The spline is interpolated at the Greville abscissae of the
    elevated space, which contains it; this interpolation is well conditioned at the degrees in
    use.
    """
    if target == degree:
        return knots, np.eye(len(knots) - degree - 1)
    distinct, multiplicity = np.unique(knots, return_counts=True)
    elevated = np.repeat(distinct, multiplicity + target - degree)
    at = greville(elevated, target)
    matrix = np.linalg.solve(
        basis_matrix(elevated, target, at).toarray(), basis_matrix(knots, degree, at).toarray()
    )
    return elevated, matrix


def knots_with_breaks(knots: Floats, degree: int, breaks: Floats, continuity: int) -> Floats:
    """Return knots with the multiplicity at every break that gives the wanted continuity.

    Knots of the geometry keep at least their multiplicity. Breaks within 1e-10 of the range from a
    knot are that knot.
    """
    distinct, multiplicity = np.unique(knots, return_counts=True)
    distance = np.abs(np.asarray(breaks)[:, None] - distinct)
    near = distance.min(axis=1) <= 1e-10 * (knots[-1] - knots[0])
    at_knots = np.unique(distance[near].argmin(axis=1))
    multiplicity[at_knots] = np.maximum(multiplicity[at_knots], degree - continuity)
    new = np.unique(np.asarray(breaks)[~near])
    return np.sort(
        np.concatenate([np.repeat(distinct, multiplicity), np.repeat(new, degree - continuity)])
    )


def gauss_rule(breaks: Floats, n: int) -> tuple[Floats, Floats]:
    """Return Gauss-Legendre points and weights, n per span, both (spans, n)."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    half = np.diff(breaks)[:, None] / 2
    middle = (breaks[1:, None] + breaks[:-1, None]) / 2
    return middle + half * nodes, half * weights


def botella(knots: Floats, degree: int) -> Floats:
    """Return Botella points: parameters of the maxima of the B-splines, one per function.

    O. Botella, On a collocation B-spline method for the solution of the Navier-Stokes equations,
    Computers & Fluids 31 (2002).

    B-spline i increases on its first span and decreases on its last, and has one maximum, between
    knots i + 1 and i + degree, which bisection by the sign of the slope finds. If these knots are
    equal, as at the ends, the function is 1 there.
    """
    function = np.arange(len(knots) - degree - 1)
    low, high = knots[function + 1], knots[function + degree]
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        first, table = basis_functions(knots, degree, middle, slopes=True)
        # If a middle is rounded to the end of a support, the function is zero: it has decreased.
        place = np.clip(function - first, 0, degree)
        rising = (table[1, function, place] > 0) & (place == function - first)
        low, high = np.where(rising, middle, low), np.where(rising, high, middle)
    return (low + high) / 2


def grid_points(parameters: tuple[Floats, ...]) -> Floats:
    """Return the points of a tensor grid in C order, shape (n, number of parameters)."""
    return np.stack(np.meshgrid(*parameters, indexing="ij"), axis=-1).reshape(-1, len(parameters))
