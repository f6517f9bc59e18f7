"""NURBS bodies for tests, and their matrices by slow loops that share nothing with the program."""

from functools import reduce
from itertools import pairwise, product

import numpy as np
from bodies import nurbs_body, shape_body
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, diags_array, kron

from cea.body import Body
from cea.material import IsotropicMaterial
from iga_cea.splines import basis_matrix
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Sector

STEEL = IsotropicMaterial(E=2.1, nu=0.3, rho=7.8)
TILTED = Placement(axis=(1.0, 2.0, -0.5), angle=33.0, translation=(0.1, -0.2, 0.3))
TURNED = Placement(angle=33.0, translation=(0.1, -0.2, 0.0))
"""Placement that stays in the plane."""


def body(shape, elements, degree, placement: Placement | None = None, **options) -> Body:
    """Body of a shape, turned in space or in the plane unless a placement says otherwise."""
    if placement is None:
        placement = TILTED if len(degree) == 3 else TURNED
    options.setdefault("material", STEEL)
    return shape_body(shape, None, tuple(degree), elements, placement=placement, **options)


def turned(patch: NurbsPatch, axes: tuple[int, ...], flip: int) -> NurbsPatch:
    """The same patch with its parameters in another order, one of them reversed."""
    dim = len(axes)
    control_points = np.flip(patch.control_points.transpose(*axes, dim), flip)
    knots = [patch.knots[a] for a in axes]
    breaks = [patch.breaks[a] for a in axes]
    knots[flip], breaks[flip] = 1 - knots[flip][::-1], 1 - breaks[flip][::-1]
    return NurbsPatch(
        tuple(patch.degrees[a] for a in axes),
        tuple(knots),
        control_points,
        np.flip(patch.weights.transpose(axes), flip),
        tuple(breaks),
    )


def two_sectors(elements, degree, axes, flip, **options) -> Body:
    """Body of two sectors, the parameters of the second in another order, one of them reversed."""
    shapes = (Sector(0.8, 1.7, a, b, -0.1, 0.2) for a, b in ((10.0, 60.0), (60.0, 95.0)))
    one, other = (nurbs_shape(s, breaks_of(s, elements), TILTED)[0][0] for s in shapes)
    options.setdefault("material", STEEL)
    return nurbs_body("part", [one, turned(other, axes, flip)], degree=degree, **options)


def slow_matrices(part: Body) -> tuple[np.ndarray, np.ndarray]:
    """K and M by loops over patches, elements and points: basis by scipy, B^T D B (Voigt)."""
    dim = part.dim
    size = dim * part.num_scalar_dofs
    K, M = np.zeros((2, size, size))
    pairs = {2: [(0, 0), (1, 1), (0, 1)], 3: [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]}[dim]
    lam, mu = part.material.lame
    D = np.diag([2 * mu] * dim + [mu] * (len(pairs) - dim))
    D[:dim, :dim] += lam
    for dof, R, grad, dV, _ in slow_points(part):
        B = np.zeros((len(pairs), len(R), dim))
        for row, (i, j) in enumerate(pairs):
            B[row, :, i] = grad[j]
            B[row, :, j] = grad[i]
        B = B.reshape(len(pairs), -1)
        full = (dim * dof[:, None] + np.arange(dim)).ravel()
        np.add.at(K, np.ix_(full, full), dV * B.T @ D @ B)
        for c in range(dim):
            at = np.ix_(dim * dof + c, dim * dof + c)
            np.add.at(M, at, dV * part.material.rho * np.outer(R, R))
    return K, M


def slow_points(part: Body):
    """At each Gauss point: scalar dofs, their functions, gradients, weight (m^dim), position."""
    for patch, dofs in zip(part.space.multipatch.patches, part.space.multipatch.dofs, strict=True):
        yield from _points(patch, dofs.ravel())


def _points(patch, order):
    dim = patch.dim
    tables = []
    for knots, n, p in zip(patch.knots, patch.shape, patch.degrees, strict=True):
        spline = BSpline(knots, np.eye(n), p)
        nodes, weights = np.polynomial.legendre.leggauss(p + 1)
        spans = []
        for a, b in pairwise(np.unique(knots)):
            x = (a + b) / 2 + (b - a) / 2 * nodes
            values = zip(spline(x), spline(x, nu=1), (b - a) / 2 * weights, strict=True)
            spans.append(list(values))
        tables.append(spans)
    X, w = patch.control_points.reshape(-1, dim), patch.weights.ravel()
    for element in product(*tables):
        for point in product(*element):
            top = [
                reduce(np.multiply.outer, [p[int(k == d)] for k, p in enumerate(point)]).ravel() * w
                for d in (None, *range(dim))
            ]
            near = np.flatnonzero(np.any(top, axis=0))
            top = [f[near] for f in top]
            total = [f.sum() for f in top]
            R = top[0] / total[0]
            dR = np.array([(f - R * t) / total[0] for f, t in zip(top[1:], total[1:], strict=True)])
            J = X[near].T @ dR.T
            grad = np.linalg.solve(J.T, dR)
            dV = np.prod([p[2] for p in point]) * abs(np.linalg.det(J))
            yield order[near], R, grad, dV, X[near].T @ R


def basis_on_grid(patch, parameters):
    """Values of the rational basis on a tensor grid, (points, functions), C order."""
    factors = [
        basis_matrix(knots, degree, x)
        for knots, degree, x in zip(patch.knots, patch.degrees, parameters, strict=True)
    ]
    weighted = reduce(lambda a, b: kron(a, b, format="csr"), factors)
    weighted = weighted @ diags_array(patch.weights.ravel())
    return csr_array(diags_array(1 / weighted.sum(axis=1)) @ weighted)
