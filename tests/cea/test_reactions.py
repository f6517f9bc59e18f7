"""What supports bear: closed forms, changes of frame, Coulomb's law, bodies in equilibrium."""

import numpy as np
import pytest
from blocks import alone, scene_body
from mpi import on_ranks
from reaction_numbers import CONTACTS, INNER, MOVED, NU, OUTER, E, borne, pressed, sector
from scipy.sparse import csr_array

from cea.errors import ConvergenceError
from cea.supports.directions import Directions
from cea.supports.elimination import ProjectedConstraints, constrain
from cea.system import support_forces
from scenes import read_scene, run_scene

SIDES = ("x_min", "x_max", "y_min", "y_max")


def reactions_of(data):
    """What the supports of a scene bear, by body."""
    return run_scene(read_scene(data)).reactions


def column(backend, rollers, *, nu=0.0, **body):
    """A column pressed on its foot by its top, between walls."""
    supports = [{"surface": name, "components": rollers[name[0]]} for name in SIDES]
    supports.append({"surface": "z_max", "components": ["z"], "value": -8.2e-6})
    supports.append({"surface": "z_min", "components": ["normal"]})
    part = scene_body(
        backend,
        {"shape": "box", "size": [0.01, 0.02, 0.04]},
        [1, 1, 4],
        material={"E": 1e9, "nu": nu, "rho": 2000.0},
        supports=supports,
        **body,
    )
    return alone(part, None)


NORMAL = {"x": ["normal"], "y": ["normal"]}
PLAIN = {"x": ["x"], "y": ["y"]}


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_walls_bear_nothing_along_a_column(backend, nu):
    """Uniaxial strain: sigma_z = (lambda + 2 mu) e on the ends, lambda e on the walls."""
    forces = reactions_of(column(backend, NORMAL, nu=nu))["part"]
    lame = 1e9 * nu / (1 + nu) / (1 - 2 * nu), 1e9 / 2 / (1 + nu)
    strain = -8.2e-6 / 0.04
    along, across = (lame[0] + 2 * lame[1]) * strain, lame[0] * strain
    x, y, z = across * 0.02 * 0.04, across * 0.01 * 0.04, along * 0.01 * 0.02
    expected = [[-x, 0, 0], [x, 0, 0], [0, -y, 0], [0, y, 0], [0, 0, z], [0, 0, -z]]
    assert forces == pytest.approx(np.array(expected), abs=1e-12 * abs(z))
    assert reactions_of(column(backend, PLAIN, nu=nu))["part"] == pytest.approx(
        forces, abs=1e-12 * abs(z)
    )


@pytest.mark.parametrize(
    "sides", [("y", "x"), ("normal", "normal"), ("circumferential", "normal")], ids=" ".join
)
def test_a_sector_bears_what_lame_says(backend, sides):
    """Outer rim moved along the radius, inner one free: u_r = A r + B / r."""
    lame, shear = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
    A, B = np.linalg.solve(
        [[OUTER, 1 / OUTER], [2 * (lame + shear), -2 * shear / INNER**2]], [MOVED, 0.0]
    )
    pull = OUTER * (2 * (lame + shear) * A - 2 * shear * B / OUTER**2)
    expected = np.array([[pull, pull], [0.0, -pull], [-pull, 0.0]])
    forces = reactions_of(sector(backend, sides))["part"]
    assert forces == pytest.approx(expected, abs=1e-5 * pull)
    # No support bears anything across the directions that it holds.
    assert np.abs(forces[1:][expected[1:] == 0]).max() < 1e-13 * pull


