"""Prolongation between two discretisations of one NURBS body: knot insertion, degree elevation.

Along each parameter a coefficient of the fine spline is read off one of its knot spans, on which
the coarse spline is interpolated: that is exact where the fine space holds the coarse one, and a
quasi-interpolation of full order where it does not, as with a higher degree *and* continuity (Lee,
Lyche & Morken, Some examples of quasi-interpolants, 2001). Rational functions with weights w are
prolonged by their numerators, P = diag(A w)^-1 A diag(w) with A the tensor product.
"""

from functools import reduce

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, kron, vstack

from cea.arrays import Floats, Ints
from cea.errors import InputError
from iga_cea.multipatch import Multipatch
from iga_cea.patch import Patch
from iga_cea.splines import basis_functions, basis_matrix, gauss_rule

_ROUNDING = 1e-14
"""Coefficients that are dropped: entries of a partition of unity, and what rounding makes."""
_SAME = 1e-6
"""Distance, relative to its size, within which a body is the same in both discretisations."""


def prolongation(coarse: Multipatch, fine: Multipatch, rank: int, field: str) -> csr_array:
    """Rows of a rank of the prolongation from one space of a body to another of the same patches.

    Exact where the fine spaces hold the coarse ones: knots inserted, degrees raised with continuity
    kept, in any direction. Supports on faces along which held directions turn are projected on
    each space (:mod:`iga_cea.supports`).
    """
    before, after = coarse.patches, fine.patches
    if len(before) != len(after) or coarse.dim != fine.dim:
        allowed = f"{len(before)} in {coarse.dim} dimensions, as the coarse body has"
        raise InputError(field, f"{len(after)} in {fine.dim} dimensions", allowed)
    first, last = fine.dof_ranges[rank : rank + 2]
    columns = coarse.num_scalar_dofs
    rows, numbers = [], []
    for number, (one, other) in enumerate(zip(before, after, strict=True)):
        matrix = _of_patch(one, other, f"{field}[{number}]")
        dofs, place = np.unique(fine.dofs[number].ravel(), return_index=True)
        own = (dofs >= first) & (dofs < last)
        part = coo_array(matrix[place[own]])
        entries = (part.data, (part.row, coarse.dofs[number].ravel()[part.col]))
        rows.append(csr_array(coo_array(entries, shape=(int(own.sum()), columns))))
        numbers.append(dofs[own])
    # A dof of several patches takes its row from the first.
    place = np.unique(np.concatenate(numbers), return_index=True)[1]
    return csr_array(csr_array(vstack(rows, format="csr"))[place])


def _of_patch(coarse: Patch, fine: Patch, field: str) -> csr_array:
    """Coefficients on a fine patch from those on a coarse one."""
    along, error = [], 0.0
    for p, knots, q, refined in zip(
        coarse.degrees, coarse.knots, fine.degrees, fine.knots, strict=True
    ):
        ends, refined_ends = knots[[0, -1]], refined[[0, -1]]
        if not np.allclose(ends, refined_ends, rtol=0.0, atol=1e-10 * np.ptp(ends)):
            raise InputError(f"{field}.knots", refined_ends.tolist(), f"from {ends.tolist()}")
        matrix, apart = _of_splines(knots, p, refined, q)
        along.append(matrix)
        error = max(error, apart)
    tensor = csr_array(reduce(lambda a, b: kron(a, b, format="csr"), along))
    weights = coarse.weights.ravel()
    prolonged = tensor @ weights
    matrix = csr_array(diags_array(1 / prolonged) @ tensor @ diags_array(weights))
    points = fine.control_points.reshape(-1, fine.dim)
    difference = np.abs(matrix @ coarse.control_points.reshape(-1, fine.dim) - points).max()
    apart = float(difference / np.linalg.norm(np.ptp(points, axis=0)))
    if apart > max(_SAME, error):
        raise InputError(f"{field}.control_points", f"{apart:.3g} apart", "one body in both")
    return matrix


def _of_splines(knots: Floats, p: int, refined: Floats, q: int) -> tuple[csr_array, float]:
    """Coefficients on fine knots from those on coarse ones, and their largest error."""
    breaks = np.unique(refined)
    count = len(refined) - q - 1
    span = _spans_of_functions(refined, q, breaks)
    points = _inside(breaks, q + 1)[span]
    at = points.ravel()
    first, values = basis_functions(refined, q, at)
    local = values[0].reshape(count, q + 1, q + 1)
    own = np.arange(count) - first.reshape(count, q + 1)[:, 0]
    unit = np.zeros((count, q + 1, 1))
    unit[np.arange(count), own] = 1.0
    functional = np.linalg.solve(local.swapaxes(1, 2), unit)[:, :, 0]
    sampled = basis_matrix(knots, p, at)
    gathered = csr_array(
        (functional.ravel(), np.arange(len(at)), np.arange(0, len(at) + 1, q + 1)),
        shape=(count, len(at)),
    )
    matrix = csr_array(gathered @ sampled)
    matrix.data[np.abs(matrix.data) < _ROUNDING] = 0.0
    matrix.eliminate_zeros()
    everywhere = gauss_rule(breaks, q + 2)[0].ravel()
    difference = basis_matrix(refined, q, everywhere) @ matrix - basis_matrix(knots, p, everywhere)
    return matrix, float(np.abs(difference).max())


def _spans_of_functions(knots: Floats, degree: int, breaks: Floats) -> Ints:
    """Span on which each function is largest at the middle: it is best told there, (functions,)."""
    middle = 0.5 * (breaks[1:] + breaks[:-1])
    return np.asarray(basis_matrix(knots, degree, middle).toarray().argmax(axis=0))


def _inside(breaks: Floats, n: int) -> Floats:
    """Chebyshev points of each span, (spans, n)."""
    nodes = np.cos(np.pi * (np.arange(n) + 0.5) / n)
    half = np.diff(breaks)[:, None] / 2
    return (breaks[1:, None] + breaks[:-1, None]) / 2 + half * nodes
