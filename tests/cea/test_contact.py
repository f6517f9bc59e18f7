"""Contact matrices on both backends: forces, conservation, sums over points, halves, joints."""

from pathlib import Path

import numpy as np
import pytest
from blocks import FORMULATIONS, PLACEMENTS, assemble, block, coarse, two_blocks
from covering import covering
from motions import asymmetry, control_points, resultant, unknowns
from petsc_matrices import gather, to_numpy
from scipy.linalg import block_diag

from cea.eigen.driver import solve_modes
from cea.errors import InputError
from scenes import run_scene
from scenes.spec.reading import load_scene

P, MU, CLOSURE, AREA = 3.0, 0.4, 1e-6, 0.3
GPTS = {"method": "gpts", "points": 4}
LUMPED = GPTS | {"lumped": True}
EVERY = pytest.mark.parametrize(
    ("backend", "formulation", "placement", "full_pass"),
    covering(["fe", "iga"], FORMULATIONS, PLACEMENTS, [False, True]),
    indirect=["backend", "formulation", "placement"],
)
"""Each formulation on each backend, placed either way, from one side or from both."""
SYSTEMS = {}


def blocks(*arguments, **options):
    """Two coarse blocks of degree two."""
    return coarse(two_blocks(*arguments, **options), degree=2)


@pytest.fixture
def system(backend, formulation, placement, full_pass):
    """One for each case: the tests leave it as it is."""
    case = backend, str(formulation), str(placement), full_pass
    if case not in SYSTEMS:
        options = {"mu": MU, "P": P, "full_pass": full_pass}
        SYSTEMS[case] = assemble(blocks(backend, formulation, placement, **options))
    return SYSTEMS[case]


def direction(system):
    """Direction k on the upper block, from the outward normals of the lower one."""
    x_max, z_max = (system.bodies["lower"].surfaces[name] for name in ("x_max", "z_max"))
    e1, e3 = (surface.gauss_points(1).normal[0] for surface in (x_max, z_max))
    return (2 * e1 + np.cross(e3, e1)) / np.sqrt(5)


@EVERY
def test_friction_pushes_a_along_k_and_b_against_it(system):
    halves, k = system.contacts, direction(system)
    normal = halves[0].interface.points.normal[0]
    assert halves[0].interface.points.weight.sum() == pytest.approx(AREA, rel=1e-11)
    x = unknowns(system, {"upper": lambda X: CLOSURE * np.ones((len(X), 1)) * normal})
    force = P * CLOSURE / len(halves)
    for contact, side in zip(halves, (1, -1), strict=False):
        points = contact.interface.points
        assert points.normal == pytest.approx(np.tile(side * normal, (len(points), 1)), abs=1e-12)
        assert contact.pressure(x) == pytest.approx(force / points.weight.sum(), rel=1e-11)
        for body, sign in (("upper", 1), ("lower", -1)):
            friction, scale = resultant(system, contact.K_f @ x, body)
            assert friction == pytest.approx(sign * MU * force * k, abs=1e-13 * scale)
            pressure, scale = resultant(system, contact.K_n @ x, body)
            assert -pressure == pytest.approx(-sign * force * normal, abs=1e-13 * scale)


TURN = np.array([[0, -0.3, 0.2], [0.3, 0, -0.7], [-0.2, 0.7, 0]])


def common(system, motion):
    """Unknowns of bodies that all move as one function of position says."""
    return unknowns(system, dict.fromkeys(system.bodies, motion))


def assert_conserves_momentum(system, *, angular):
    rng = np.random.default_rng(3)
    x = common(system, lambda X: rng.normal(size=X.shape))
    rigid = common(system, lambda X: X @ TURN.T + [1.0, -2.0, 0.5])
    shift = common(system, lambda X: np.ones(X.shape))
    for contact in system.contacts:
        assert asymmetry(contact.K_n) == 0.0 or not angular
        assert asymmetry(contact.K_f) > 0.1 * contact.K_f.norm()
        for matrix in (contact.K_n, contact.K_f):
            forces = [
                (control_points(body), system.displacement(matrix @ x, name).reshape(-1, 3))
                for name, body in system.bodies.items()
            ]
            scale = np.abs(forces[0][1]).sum()
            assert np.abs(sum(f.sum(axis=0) for _, f in forces)).max() <= 1e-13 * scale
            largest = np.abs(to_numpy(matrix)).max()
            assert np.abs(gather(matrix @ shift)).max() <= 1e-13 * largest
            if angular:
                moment = sum(np.cross(x, f).sum(axis=0) for x, f in forces)
                assert np.abs(moment).max() <= 1e-12 * scale
                assert np.abs(gather(contact.gap @ rigid)).max() <= 1e-12
            else:
                assert np.abs(gather(matrix @ rigid)).max() > 1e-3 * largest