def test_a_dof_is_shared_along_what_each_support_holds():
    """Against a dense least-norm solution: independent, equal, and partly shared directions."""
    rng = np.random.default_rng(2)
    d = rng.normal(size=(6, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    dof = np.array([3, 3, 3, 5, 5, 5, 8, 8, 8, 8, 8])
    support = np.array([0, 1, 2, 0, 1, 1, 0, 0, 1, 2, 2])
    direction = d[[0, 1, 2, 3, 3, 4, 0, 1, 1, 0, 2]]
    constraints = constrain(10, Directions.of(dof, direction, support=support))
    r = np.zeros((10, 3))
    np.add.at(r, dof, rng.normal(size=(len(dof), 1)) * direction)
    dofs = constraints.dofs
    parts = constraints.forces.split(r[dofs], 3)
    assert list(dofs) == [3, 5, 8]
    assert parts.sum(axis=0) == pytest.approx(r[dofs], abs=1e-13)
    for i, each in enumerate(dofs):
        spaces = []
        for s in range(3):
            own = direction[(dof == each) & (support == s)].T
            spaces.append(np.linalg.qr(own)[0])
            across = np.eye(3) - spaces[-1] @ spaces[-1].T
            assert np.abs(across @ parts[s, i]).max() < 1e-13
        amounts = np.linalg.lstsq(np.hstack(spaces), r[each], rcond=None)[0]
        cuts = np.cumsum([space.shape[1] for space in spaces])[:-1]
        for s, amount in enumerate(np.split(amounts, cuts)):
            assert parts[s, i] == pytest.approx(spaces[s] @ amount, abs=1e-12)


def test_projected_constraints_bear_the_forces_of_their_multipliers():
    """Held directions of one support beside rows of two others, of known multipliers."""
    rng = np.random.default_rng(3)
    n, d = 6, rng.normal(size=(4, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    held = Directions.of(np.array([1, 4]), d[:2])
    anchors = Directions.of(np.array([1, 2, 3]), d[[2, 3, 0]])
    shares = {}
    for support in (1, 2):
        rows = np.zeros((3, n, 3))
        for k, (dof, direction) in enumerate(zip(anchors.dof, anchors.direction, strict=True)):
            rows[k, [1, 2, 3]] = 0.1 * rng.random((3, 3))
            rows[k, dof] += 0.5 * direction
        shares[support] = csr_array(rows.reshape(3, -1))
    constraints = constrain(n, held, ProjectedConstraints(anchors, shares, np.zeros(3)))
    multipliers, amounts = rng.normal(size=3), rng.normal(size=2)
    expected = np.zeros((3, n, 3))
    expected[0][held.dof] = amounts[:, None] * held.direction
    for support, rows in shares.items():
        expected[support] = (rows.T @ multipliers).reshape(n, 3)
    dofs = constraints.dofs
    parts = constraints.forces.split(expected.sum(axis=0)[dofs], 3)
    assert parts == pytest.approx(expected[:, dofs], abs=1e-12)
    assert np.abs(np.delete(expected, dofs, axis=1)).max() == 0


@pytest.mark.grid
@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_supports_bear_what_contacts_of_every_kind_do(backend, contact, mu):
    """Action and reaction, Coulomb's law, walls that bear along their normals alone."""
    forces = reactions_of(pressed(backend, contact, mu=mu))
    wall, ceiling = forces["upper"]
    (ground,) = forces["lower"]
    size = np.abs(ground).max()
    assert ceiling[2] < -1e-4
    assert wall + ceiling + ground == pytest.approx(np.zeros(3), abs=1e-10 * size)
    assert np.abs([*wall[1:], ceiling[0]]).max() < 1e-13 * size
    if contact != "bonded":
        along = np.array([1.0, 0.5]) / np.sqrt(1.25)
        assert ground[:2] == pytest.approx(mu * ground[2] * along, abs=1e-10 * size)


def test_springs_and_loads_are_borne_too(backend):
    """A column on a foundation bears on nothing else; of a load the foot bears what is left."""
    data = column(backend, NORMAL, springs=[{"surface": "z_max", "stiffness": [0.0, 0.0, 1e9]}])
    del data["bodies"]["part"]["supports"][4]
    area, push = 0.01 * 0.02, 300.0
    data["loads"] = [{"surface": "part.z_max", "force": [0.0, 0.0, -push]}]
    forces = reactions_of(data)["part"]
    spring, rod = 1e9 * area, 1e9 * area / 0.04
    assert forces[-1, 2] == pytest.approx(push * rod / (rod + spring), rel=1e-10)
    del data["bodies"]["part"]["supports"][4]
    forces = reactions_of(data)["part"]
    assert np.abs(forces).max() < 1e-11 * push
    data["loads"].append({"body": "part", "body_force": [0.0, 5e6, 0.0]})
    forces = reactions_of(data)["part"].sum(axis=0)
    assert forces == pytest.approx([0.0, -5e6 * area * 0.04, 0.0], abs=1e-9 * push)


@pytest.mark.parametrize("contact", ["penalty", "tied", "mortar", "lumped", "law"])
def test_forces_that_do_not_balance_end_the_run(backend, contact, monkeypatch):
    """A contact whose friction or side is told wrong."""
    real = support_forces.forces_on_bodies

    def wrong(*arguments):
        first, *others = real(*arguments)
        yield support_forces.SideForces(
            first.contact, first.body, 1.0001 * first.forces, first.size
        )
        yield from others

    monkeypatch.setattr("cea.system.support_forces.forces_on_bodies", wrong)
    with pytest.raises(ConvergenceError, match="do not add up to zero") as raised:
        run_scene(read_scene(pressed(backend, contact)))
    assert set(raised.value.best) == {"upper", "lower"}


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_reactions_are_the_same_on_any_ranks(ranks):
    kinds = ("saddle", "full pass", "mortar, full pass", "bonded", "lumped", "law")
    expected, found = borne(*kinds), on_ranks(ranks, "reaction_numbers.borne", *kinds)
    assert found.keys() == expected.keys()
    for case, bodies in expected.items():
        for name, forces in bodies.items():
            size = np.abs(forces).max()
            assert found[case][name] == pytest.approx(np.array(forces), abs=1e-8 * size), case
