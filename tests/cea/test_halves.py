"""Lumped contact, full passes, bonded joints: what each conserves, and the patch test."""

from pathlib import Path

import numpy as np
import pytest
from blocks import PLACEMENTS, ROTATED, assemble, block, coarse, two_blocks
from covering import covering
from motions import dense, product, resultant, unknowns

from cea.eigen.driver import solve_modes
from cea.matrices import gather
from scenes import run_scene
from scenes.spec.reading import load_scene

P, MU = 3.0, 0.4
GPTS = {"method": "gpts", "points": 4}
LUMPED = GPTS | {"lumped": True}


@pytest.mark.parametrize(
    ("backend", "placement"),
    covering(["iga", "fe"], PLACEMENTS, strength=1),
    indirect=["placement"],
)
def test_lumped_matrices_are_sums_over_columns_of_a_loop(backend, placement):
    """Paper eq. 41: in a-a and b-b scalar row i is summed over scalar columns j onto i."""
    contact = assemble(coarse(two_blocks(backend, LUMPED, placement, mu=MU, P=P))).contacts[0]
    interface = contact.interface
    normal, p = interface.points.normal, P / 0.3
    k = contact.friction.along(interface.points.x, normal)
    traces = [interface.trace_a.toarray(), interface.trace_b.toarray()]
    sizes = [t.shape[1] for t in traces]
    for matrix, left, factor in ((contact.K_n, normal, 1.0), (contact.K_f, k, MU)):
        blocks = [[np.zeros((3 * m, 3 * n)) for n in sizes] for m in sizes]
        for i, weight in enumerate(interface.points.weight):
            direction = factor * weight * p * np.outer(left[i], normal[i])
            for s, t in np.ndindex(2, 2):
                sign = 1 if s == t else -1
                scalar = np.outer(traces[s][i], traces[t][i])
                if s == t:
                    scalar = np.diag(scalar.sum(axis=1))
                blocks[s][t] += sign * np.kron(scalar, direction)
        expected = np.block(blocks)
        assert np.abs(dense(matrix) - expected).max() <= 1e-13 * np.abs(expected).max()


def test_lumped_contact_conserves_linear_momentum_and_not_angular(backend):
    system = assemble(two_blocks(backend, LUMPED, mu=MU, P=P))
    rng = np.random.default_rng(3)
    x = unknowns(system, dict.fromkeys(system.bodies, lambda X: rng.normal(size=X.shape)))
    contact = system.contacts[0]
    constant = unknowns(system, dict.fromkeys(system.bodies, lambda X: np.ones(X.shape)))
    turn = np.array([[0, -0.3, 0.2], [0.3, 0, -0.7], [-0.2, 0.7, 0]])
    turned = unknowns(system, dict.fromkeys(system.bodies, lambda X: X @ turn.T))
    for matrix in (contact.K_n, contact.K_f):
        force = product(matrix, x)
        (total_a, scale), (total_b, _) = (resultant(system, force, b) for b in system.bodies)
        assert np.abs(total_a + total_b).max() <= 1e-13 * scale
        largest = np.abs(dense(matrix)).max()
        assert np.abs(gather(product(matrix, constant))).max() <= 1e-13 * largest
        assert np.abs(gather(product(matrix, turned))).max() > 1e-3 * largest


@pytest.mark.parametrize("points", [15, 25])
def test_lumped_nurbs_pass_the_patch_test_at_high_stiffness(points):
    formulation = f"contacts.interface.formulation={{method='gpts', points={points}, lumped=true}}"
    overrides = ["contacts.interface.P=1e14", formulation]
    sides = run_scene(load_scene(Path("patch_test"), overrides, "iga")).stresses["interface"]
    assert max(side.oscillation for side in sides.values()) < 1e-11 * 1000


def test_a_full_pass_is_the_mean_of_its_halves(backend):
    """The second half by itself: sides exchanged, direction of friction reversed."""
    data = two_blocks(backend, GPTS, mu=MU, P=P)
    data["contacts"]["interface"]["full_pass"] = True
    both = assemble(data)
    forward = assemble(two_blocks(backend, GPTS, mu=MU, P=P))
    data = two_blocks(backend, GPTS, mu=MU, P=P)
    contact = data["contacts"]["interface"]
    contact |= {"a": contact["b"], "b": contact["a"], "max_missed": 0.99}
    contact["friction_direction_on_a"] = {"vector": [-1.0, -0.5, 0.0]}
    backward = assemble(data)
    every = [system.pencil().at() for system in (forward, backward, both)]
    for part in ("stiffness", "unsymmetric"):
        *halves, found = (dense(getattr(matrices, part)) for matrices in every)
        mean = 0.5 * sum(halves)
        assert np.abs(found - mean).max() <= 1e-13 * np.abs(mean).max()


def bar(*parts, **joint):
    """A bar of 1 x 0.6 x 0.8, whole or split at half its height into meshes that do not match."""
    held = [{"surface": "z_min"}]
    if len(parts) == 1:
        bodies = {"bar": block(parts[0], [1.0, 0.6, 0.8], [0.0] * 3, [5, 4, 5], supports=held)}
        contacts = {}
    else:
        upper, lower = parts
        half = [1.0, 0.6, 0.4]
        bodies = {
            "upper": block(upper, half, [0.0, 0.0, 0.4], [5, 3, 2]),
            "lower": block(lower, half, [0.0, 0.0, 0.0], [4, 4, 3], supports=held),
        }
        bonded = {"a": "upper.z_min", "b": "lower.z_max", "formulation": {"method": "bonded"}}
        contacts = {"joint": bonded | joint}
    analysis = {"kind": "cea", "max_frequency": 0.7}
    return {"name": "bar", "bodies": bodies, "contacts": contacts, "analysis": analysis}


def frequencies(data):
    system = assemble(data)
    return solve_modes(system.pencil(), 0.7).frequencies


@pytest.mark.parametrize(("upper", "lower"), covering(["fe", "iga"], ["iga", "fe"], strength=1))
def test_a_bonded_joint_makes_one_body_of_two(upper, lower):
    joined = frequencies(bar(upper, lower, P=float("inf"), form="saddle"))
    whole = frequencies(bar(upper))
    assert len(whole) >= 8
    assert joined == pytest.approx(whole, rel=4e-3)


def test_a_bonded_joint_closes_no_gap_under_common_rigid_motion(backend):
    for placement in ({}, ROTATED):
        data = bar(backend, backend, P=3.0, form="penalty")
        for body in data["bodies"].values():
            body |= {"placement": placement, "supports": []}
        system = assemble(data)
        turn = np.array([[0, -0.3, 0.2], [0.3, 0, -0.7], [-0.2, 0.7, 0]])
        motion = dict.fromkeys(system.bodies, lambda X: X @ turn.T + [1.0, -2.0, 0.5])  # noqa: B023
        x = unknowns(system, motion)
        assert np.abs(gather(product(system.contacts[0].gap, x))).max() <= 1e-12
