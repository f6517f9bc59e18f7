"""What supports bear: closed forms, changes of frame, Coulomb's law, bodies in equilibrium."""

import numpy as np
import pytest
from blocks import alone, scene_body
from mpi import on_ranks
from reaction_numbers import CONTACTS, INNER, MOVED, NU, OUTER, E, borne, pressed, sector

from cea.errors import ConvergenceError
from cea.supports.directions import Directions
from cea.supports.elimination import constrain
from cea.system import support_forces
from scenes import read_scene, run_scene

SIDES = ("x_min", "x_max", "y_min", "y_max")


def reactions_of(data):
    """What the supports of a scene bear, by body."""
    return run_scene(read_scene(data)).reactions


def column(backend, *, plain=False, nu=0.0, **body):
    """A column pressed on its foot by its top, between walls."""
    supports = [{"surface": s, "components": [s[0] if plain else "normal"]} for s in SIDES]
    supports.append({"surface": "z_max", "components": ["z"], "value": -8.2e-6})
    supports.append({"surface": "z_min", "components": ["normal"]})
    body |= {"material": {"E": 1e9, "nu": nu, "rho": 2000.0}, "supports": supports}
    geometry = {"shape": "box", "size": [0.01, 0.02, 0.04]}
    return alone(scene_body(backend, geometry, [1, 1, 4], **body), None)


@pytest.mark.parametrize("nu", [0.0, 0.3])
@pytest.mark.parametrize("plain", [True, False])
def test_walls_bear_nothing_along_a_column(backend, nu, plain):
    """Uniaxial strain: sigma_z = (lambda + 2 mu) e on the ends, lambda e on the walls."""
    lame = 1e9 * nu / (1 + nu) / (1 - 2 * nu), 1e9 / 2 / (1 + nu)
    strain = -8.2e-6 / 0.04
    along, across = (lame[0] + 2 * lame[1]) * strain, lame[0] * strain
    x, y, z = across * 0.02 * 0.04, across * 0.01 * 0.04, along * 0.01 * 0.02
    expected = [[-x, 0, 0], [x, 0, 0], [0, -y, 0], [0, y, 0], [0, 0, z], [0, 0, -z]]
    forces = reactions_of(column(backend, plain=plain, nu=nu))["part"]
    assert forces == pytest.approx(np.array(expected), abs=1e-12 * abs(z))


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
    dof = np.array([3, 3, 3, 5, 5, 5, 8, 8, 8, 8, 8])
    support = np.array([0, 1, 2, 0, 1, 1, 0, 0, 1, 2, 2])
    direction = rng.normal(size=(5, 3))[[0, 1, 2, 3, 3, 4, 0, 1, 1, 0, 2]]
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    constraints = constrain(10, Directions.of(dof, direction, support=support))
    r = np.zeros((10, 3))
    np.add.at(r, dof, rng.normal(size=(len(dof), 1)) * direction)
    assert list(constraints.dofs) == [3, 5, 8]
    parts = constraints.forces.split(r[constraints.dofs], 3)
    for i, each in enumerate(constraints.dofs):
        held = (direction[(dof == each) & (support == s)].T for s in range(3))
        spaces = [np.linalg.qr(each)[0] for each in held]
        amounts = np.linalg.lstsq(np.hstack(spaces), r[each], rcond=None)[0]
        cuts = np.cumsum([space.shape[1] for space in spaces])[:-1]
        for s, amount in enumerate(np.split(amounts, cuts)):
            assert parts[s, i] == pytest.approx(spaces[s] @ amount, abs=1e-12)


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
    data = column(backend, springs=[{"surface": "z_max", "stiffness": [0.0, 0.0, 1e9]}])
    supports, area, push = data["bodies"]["part"]["supports"], 0.01 * 0.02, 300.0
    del supports[4]
    data["loads"] = [{"surface": "part.z_max", "force": [0.0, 0.0, -push]}]
    forces = reactions_of(data)["part"]
    spring, rod = 1e9 * area, 1e9 * area / 0.04
    assert forces[-1, 2] == pytest.approx(push * rod / (rod + spring), rel=1e-10)
    del supports[4]
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
        forces = 1.0001 * first.forces
        yield support_forces.SideForces(first.contact, first.body, forces, first.size)
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
