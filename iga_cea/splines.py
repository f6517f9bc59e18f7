"""B-splines of one parameter: basis, derivatives, knot insertion, degree elevation.

Knot vectors are open (first and last knot degree + 1 times). Points x, of shape (n,), lie in the
range of the knots.
References: Piegl & Tiller, The NURBS Book; Cohen, Lyche & Riesenfeld, Discrete B-splines (1980).
"""

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints

_HALVINGS = 60
"""Bisections: the bracket then is shorter than the spacing of floating point numbers."""


def find_span(knots: Floats, degree: int, x: Floats) -> Ints:
    """Index i of the non-empty span ``knots[i] <= x < knots[i + 1]``; the last one is closed."""
    spans = np.searchsorted(knots, x, side="right") - 1
    return np.clip(spans, degree, len(knots) - degree - 2)


def basis_functions(
    knots: Floats, degree: int, x: Floats, *, slopes: bool = False
) -> tuple[Ints, Floats]:
    """Values of the functions that do not vanish, and their slopes if wanted (Cox-de Boor).

    The number of the first of the ``degree + 1`` functions at each point, shape (n,), and of
    function ``first + j`` in ``[0, :, j]`` the value, in ``[1, :, j]`` the slope.
    """
    x = np.asarray(x, dtype=float)
    span = find_span(knots, degree, x)
    values = np.zeros((1 + slopes, len(x), degree + 1))
    lower = np.ones((len(x), 1))
    for q in range(1, degree + 1):
        # A function of degree q - 1 on the knots [left, right] is shared by two of degree q.
        after = span[:, None] + 1 + np.arange(q)
        left, right = knots[after - q], knots[after]
        share = lower / (right - left)
        lower = np.zeros((len(x), q + 1))
        lower[:, :-1] += (right - x[:, None]) * share
        lower[:, 1:] += (x[:, None] - left) * share
    if slopes and degree:  # of the last share, of functions of a degree less
        values[1, :, :-1] -= degree * share
        values[1, :, 1:] += degree * share
    values[0] = lower
    return span - degree, values


def basis_matrix(knots: Floats, degree: int, x: Floats, *, slopes: bool = False) -> csr_array:
    """All functions, or their slopes, at given points, shape (n, number of functions)."""
    first, values = basis_functions(knots, degree, x, slopes=slopes)
    columns = first[:, None] + np.arange(degree + 1)
    rows = np.arange(0, values[0].size + 1, degree + 1)
    shape = (len(first), len(knots) - degree - 1)
    return csr_array((values[int(slopes)].ravel(), columns.ravel(), rows), shape=shape)


def greville(knots: Floats, degree: int) -> Floats:
    """Greville abscissae: means of ``degree`` successive knots, one for each function."""
    windows = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree)
    # Rounding must not carry a mean outside the range.
    return np.clip(windows.mean(axis=1), knots[0], knots[-1])


def insertion_matrix(knots: Floats, degree: int, refined: Floats) -> Floats:
    """Coefficients on refined knots, which hold the others as often, from those on these (Oslo).

    Discrete B-splines, rows that are convex combinations, shape (refined, coarse functions).
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
    """Raise the degree: elevated knots, and coefficients on them from those on the knots.

    Knots are as much more frequent as the degree is higher. The spline is interpolated at the
    Greville abscissae of the elevated space, which holds it exactly; that interpolation is well
    conditioned at the degrees in use.
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
    """Knots that have every break often enough for the wanted continuity there.

    Knots the geometry already has keep at least their multiplicity. Breaks within 1e-10 of the
    range from a knot are that knot.
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
    """Gauss-Legendre points and weights, n between each two breaks, both (spans, n)."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    half = np.diff(breaks)[:, None] / 2
    middle = (breaks[1:, None] + breaks[:-1, None]) / 2
    return middle + half * nodes, half * weights


def botella(knots: Floats, degree: int) -> Floats:
    """Botella points: parameters of the maxima of the B-splines, one for each function.

    O. Botella, On a collocation B-spline method for the solution of the Navier-Stokes equations,
    Computers & Fluids 31 (2002).

    A B-spline i rises over its first span and falls over its last one, and has one maximum: it
    lies between knots i + 1 and i + degree, and bisection by the sign of the slope cannot fail.
    Where these knots are one, as at the ends, the function is 1 there.
    """
    function = np.arange(len(knots) - degree - 1)
    low, high = knots[function + 1], knots[function + degree]
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        first, table = basis_functions(knots, degree, middle, slopes=True)
        # A middle rounded to the end of a support finds its function gone: it has fallen.
        place = np.clip(function - first, 0, degree)
        rising = (table[1, function, place] > 0) & (place == function - first)
        low, high = np.where(rising, middle, low), np.where(rising, high, middle)
    return (low + high) / 2


def grid_points(parameters: tuple[Floats, ...]) -> Floats:
    """Points of a tensor grid in C order, shape (n, number of parameters)."""
    return np.stack(np.meshgrid(*parameters, indexing="ij"), axis=-1).reshape(-1, len(parameters))
