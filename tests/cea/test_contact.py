"""Contact algebra on both backends with every formulation: forces, symmetry, conservation."""

import numpy as np
import pytest
from blocks import FORMULATIONS, PLACEMENTS, assemble, two_blocks
from covering import covering
from motions import asymmetry, control_points, dense, product, resultant, rotation_of, unknowns

from cea.errors import InputError
from cea.matrices import gather

P, MU, CLOSURE = 3.0, 0.4, 1e-6


EVERY = pytest.mark.parametrize(
    ("backend", "formulation", "placement", "full_pass"),
    covering(["fe", "iga"], FORMULATIONS, PLACEMENTS, [False, True]),
    indirect=["backend", "formulation", "placement"],
)
"""Each formulation on each backend, placed either way, from one side or from both."""
SYSTEMS = {}


@pytest.fixture
def system(backend, formulation, placement, full_pass):
    """One for each case: the tests leave it as it is."""
    case = backend, str(formulation), str(placement), full_pass
    if case not in SYSTEMS:
        data = two_blocks(backend, formulation, placement, mu=MU, P=P)
        data["contacts"]["interface"]["full_pass"] = full_pass
        SYSTEMS[case] = assemble(data)
    return SYSTEMS[case]


def direction(system):
    """Direction k on the upper block."""
    return rotation_of(system) @ np.array([1.0, 0.5, 0.0]) / np.linalg.norm([1.0, 0.5])


@EVERY
def test_friction_pushes_a_along_k_and_b_against_it(system):
    halves, k = system.contacts, direction(system)
    normal = halves[0].interface.points.normal[0]
    assert halves[0].interface.points.weight.sum() == pytest.approx(0.3, rel=1e-11)
    x = unknowns(system, {"upper": lambda X: CLOSURE * np.ones((len(X), 1)) * normal})
    force = P * CLOSURE / len(halves)
    for contact, side in zip(halves, (1, -1), strict=False):
        points = contact.interface.points
        assert points.normal == pytest.approx(np.tile(side * normal, (len(points), 1)), abs=1e-12)
        assert contact.pressure(x) == pytest.approx(force / points.weight.sum(), rel=1e-11)
        for body, sign in (("upper", 1), ("lower", -1)):
            friction, scale = resultant(system, product(contact.K_f, x), body)
            assert friction == pytest.approx(sign * MU * force * k, abs=1e-13 * scale)
            pressure, scale = resultant(system, product(contact.K_n, x), body)
            assert -pressure == pytest.approx(-sign * force * normal, abs=1e-13 * scale)


@EVERY
def test_momentum_is_conserved(system):
    rng = np.random.default_rng(3)
    x = unknowns(system, dict.fromkeys(system.bodies, lambda X: rng.normal(size=X.shape)))
    for matrix in (each for contact in system.contacts for each in (contact.K_n, contact.K_f)):
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
    for contact in system.contacts:
        assert np.abs(gather(product(contact.gap, x))).max() <= 1e-12


@EVERY
def test_normal_stiffness_is_exactly_symmetric(system):
    for contact in system.contacts:
        assert asymmetry(contact.K_n) == 0.0
        assert asymmetry(contact.K_f) > 0.1 * contact.K_f.norm()


@EVERY
def test_matrices_equal_a_loop_over_points(system):
    for contact, side in zip(system.contacts, (1, -1), strict=False):
        equals_a_loop(system, contact, side * direction(system))


def equals_a_loop(system, contact, k):
    interface, sizes = contact.interface, [3 * b.num_scalar_dofs for b in system.bodies.values()]
    starts = dict(zip(system.bodies, (0, sizes[0]), strict=True))
    sides = ((contact.a, interface.trace_a.toarray()), (contact.b, -interface.trace_b.toarray()))
    p = P / len(system.contacts) / interface.points.weight.sum()
    touched = np.flatnonzero(np.abs(sides[0][1]).sum(axis=0))
    projected = contact.is_projected
    rows = len(touched) if projected else 1
    K_n, K_f = np.zeros((2, sum(sizes), sum(sizes)))
    B, B_k = np.zeros((2, rows, sum(sizes)))
    M = np.zeros((rows, rows))
    for i, weight in enumerate(interface.points.weight):
        gap, slip = np.zeros((2, sum(sizes)))
        for operator, along in ((gap, interface.points.normal[i]), (slip, k)):
            for name, trace in sides:
                part = np.outer(trace[i], along).ravel()
                operator[starts[name] : starts[name] + len(part)] = part
        if projected:
            psi = sides[0][1][i, touched]
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
        assert np.abs(dense(matrix) - expected).max() <= tolerance * np.abs(expected).max()


def test_surfaces_that_do_not_meet_or_look_away_are_refused(backend, formulation):
    data = two_blocks(backend, formulation)
    data["bodies"]["upper"]["placement"] = {"translation": [0.0, 0.0, 2.0]}
    with pytest.raises(InputError, match=r"contacts.interface = .*find nothing on side b"):
        assemble(data)
    data = two_blocks(backend, formulation)
    for body in data["bodies"].values():
        body["geometry"]["origin"][2] = 0.1
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
