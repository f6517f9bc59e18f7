"""Rotating bodies, also damped: integrals in closed form, waves that pass by, changes of frame.

Seen from the frame at rest, waves of m diameters on a free axisymmetric body have the eigenvalues
that they have at rest, shifted by +- i m Omega (without Coriolis forces, convective stiffness
included): a change of frame changes no decay. With Coriolis forces they are those of the frame of
the material, shifted alike.
"""

from functools import cache

import numpy as np
import pytest
from blocks import alone, scene_body
from bodies import shape_body
from covering import covering
from petsc_matrices import dense_pencil, quadratic_eigenvalues, to_numpy
from scipy.linalg import eigh

from cea.eigen.shifted import Shifted
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.motion import Rotation
from meshes.placement import Placement
from meshes.shapes import Annulus
from scenes.running.system import coupled
from scenes.spec.reading import read_scene

INNER, OUTER = 0.6, 1.0
TURNED = Placement(axis=(1.0, 2.0, -0.5), angle=37.0, translation=(0.3, -0.2, 0.7))
KINDS = {
    "none": {},
    "alpha": {"alpha": 0.03},
    "beta": {"beta": 0.05},
    "modal": {"modal": {"ratio": 0.02, "max_frequency": 0.6}},
    "all": {
        "alpha": 0.01,
        "beta": 0.03,
        "modal": {"ratios": [0.02, 0.01], "frequencies": [0.2, 0.6]},
    },
}
RATE = "bodies.part.rotation.rate"


@pytest.mark.parametrize(
    ("backend", "coriolis", "placement"),
    covering(["iga", "fe"], [True, False], [None, TURNED]),
)
def test_linear_fields_have_their_integrals(backend, coriolis, placement):
    """For u = A r, v = B r with W v = a x v: R u = A W r, less W A r without Coriolis forces.

    int rho r r^T follows from the radii. Cells of degree 2 that span 15 degrees are round to some
    1e-5; of NURBS, quadrature is not exact for rational functions.
    """
    cell = {"iga": None, "fe": "hexahedron"}[backend]
    options = {"material": IsotropicMaterial(1.0, 0.3, 1.5), "placement": placement or Placement()}
    part = shape_body(Annulus(INNER, OUTER, -0.15, 0.15), cell, 2, (2, 24, 1), **options)
    turn, shift = np.eye(3), np.zeros(3)
    if placement:
        turn, shift = placement.rotation, np.array(placement.translation)
    rotation = Rotation(1.0, tuple(turn[:, 2]), tuple(shift), coriolis=coriolis)
    Y, Z = to_numpy(part.gyroscopic(rotation)), to_numpy(part.convective_stiffness(rotation))
    plane = np.pi * (OUTER**4 - INNER**4) / 4 * 0.3
    axial = np.pi * (OUTER**2 - INNER**2) * 0.3**3 / 12
    moments = 1.5 * turn @ np.diag([plane, plane, axial]) @ turn.T
    rng = np.random.default_rng(3)
    A, B, W = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), rotation.spin(3)
    u, v = (((part.space.dof_positions - shift) @ matrix.T).ravel() for matrix in (A, B))
    RA, RB = ((M @ W if coriolis else M @ W - W @ M) for M in (A, B))
    tolerance = {"iga": 1e-8, "fe": 1e-3}[backend] * np.abs(moments).max()
    assert v @ Y @ u == pytest.approx(2 * np.trace(B.T @ RA @ moments), abs=tolerance)
    assert v @ Z @ u == pytest.approx(np.trace(RB.T @ RA @ moments), abs=tolerance)


@cache
def system(backend, kind, fine=1, springs=(), *, coriolis=False):
    """A ring with round numbers that rotates at 1 rad/s, damped."""
    part = scene_body(
        backend,
        {"shape": "ring", "inner_radius": INNER, "outer_radius": OUTER},
        [fine, 12 * fine],
        material={"E": 1.0, "nu": 0.3, "rho": 1.5},
        springs=[dict(each) for each in springs],
        rotation={"rate": 1.0, "convective_stiffness": True, "coriolis": coriolis},
    )
    if KINDS[kind]:
        part["damping"] = KINDS[kind]
    return coupled(read_scene(alone(part)))[0]


def sums(made, rate):
    """M, D and K of a system at a rate, dense."""
    return dense_pencil(made.pencil().at({RATE: rate}))


@cache
def waves(backend, kind, fine):
    """Lambda with Im > 0 of the lowest waves at rest, by their number of diameters.

    That is how fast they pass by: the largest eigenvalue of X^T B X of modes X of one frequency.
    """
    M, D, K = sums(system(backend, kind, fine), 0.0)
    every = quadratic_eigenvalues(M, D, K)
    part = system(backend, "alpha", fine).bodies["part"]
    B = 0.5 * to_numpy(part.gyroscopic(Rotation(1.0, coriolis=False)))
    kappa, vectors = eigh(K, M)
    found, first = {}, 0
    while first < 40:
        near = np.abs(kappa - kappa[first]) < 2e-3 * kappa[first] + 1e-6
        members = np.flatnonzero(near & (np.arange(len(kappa)) >= first))
        turning = vectors[:, members].T @ B @ vectors[:, members]
        m = round(float(np.abs(np.linalg.eigvals(turning)).max()))
        if kappa[first] > 1e-3 and 0 < m < 4 and m not in found:
            nearest = every[np.argsort(np.abs(every - 1j * np.sqrt(kappa[first])))]
            found[m] = nearest[nearest.imag > 0][0]
        first = members[-1] + 1
    return found


