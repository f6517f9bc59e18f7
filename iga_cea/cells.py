"""Bezier elements of the knot spans of a multipatch body, for visualisation."""

from functools import reduce

import numpy as np
from scipy.sparse import csr_array, diags_array, kron, vstack

from cea.arrays import Floats, Ints
from cea.body import VolumeCells
from iga_cea.multipatch import Multipatch
from iga_cea.patch import Patch
from iga_cea.splines import elevation_matrix, insertion_matrix

_ROUNDING = 1e-14
"""Drop tolerance of elevation, whose coefficients sum to one."""


def bezier_cells(multipatch: Multipatch) -> VolumeCells:
    """Return Bezier elements of all patches; spans share points within a patch only.

    Inserting knots up to multiplicity p turns a patch into Bezier elements (Borden, Scott, Evans &
    Hughes, Isogeometric finite element data structures based on Bezier extraction of NURBS, 2011).
    Degrees are then elevated to the highest one of any direction.
    """
    degree = max(max(patch.degrees) for patch in multipatch.patches)
    cells, values, weights, count = [], [], [], 0
    for patch, dofs in zip(multipatch.patches, multipatch.dofs, strict=True):
        extraction, weight = _extraction(patch, degree)
        columns = dofs.ravel()[extraction.indices]
        shape = (len(weight), multipatch.num_scalar_dofs)
        values.append(csr_array((extraction.data, columns, extraction.indptr), shape=shape))
        weights.append(weight)
        points = values[-1] @ multipatch.control_points
        cells.append(count + _elements([n * degree + 1 for n in patch.spans], degree, points))
        count += len(weight)
    every = csr_array(vstack(values, format="csr"))
    return VolumeCells(
        kind="bezier",
        simplex=False,
        degree=degree,
        points=every @ multipatch.control_points,
        weights=np.concatenate(weights),
        cells=np.concatenate(cells),
        values=every,
    )


def _extraction(patch: Patch, degree: int) -> tuple[csr_array, Floats]:
    """Return the map from rational to Bezier coefficients, (points, functions), and weights."""
    factors = []
    for knots, breaks, p in zip(patch.knots, patch.breaks, patch.degrees, strict=True):
        # With knots of multiplicity p every span has its own polynomials.
        bezier = np.repeat(breaks, [p + 1, *[p] * (len(breaks) - 2), p + 1])
        _, elevation = elevation_matrix(bezier, p, degree)
        elevation[np.abs(elevation) < _ROUNDING] = 0.0
        factors.append(csr_array(elevation @ insertion_matrix(knots, p, bezier)))
    weighted = reduce(lambda a, b: kron(a, b, format="csr"), factors) @ diags_array(
        patch.weights.ravel()
    )
    weight = weighted.sum(axis=1)
    return csr_array(diags_array(1 / weight) @ weighted), weight


def _elements(counts: list[int], degree: int, points: Floats) -> Ints:
    """Return the points of each right-handed Bezier element in C order, (elements, points).

    In left-handed patches the first parameter is reversed.
    """
    numbers = np.arange(len(points)).reshape(counts)
    size = (degree + 1,) * len(counts)
    windows = np.lib.stride_tricks.sliding_window_view(numbers, size)
    elements = windows[(slice(None, None, degree),) * len(counts)].reshape(-1, *size)
    ends = degree * (degree + 1) ** np.arange(len(counts))[::-1]
    corners = points[elements.reshape(len(elements), -1)[:, [0, *ends]]]
    if np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() < 0:
        elements = elements[:, ::-1]
    return elements.reshape(len(elements), -1)
