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

from cea.material import IsotropicMaterial
from cea.motion import Rotation
from meshes.placement import Placement
from meshes.shapes import Annulus
from scenes.running.run import coupled
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


@pytest.mark.parametrize("coriolis", [True, False])
def test_linear_fields_have_their_integrals(backend, coriolis):
    """For u = A r, v = B r with W v = a x v: R u = A W r, less W A r without Coriolis forces.

    int rho r r^T follows from the radii. Cells of degree 2 that span 15 degrees are round to some
    1e-5; of NURBS, quadrature is not exact for rational functions.
    """
    cell = {"iga": None, "fe": "hexahedron"}[backend]
    options = {"material": IsotropicMaterial(1.0, 0.3, 1.5), "placement": TURNED}
    part = shape_body(Annulus(INNER, OUTER, -0.15, 0.15), cell, 2, (1, 24, 1), **options)
    turn, shift = TURNED.rotation, np.array(TURNED.translation)
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


def in_both_frames(backend, kind, coriolis, rate, fine=2):
    """Eigenvalues in the frame of the material, and of those at rest the nearest i m Omega away.

    In the material they are those of lambda^2 M + lambda (C + 2 Omega G) + K - Omega^2 M with
    G = int rho v . (a x u), or without Coriolis forces those of the body at rest.
    """
    made = system(backend, kind, fine, coriolis=coriolis)
    M, C, K = sums(made, 0.0)
    if coriolis:
        spin = np.kron(np.eye(len(M) // 2), Rotation(1.0).spin(2))
        C, K = C + 2 * rate * M @ spin, K - rate**2 * M
    inside = quadratic_eigenvalues(M, C, K)
    outside = quadratic_eigenvalues(*sums(made, rate))
    chosen = inside[(np.abs(inside) > 0.3) & (np.abs(inside) < 1.5)]
    assert len(chosen) > 8
    turns = 1j * rate * np.arange(-8, 9)
    distance = np.abs(outside[:, None, None] - chosen[:, None] - turns).min(axis=2)
    return chosen, outside[distance.argmin(axis=0)], distance.min(axis=0)


@pytest.mark.convergence
@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_waves_of_a_free_ring_pass_by_with_their_number_times_the_rate(backend):
    """With the fourth power of the mesh size."""
    coarse, fine = (in_both_frames(backend, "none", False, 0.05, n)[2].max() for n in (1, 2))
    assert fine < 1e-5
    assert coarse / fine > 12


@pytest.mark.parametrize(
    ("backend", "kind", "rate", "coriolis"),
    covering(["iga", "fe"], list(KINDS)[1:], [0.1, 0.19, 0.28], [False, True], strength=1),
)
def test_decay_of_a_free_ring_does_not_depend_on_the_frame(backend, kind, rate, coriolis):
    """With Coriolis forces the first backward wave stands still at a rate of 0.19."""
    inside, outside, distance = in_both_frames(backend, kind, coriolis, rate)
    assert (distance < 2e-3 * np.abs(inside)).all()
    assert outside.real == pytest.approx(inside.real, rel=1e-2)


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
