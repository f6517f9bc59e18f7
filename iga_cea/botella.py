"""Botella points: where each B-spline of one parameter is largest.

Reference: O. Botella, On a collocation B-spline method for the solution of the Navier-Stokes
equations, Computers & Fluids 31 (2002).
"""

import numpy as np

from cea.arrays import Floats
from iga_cea.splines import basis_functions

_HALVINGS = 60
"""Bisections: the bracket then is shorter than the spacing of floating point numbers."""


def botella(knots: Floats, degree: int) -> Floats:
    """Parameters of the maxima of the B-splines, one for each function.

    A B-spline i rises over its first span and falls over its last one, and has one maximum: it
    lies between knots i + 1 and i + degree, and bisection by the sign of the slope cannot fail.
    Where these knots are one, as at the ends, the function is 1 there.

    Parameters
    ----------
    knots
        Open knot vector.
    degree
        Degree, at least 1.
    """
    function = np.arange(len(knots) - degree - 1)
    low, high = knots[function + 1], knots[function + degree]
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        first, table = basis_functions(knots, degree, middle, 1)
        # A middle rounded to the end of a support finds its function gone: it has fallen.
        place = np.clip(function - first, 0, degree)
        rising = (table[1, function, place] > 0) & (place == function - first)
        low, high = np.where(rising, middle, low), np.where(rising, high, middle)
    return (low + high) / 2
