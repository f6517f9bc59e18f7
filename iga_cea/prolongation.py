"""Prolongation between two discretisations of a NURBS body: knot insertion, degree elevation.

Along each parameter a coefficient of the fine spline is computed on one of its knot spans, where
the coarse spline is interpolated: this is exact if the fine space contains the coarse one, else a
quasi-interpolation of full order, as for higher degree *and* continuity (Lee, Lyche & Morken, Some
examples of quasi-interpolants, 2001). Rational functions with weights w are prolonged by their
numerators, P = diag(A w)^-1 A diag(w) with A the tensor product.
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
"""Drop tolerance of coefficients, which are entries of a partition of unity."""
_SAME = 1e-6
"""Distance, relative to the body, above which the geometries are of different bodies."""


def prolongation(coarse: Multipatch, fine: Multipatch, rank: int, field: str) -> csr_array:
    """Return a rank's rows of the prolongation between two spaces of the same patches.

    Exact if the fine spaces contain the coarse ones: knots inserted, degrees elevated with
    continuity kept, in any direction. Supports whose directions vary on a face are projected on
    each space (:mod:`iga_cea.supports`).
    """
    before, after = coarse.patches, fine.patches
    if len(before) != len(after) or coarse.dim != fine.dim:
        allowed = f"{len(before)} in {coarse.dim} dimensions, as in the coarse body"
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
    # The row of a dof of several patches is that of the first patch.
    place = np.unique(np.concatenate(numbers), return_index=True)[1]
    return csr_array(csr_array(vstack(rows, format="csr"))[place])


def _of_patch(coarse: Patch, fine: Patch, field: str) -> csr_array:
    """Return the map of coefficients from a coarse to a fine patch."""
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
        raise InputError(f"{field}.control_points", f"{apart:.3g} apart", "the same body in both")
    return matrix


def _of_splines(knots: Floats, p: int, refined: Floats, q: int) -> tuple[csr_array, float]:
    """Return the map of coefficients from coarse to fine knots, and its largest error."""
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
    """Return the span on whose middle each function is largest, for conditioning, (functions,)."""
    middle = 0.5 * (breaks[1:] + breaks[:-1])
    return np.asarray(basis_matrix(knots, degree, middle).toarray().argmax(axis=0))


def _inside(breaks: Floats, n: int) -> Floats:
    """Return Chebyshev points of each span, (spans, n)."""
    nodes = np.cos(np.pi * (np.arange(n) + 0.5) / n)
    half = np.diff(breaks)[:, None] / 2
    return (breaks[1:, None] + breaks[:-1, None]) / 2 + half * nodes
