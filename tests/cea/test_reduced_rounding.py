"""Bounds where a contact is stiff: rounding of the reduced matrices counts, entry by entry."""

import numpy as np
import pytest
from dense_reference import dense_eigenvalues
from petsc_matrices import to_numpy
from reduced_cases import MU, P, enrichment, grid, of_clusters, plane_blocks_pencil

from cea.reduced.greedy import TOLERANCE

TOP = 0.4
BONDED = {"formulation": {"method": "bonded"}, "P": 1e6, "mu": 0.0}
SLIDING = {
    "formulation": {"method": "gpts", "points": 3},
    "P": 1e6,
    "mu": 0.4,
    "friction_direction_on_a": {"vector": [1.0, 0.0]},
}


def inverse_of_the_saddle(matrices):
    """K^-1 on displacements with the contact forces beside them: accurate however stiff."""
    K, forces = to_numpy(matrices.stiffness), matrices.multipliers
    if matrices.unsymmetric is not None:
        K = K + to_numpy(matrices.unsymmetric)
    J, L, C = (to_numpy(getattr(forces, name)) for name in ("closure", "reaction", "compliance"))
    n, m = len(K), len(C)
    right = np.vstack([np.eye(n), np.zeros((m, n))])
    return np.linalg.solve(np.block([[K, L.T], [J, -C]]), right)[:n]


def dense_damped(matrices):
    """Eigenvalues lambda of the companion form of the inverse."""
    inverse = inverse_of_the_saddle(matrices)
    D, M = to_numpy(matrices.damping), to_numpy(matrices.mass)
    n = len(M)
    companion = np.block([[-inverse @ D, -inverse @ M], [np.eye(n), np.zeros((n, n))]])
    return 1 / np.linalg.eigvals(companion)


def truth(pencil, point):
    """Dense eigenvalues: kappa, or lambda of a damped pencil."""
    matrices = pencil.at(point)
    if pencil.damped:
        return dense_damped(matrices)
    return dense_eigenvalues(matrices, (2 * np.pi * TOP) ** 2).kappa


@pytest.mark.parametrize("damped", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.parametrize("contact", [BONDED, SLIDING], ids=["bonded", "sliding"])
def test_no_bound_is_passed_however_stiff_a_contact_is(backend, contact, damped):
    pencil = plane_blocks_pencil(backend, contact, alpha=0.02 * damped)
    assert pencil.forces
    assert pencil.damped == damped
    stiff = np.geomspace(1e4, 1e9, 4).tolist()
    box = {P: (stiff[0], stiff[-1])}
    points = [{P: p} for p in stiff]
    if contact is SLIDING:
        box[MU], points = (0.0, 1.0), grid(mu=[0.0, 1.0], P=stiff)
    built = enrichment(pencil, box, TOP)
    built.cover(points)
    small = built.model.small
    bounds = {}
    for point in points:
        found, true = small.at(pencil.values(point)), truth(pencil, point)
        errors, allowed = of_clusters(found, true)
        assert (errors < allowed).all()
        bounds.setdefault(point[P], []).append(found.bound)
    assert max(max(each) for each in bounds.values()) < 10 * TOLERANCE
