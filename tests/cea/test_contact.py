"""Contact algebra on both backends with every formulation: forces, symmetry, conservation."""

import numpy as np
import pytest
from blocks import FORMULATIONS, PLACEMENTS, assemble, two_blocks
from covering import covering
from motions import control_points, product, resultant, rotation_of, unknowns

from cea.errors import InputError
from cea.matrices import gather

P, MU, CLOSURE = 3.0, 0.4, 1e-6


EVERY = pytest.mark.parametrize(
    ("backend", "formulation", "placement"),
    covering(["fe", "iga"], FORMULATIONS, PLACEMENTS),
    indirect=True,
)
"""Each formulation on each backend, placed either way."""
SYSTEMS = {}


@pytest.fixture
def system(backend, formulation, placement):
    """One for each case: the tests leave it as it is."""
    case = backend, str(formulation), str(placement)
    if case not in SYSTEMS:
        SYSTEMS[case] = assemble(two_blocks(backend, formulation, placement, mu=MU, P=P))
    return SYSTEMS[case]


@EVERY
def test_friction_pushes_a_along_k_and_b_against_it(system):
    contact = system.contacts[0]
    normal = contact.interface.points.normal[0]
    assert np.ptp(contact.interface.points.normal, axis=0) == pytest.approx(0, abs=1e-12)
    x = unknowns(system, {"upper": lambda X: CLOSURE * np.ones((len(X), 1)) * normal})
    assert contact.pressure(x) == pytest.approx(P / 0.3 * CLOSURE, rel=1e-11)
    force = P * CLOSURE
    k = np.array([1.0, 0.5, 0.0]) / np.linalg.norm([1.0, 0.5])
    rotation = rotation_of(system)
    for body, sign in (("upper", 1), ("lower", -1)):
        friction, scale = resultant(system, product(contact.K_f, x), body)
        assert friction == pytest.approx(sign * MU * force * (rotation @ k), abs=1e-13 * scale)
        pressure, scale = resultant(system, product(contact.K_n, x), body)
        assert -pressure == pytest.approx(-sign * force * normal, abs=1e-13 * scale)


@EVERY
def test_momentum_is_conserved(system):
    rng = np.random.default_rng(3)
    x = unknowns(system, dict.fromkeys(system.bodies, lambda X: rng.normal(size=X.shape)))
    contact = system.contacts[0]
    for matrix in (contact.K_n, contact.K_f):
        force = product(matrix, x)
        (total_a, scale), (total_b, _) = (resultant(system, force, b) for b in system.bodies)
        assert np.abs(total_a + total_b).max() <= 1e-13 * scale
        moments = [
            np.cross(control_points(body), system.displacement(force, name).reshape(-1, 3)).sum(0)
            for name, body in system.bodies.items()
        ]
        assert np.abs(moments[0] + moments[1]).max() <= 1e-12 * scale


@EVERY
def test_common_rigid_motion_closes_no_gap(system):
    rotation = np.array([[0, -0.3, 0.2], [0.3, 0, -0.7], [-0.2, 0.7, 0]])
    x = unknowns(system, dict.fromkeys(system.bodies, lambda X: X @ rotation.T + [1.0, -2.0, 0.5]))
    gap = gather(product(system.contacts[0].gap, x))
    assert np.abs(gap).max() <= 1e-12


@EVERY
def test_normal_stiffness_is_exactly_symmetric(system):
    stiffness = system.contacts[0].K_n
    difference = stiffness.copy()
    difference.axpy(-1.0, stiffness.copy().transpose())
    assert difference.norm() == 0.0
    friction = system.contacts[0].K_f
    difference = friction.copy()
    difference.axpy(-1.0, friction.copy().transpose(), structure=False)
    assert difference.norm() > 0.1 * friction.norm()


@EVERY
def test_matrices_equal_a_loop_over_points(system):
    contact = system.contacts[0]
    interface = contact.interface
    offsets = np.cumsum([0, *(3 * b.num_scalar_dofs for b in system.bodies.values())])
    k = rotation_of(system) @ np.array([1.0, 0.5, 0.0]) / np.linalg.norm([1.0, 0.5])
    p = P / 0.3
    trace_a, trace_b = interface.trace_a.toarray(), interface.trace_b.toarray()
    touched = np.flatnonzero(np.abs(trace_a).sum(axis=0))
    projected = contact.is_projected
    rows = len(touched) if projected else 1
    K_n, K_f = np.zeros((2, offsets[-1], offsets[-1]))
    B, B_k = np.zeros((2, rows, offsets[-1]))
    M = np.zeros((rows, rows))
    for i, weight in enumerate(interface.points.weight):
        gap, slip = np.zeros((2, offsets[-1]))
        for operator, direction in ((gap, interface.points.normal[i]), (slip, k)):
            operator[: offsets[1]] = np.outer(trace_a[i], direction).ravel()
            operator[offsets[1] :] = -np.outer(trace_b[i], direction).ravel()
        if projected:
            psi = trace_a[i, touched]
            B += weight * np.outer(psi, gap)
            B_k += weight * MU * np.outer(psi, slip)
            M += weight / p * np.outer(psi, psi)
            continue
        at = np.flatnonzero((gap != 0) | (slip != 0))
        K_n[np.ix_(at, at)] += weight * p * np.outer(gap[at], gap[at])
        K_f[np.ix_(at, at)] += weight * p * MU * np.outer(slip[at], gap[at])
    if projected:
        multiplier = np.linalg.solve(M, B)
        K_n, K_f = B.T @ multiplier, B_k.T @ multiplier
    tolerance = 1e-11 if projected else 1e-13  # times the condition of M
    for matrix, expected in ((contact.K_n, K_n), (contact.K_f, K_f)):
        dense = matrix.copy().convert("dense").getDenseArray()
        assert np.abs(dense - expected).max() <= tolerance * np.abs(expected).max()


def test_surfaces_that_do_not_meet_are_refused(backend, formulation):
    data = two_blocks(backend, formulation)
    data["bodies"]["upper"]["placement"] = {"translation": [0.0, 0.0, 2.0]}
    with pytest.raises(InputError, match=r"contacts.interface = .*find nothing on side b"):
        assemble(data)


def test_surfaces_that_look_away_are_refused(backend, formulation):
    data = two_blocks(backend, formulation)
    data["bodies"]["upper"]["geometry"]["origin"][2] = 0.1
    data["bodies"]["lower"]["geometry"]["origin"][2] = 0.1
    data["contacts"]["interface"] |= {"b": "lower.z_min"}
    with pytest.raises(InputError, match="face each other"):
        assemble(data)


def test_overhang_is_allowed_up_to_the_stated_fraction(backend):
    data = two_blocks(backend, {"method": "gpts", "points": 3})
    data["bodies"]["upper"]["geometry"]["origin"][0] = 0.75
    with pytest.raises(InputError, match="of the area of side a"):
        assemble(data)
    data["contacts"]["interface"]["max_missed"] = 0.6
    interface = assemble(data).contacts[0].interface
    covered = interface.points.weight.sum() / interface.a.area
    assert covered == pytest.approx(0.5, abs=0.12)
    assert interface.points.x[:, 0].max() <= 1.0 + 1e-9
