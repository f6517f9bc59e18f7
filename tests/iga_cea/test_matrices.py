"""Matrices of NURBS bodies against slow loops: every degree, joint and map; refinement."""

from functools import partial

import numpy as np
import pytest
from bodies import nurbs_body
from iga_data import (
    STEEL,
    TILTED,
    TURNED,
    body,
    slow_matrices,
    slow_points,
    two_sectors,
)
from petsc_matrices import to_scipy

from cea.body import Body
from cea.motion import Rotation
from iga_cea.patch import refine
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.shapes import Box, Disc, RingSector, Sector

SECTOR = Sector(0.8, 1.7, 20.0, 85.0, -0.1, 0.2)
RING_SECTOR = RingSector(0.8, 1.7, 20.0, 85.0)
DEGREES = (2, 3, 5, 8)


def distorted(shape, elements, degree, *, weights, **options) -> Body:
    """Body of a shape with its control points moved, and its weights changed if wanted."""
    placement = TILTED if len(elements) == 3 else TURNED
    ((whole,), _) = nurbs_shape(shape, breaks_of(shape, elements), placement)
    fine = refine(whole, whole.degrees, [p - 1 for p in whole.degrees])
    rng = np.random.default_rng(3)
    moved = fine.control_points + 0.02 * rng.uniform(-1, 1, fine.control_points.shape)
    factors = 1 + 0.2 * rng.uniform(-1, 1, fine.weights.shape) if weights else 1.0
    patch = NurbsPatch(fine.degrees, fine.knots, moved, fine.weights * factors, whole.breaks)
    return nurbs_body("part", [patch], {}, degree, material=STEEL, **options)


def along(axis, q):
    """A box of one degree and three elements along an axis, bilinear across."""
    degree, continuity, elements = [1, 1, 1], [0, 0, 0], [1, 1, 1]
    degree[axis], continuity[axis], elements[axis] = q, q // 2, 3
    return body(Box((2.0, 1.0, 0.5)), elements, degree, continuity=continuity)


def bulging():
    """A box one control point of which is moved, where the points tried first do not feel it."""
    shape = Box((1.0, 12.0, 1.0))
    ((whole,), _) = nurbs_shape(shape, breaks_of(shape, (3, 12, 1)))
    fine = refine(whole, (1, 1, 1), (0, 0, 0))
    moved = fine.control_points.copy()
    moved[1, 4, 0] += 0.1
    patch = NurbsPatch(fine.degrees, fine.knots, moved, fine.weights, whole.breaks)
    return nurbs_body("part", [patch], {}, (2, 1, 1), material=STEEL)


slow = partial(pytest.param, marks=pytest.mark.slow)
PARTS = [
    # Continuity 0 along one parameter, the highest along the other.
    *((body, (RING_SECTOR, (2, 3), (q - 1, q)), {"continuity": (0, q - 1)}) for q in DEGREES),
    *((along, (q % 3, q), {}) for q in range(1, 7)),
    (two_sectors, ((2, 1, 1), (2, 2, 2), (1, 2, 0), 0), {"faces": {}}),
    slow(two_sectors, ((2, 1, 1), (2, 2, 2), (2, 1, 0), 2), {"faces": {}}),
    # Elements at the axis of a disc have several functions of one dof.
    (body, (Disc(1.2, -0.1, 0.2), (1, 8, 1), (2, 2, 1)), {}),
    *((distorted, (SECTOR, (2, 2, 1), q), {"weights": True}) for q in ((1, 3, 2), (5, 2, 1))),
    *(
        slow(distorted, (SECTOR, (2, 2, 1), q), {"weights": True})
        for q in ((1, 2, 1), (2, 2, 2), (1, 4, 1), (1, 2, 6))
    ),
    (distorted, (SECTOR, (2, 2, 1), (2, 2, 2)), {"weights": False}),
    # More spans than a window has, so that windows move.
    *(
        (distorted, (RING_SECTOR, (6, 5), (3, 3)), {"weights": weights, "continuity": continuity})
        for weights, continuity in ((True, None), (False, (0, 1)), (True, (2, 0)))
    ),
    (bulging, (), {}),
]


@pytest.mark.parametrize(("make", "arguments", "options"), PARTS)
def test_matrices_are_those_of_slow_loops(make, arguments, options):
    part = make(*arguments, **options)
    for ours, slow in zip((part.stiffness(), part.mass()), slow_matrices(part), strict=True):
        A = to_scipy(ours)
        assert np.abs(A.toarray() - slow).max() <= 1e-13 * np.abs(slow).max()
        assert abs(A - A.T).max() == 0


@pytest.mark.grid
@pytest.mark.parametrize("coriolis", [True, False])
@pytest.mark.parametrize("shape", ["disc", "distorted"])
def test_matrices_of_rotation(shape: str, coriolis: bool) -> None:
    """Y and Z against slow loops, where weights are a product and where not, and at an axis."""
    part = (
        body(Disc(1.2, -0.1, 0.2), (1, 8, 1), (2, 2, 1))
        if shape == "disc"
        else distorted(SECTOR, (2, 2, 1), (2, 2, 1), weights=True)
    )
    rotation = Rotation(1.0, (0.2, -0.5, 1.0), (0.3, 0.1, -0.2), coriolis=coriolis)
    spin, n = rotation.spin(3), part.num_scalar_dofs
    m, A, B = np.zeros((3, n, n))
    for dof, R, grad, dV, x in slow_points(part):
        t = (spin @ (x - rotation.origin)) @ grad
        dV *= STEEL.rho
        at = np.ix_(dof, dof)
        np.add.at(m, at, dV * np.outer(R, R))
        np.add.at(A, at, dV * (np.outer(R, t) - np.outer(t, R)))
        np.add.at(B, at, dV * np.outer(t, t))
    Y, Z = np.kron(A, np.eye(3)), np.kron(B, np.eye(3))
    if not coriolis:
        Y -= 2 * np.kron(m, spin)
        Z += np.kron(A, spin) + np.kron(m, spin.T @ spin)
    for ours, slow in ((part.gyroscopic(rotation), Y), (part.convective_stiffness(rotation), Z)):
        assert np.abs(to_scipy(ours).toarray() - slow).max() <= 1e-13 * np.abs(slow).max()


@pytest.mark.parametrize("weights", [pytest.param(False, marks=pytest.mark.slow), True])
def test_geometric_stiffness(weights: bool) -> None:
    part = distorted(SECTOR, (2, 2, 1), (2, 2, 1), weights=weights)
    u = np.random.default_rng(5).uniform(-1, 1, (part.num_scalar_dofs, 3))
    slow = np.zeros((part.num_scalar_dofs,) * 2)
    lam, mu = STEEL.lame
    for dof, _, grad, dV, _ in slow_points(part):
        slope = u[dof].T @ grad.T
        stress = lam * np.trace(slope) * np.eye(3) + mu * (slope + slope.T)
        np.add.at(slow, np.ix_(dof, dof), dV * grad.T @ stress @ grad)
    ours = to_scipy(part.geometric_stiffness(u.ravel())).toarray()
    slow = np.kron(slow, np.eye(3))
    assert np.abs(ours - slow).max() <= 1e-13 * np.abs(slow).max()
