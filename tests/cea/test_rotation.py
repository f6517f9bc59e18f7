"""Rotating bodies: matrices against integrals in closed form, eigenvalues against known ones."""

from functools import cache

import numpy as np
import pytest
from bodies import shape_body
from covering import covering
from petsc_matrices import quadratic_eigenvalues, to_numpy
from scipy.linalg import eigh

from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.motion import Rotation
from meshes.placement import Placement
from meshes.shapes import Annulus, Ring

INNER, OUTER, RATE = 0.6, 1.0, 0.05
SOLID = Annulus(INNER, OUTER, -0.15, 0.15)
PLANE = Ring(INNER, OUTER)
TURNED = Placement(axis=(1.0, 2.0, -0.5), angle=37.0, translation=(0.3, -0.2, 0.7))


def body(backend, shape, fine=1, *, placement=None):
    """A small body with round numbers."""
    dim = len(shape.directions)
    cell = None if backend == "iga" else {2: "quadrilateral", 3: "hexahedron"}[dim]
    options = {"material": IsotropicMaterial(1.0, 0.3, 1.5), "placement": placement or Placement()}
    return shape_body(shape, cell, 2, (fine, 12 * fine, 1)[:dim], **options)


def matrices(part, rotation):
    """K, M, Y at 1 rad/s and Z as arrays."""
    pieces = part.stiffness(), part.mass()
    return [
        to_numpy(m)
        for m in (*pieces, part.gyroscopic(rotation), part.convective_stiffness(rotation))
    ]


@pytest.mark.parametrize(
    ("backend", "coriolis", "placement"),
    covering(["iga", "fe"], [True, False], [None, TURNED]),
)
def test_linear_fields_have_their_integrals(backend, coriolis, placement):
    """For u = A r, v = B r with W v = a x v: R u = A W r, less W A r without Coriolis forces.

    int rho r r^T follows from the radii. Cells of degree 2 that span 15 degrees are round to some
    1e-5; of NURBS, quadrature is not exact for rational functions.
    """
    part = body(backend, SOLID, placement=placement, fine=2)
    turn, shift = np.eye(3), np.zeros(3)
    if placement:
        turn, shift = placement.rotation, np.array(placement.translation)
    rotation = Rotation(1.0, tuple(turn[:, 2]), tuple(shift), coriolis=coriolis)
    _, _, Y, Z = matrices(part, rotation)
    plane = np.pi * (OUTER**4 - INNER**4) / 4 * 0.3
    axial = np.pi * (OUTER**2 - INNER**2) * 0.3**3 / 12
    moments = 1.5 * turn @ np.diag([plane, plane, axial]) @ turn.T
    rng = np.random.default_rng(3)
    A, B, W = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), rotation.spin(3)
    nodes = part.space.dof_positions
    u, v = ((matrix @ (nodes - shift).T).T.ravel() for matrix in (A, B))
    RA, RB = ((M @ W if coriolis else M @ W - W @ M) for M in (A, B))
    tolerance = {"iga": 1e-8, "fe": 1e-3}[backend]
    size = np.abs(moments).max()
    assert v @ Y @ u == pytest.approx(2 * np.trace(B.T @ RA @ moments), abs=tolerance * size)
    assert v @ Z @ u == pytest.approx(np.trace(RB.T @ RA @ moments), abs=tolerance * size)


@cache
def ring(backend, fine):
    """Matrices of a free ring at rest, with the lowest frequency of each number of waves.

    The number of waves of a mode is found by its displacement along r, the part of a pair in phase.
    """
    part = body(backend, PLANE, fine)
    K, M, _, _ = matrices(part, Rotation(0.0))
    kappa, vectors = eigh(K, M)
    points = part.surfaces["outer"].gauss_points(3)
    trace = part.surfaces["outer"].trace(points.at)
    theta = np.arctan2(points.x[:, 1], points.x[:, 0])
    found = {}
    for value, vector in zip(kappa[3:16], vectors.T[3:16], strict=True):
        radial = ((trace @ vector.reshape(-1, 2)) * points.normal).sum(axis=1)
        waves = [abs(points.weight @ (radial * np.exp(1j * m * theta))) for m in range(7)]
        found.setdefault(int(np.argmax(waves)), np.sqrt(value))
    return part, found


def apart(backend, fine):
    """Largest error of lambda_0 +- i m Omega for the lowest pairs of 2 to 5 waves.

    It is relative to m Omega, and the reference is the pair at rest on the same mesh.
    """
    part, frequencies = ring(backend, fine)
    K, M, Y, Z = matrices(part, Rotation(RATE, coriolis=False))
    found = quadratic_eigenvalues(M, RATE * Y, K - RATE**2 * Z)
    errors = []
    for m in (2, 3, 4):
        for sign in (-1, 1):
            wanted = 1j * (frequencies[m] + sign * m * RATE)
            errors.append(np.abs(found - wanted).min() / (m * RATE))
    return max(errors)


@pytest.mark.convergence
def test_waves_of_a_free_ring_pass_by_with_their_number_times_the_rate(backend):
    """They are lambda_0 +- i m Omega, with the fourth power of the mesh size."""
    coarse, fine = apart(backend, 1), apart(backend, 2)
    assert fine < 3e-3
    assert coarse / fine > 12


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"rate": -1.0}, "rate"),
        ({"rate": float("nan")}, "rate"),
        ({"rate": 1.0, "axis": (0.0, 0.0, 0.0)}, "axis"),
        ({"rate": 1.0, "origin": (float("inf"), 0.0, 0.0)}, "origin"),
    ],
)
def test_rotations_that_are_none_are_refused(options, named):
    with pytest.raises(InputError, match=rf"rotation\.{named}"):
        Rotation(**options)