def passing(backend, kind, fine, rate):
    """Eigenvalues at a rate near each wave at rest shifted by +- i m Omega, and those shifted."""
    found = quadratic_eigenvalues(*sums(system(backend, kind, fine), rate))
    for m, value in waves(backend, kind, fine).items():
        for sign in (-1, 1):
            wanted = value + sign * 1j * m * rate
            yield m, found[np.abs(found - wanted).argmin()], wanted


@pytest.mark.convergence
def test_waves_of_a_free_ring_pass_by_with_their_number_times_the_rate(backend):
    """They are lambda_0 +- i m Omega, with the fourth power of the mesh size."""
    coarse, fine = (
        max(
            abs(near - wanted) / (m * 0.05) for m, near, wanted in passing(backend, "none", n, 0.05)
        )
        for n in (1, 2)
    )
    assert fine < 3e-3
    assert coarse / fine > 12


@pytest.mark.grid
@pytest.mark.parametrize("kind", list(KINDS)[1:])
@pytest.mark.parametrize("part", [0.0, 0.4, 1.0, 1.5])
def test_decay_of_a_free_ring_does_not_depend_on_the_rate(backend, kind, part):
    """At the critical rate the first backward wave stands still."""
    lowest = waves(backend, kind, 2)
    assert len(lowest) >= 2
    rate = part * min(value.imag / m for m, value in lowest.items())
    for _, near, wanted in passing(backend, kind, 2, rate):
        assert near.real == pytest.approx(wanted.real, rel=3e-3)


@pytest.mark.grid
@pytest.mark.parametrize("kind", ["alpha", "beta", "modal"])
@pytest.mark.parametrize("rate", [0.1, 0.19, 0.28])
def test_with_coriolis_forces_decay_is_that_in_the_frame_of_the_material(backend, kind, rate):
    """There lambda^2 M + lambda (C + 2 Omega G) + K - Omega^2 M, G = int rho v . (a x u).

    The first backward wave stands still at a rate of 0.19.
    """
    made = system(backend, kind, fine=2, coriolis=True)
    M, C, K = sums(made, 0.0)
    spin = np.kron(np.eye(len(M) // 2), Rotation(1.0).spin(2))
    inside = quadratic_eigenvalues(M, C + 2 * rate * M @ spin, K - rate**2 * M)
    outside = quadratic_eigenvalues(*sums(made, rate))
    chosen = inside[(np.abs(inside) > 0.3) & (np.abs(inside) < 1.6)]
    assert len(chosen) > 8
    turns = 1j * rate * np.arange(-8, 9)
    for value in chosen:
        distance = np.abs(outside[:, None] - value - turns).min(axis=1)
        assert distance.min() < 2e-3 * abs(value)
        assert outside[distance.argmin()].real == pytest.approx(value.real, rel=1e-2)


@pytest.mark.parametrize("kind", ["beta", "modal", "all"])
@pytest.mark.parametrize("rate", [1e-3, 2.0])
def test_systems_with_it_are_solved(kind, rate):
    made = system("fe", kind)
    M, D, K = sums(made, rate)
    matrices = made.pencil().at({RATE: rate})
    rng = np.random.default_rng(5)
    x = rng.normal(size=(len(M), 3)) + 1j * rng.normal(size=(len(M), 3))
    for shift in (0.2, 0.3):
        factors = Shifted.quadratic(matrices, shift)
        P = shift**2 * M + shift * D + K
        for transposed, matrix in ((False, P), (True, P.T)):
            b = np.asfortranarray(matrix @ x)
            found = factors.solve_block(b, transposed=transposed)
            np.testing.assert_allclose(found, x, rtol=0, atol=1e-7)
        factors.free()


def test_springs_stay_where_they_are_in_space(backend):
    """They damp velocities in space; nothing rotates of a body that is rigid on them."""
    springs = ((("surface", "inner"), ("stiffness", (0.3, 0.3))),)
    circulatory, without = (
        sums(each, 1.0)[2] - to_numpy(each.pencil().at().stiffness)
        for each in (system(backend, "beta", springs=springs), system(backend, "beta"))
    )
    np.testing.assert_allclose(circulatory, without, rtol=0, atol=1e-12 * np.abs(without).max())
    shift = np.tile(np.eye(2), (len(circulatory) // 2, 1))
    assert np.abs(circulatory @ shift).max() < 1e-5 * np.abs(circulatory).max()


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