@EVERY
def test_momentum_is_conserved_and_common_rigid_motions_close_no_gap(system):
    assert_conserves_momentum(system, angular=True)


def test_lumped_contact_conserves_linear_momentum_and_not_angular(backend):
    assert_conserves_momentum(assemble(blocks(backend, LUMPED)), angular=False)


def assert_equals_sums(contact, k, *, lumped=False):
    """K_n and K_f are sums over points of outer products of gaps and slips, from the traces.

    Paper eq. 41: in a-a and b-b of lumped ones scalar row i is summed over scalar columns onto i.
    """
    interface = contact.interface
    normal, weight = interface.points.normal, interface.points.weight
    p = contact.P / weight.sum()
    traces = [interface.trace_a.toarray(), -interface.trace_b.toarray()]
    traces = traces if contact.a == "upper" else traces[::-1]
    gap, slip = (
        np.hstack([np.einsum("qi,qc->qic", trace, along).reshape(len(k), -1) for trace in traces])
        for along in (normal, MU * k)
    )
    left = [gap.T * weight, slip.T * weight]
    tolerance = 1e-13
    if contact.is_projected:
        psi = interface.trace_a.toarray()
        psi = psi[:, np.abs(psi).max(axis=0) > 0]
        projected = psi @ np.linalg.solve((psi.T * weight / p) @ psi, psi.T * weight)
        expected = [factor @ projected @ gap for factor in left]
        tolerance = 1e-11  # times the condition of the mass matrix of the traces
    else:
        expected = [p * factor @ gap for factor in left]
    for matrix, along in zip(expected, (normal, MU * k), strict=True):
        first = 0
        for trace in traces if lumped else ():
            size = 3 * trace.shape[1]
            share = p * weight * trace.sum(axis=1)
            own = slice(first, first + size)
            nodes = np.einsum("q,qi,qc,qd->icd", share, trace, along, normal)
            matrix[own, own] = block_diag(*nodes)
            first += size
    for matrix, reference in zip((contact.K_n, contact.K_f), expected, strict=True):
        assert np.abs(to_numpy(matrix) - reference).max() <= tolerance * np.abs(reference).max()


@EVERY
def test_matrices_are_sums_over_points(system):
    for contact, side in zip(system.contacts, (1, -1), strict=False):
        count = len(contact.interface.points)
        assert_equals_sums(contact, np.tile(side * direction(system), (count, 1)))


@pytest.mark.grid
def test_lumped_matrices_are_sums_over_columns(backend, placement):
    (contact,) = assemble(blocks(backend, LUMPED, placement)).contacts
    points = contact.interface.points
    k = contact.friction.along(points.x, points.normal)
    assert_equals_sums(contact, k, lumped=True)


def test_lumped_nurbs_pass_the_patch_test_at_high_stiffness():
    formulation = "contacts.interface.formulation={method='gpts', points=25, lumped=true}"
    overrides = ["contacts.interface.P=1e14", formulation]
    sides = run_scene(load_scene(Path("patch_test"), overrides, "iga")).stresses["interface"]
    assert max(side.oscillation for side in sides.values()) < 1e-11 * 1000


def bar(*parts, **joint):
    """A bar of 1 x 0.6 x 0.8, whole or split at half its height into meshes that do not match."""
    held = [{"surface": "z_min"}]
    data = {"name": "bar", "contacts": {}, "analysis": {"kind": "cea", "max_frequency": 0.7}}
    if len(parts) == 1:
        whole = block(parts[0], [1.0, 0.6, 0.8], [0.0] * 3, [5, 4, 5], supports=held)
        return data | {"bodies": {"bar": whole}}
    upper, lower = parts
    half = [1.0, 0.6, 0.4]
    bonded = {"a": "upper.z_min", "b": "lower.z_max", "formulation": {"method": "bonded"}}
    bodies = {
        "upper": block(upper, half, [0.0, 0.0, 0.4], [5, 3, 2]),
        "lower": block(lower, half, [0.0, 0.0, 0.0], [4, 4, 3], supports=held),
    }
    return data | {"bodies": bodies, "contacts": {"joint": bonded | joint}}


@pytest.mark.grid
@pytest.mark.parametrize("lower", ["iga", "fe"])
def test_a_bonded_joint_makes_one_body_of_two(backend, lower):
    joined, whole = (
        solve_modes(assemble(data).pencil(), 0.7).frequencies
        for data in (bar(backend, lower, P=float("inf"), form="saddle"), bar(backend))
    )
    assert len(whole) >= 8
    assert joined == pytest.approx(whole, rel=4e-3)


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
