"""Displacements that supports prescribe, and what supports bear: exact fields, equilibrium."""

import numpy as np
import pytest
from blocks import GPTS, alone, coarse, scene_body, two_blocks
from covering import covering
from mpi import on_ranks
from pressed import pressed_blocks

from cea.errors import ConvergenceError, InputError
from cea.system import support_forces
from scenes import read_scene, run_scene

E, NU, MU = 2.0, 0.3, 0.3
STATIC = {"kind": "static", "samples": 5}
INNER, OUTER, MOVED = 0.5, 1.0, 1e-3
RULE = {"formulation": GPTS}
MORTAR = {"formulation": {"method": "mortar"}}
LAW = {"c_n": 10.0, "m_n": 1.5}
CONTACTS = {
    "penalty": RULE | {"form": "penalty"},
    "saddle": RULE | {"form": "saddle"},
    "full pass": RULE | {"form": "saddle", "full_pass": True},
    "tied": {"formulation": {"method": "segments"}, "P": float("inf")},
    "mortar": MORTAR,
    "mortar, full pass": MORTAR | {"full_pass": True},
    "mortar, tied": MORTAR | {"P": float("inf")},
    "bonded": {"formulation": {"method": "bonded"}},
    "lumped": {"formulation": GPTS | {"lumped": True}},
    "law": RULE | LAW,
    "law, mortar": MORTAR | LAW,
    "law, full pass": RULE | LAW | {"full_pass": True},
}
"""Contacts of every kind: their fields."""


def sector(backend, sides):
    """A quarter of a ring in plane strain whose outer rim is moved along the radius.

    Of its straight sides, start and end, a component each is held.
    """
    supports = [{"surface": "outer", "components": ["radial"], "value": MOVED}]
    supports += [
        {"surface": name, "components": [held]}
        for name, held in zip(("start", "end"), sides, strict=True)
    ]
    radii = {"inner_radius": INNER, "outer_radius": OUTER}
    shape = {"shape": "ring_sector", "start": 0.0, "end": 90.0, **radii}
    return alone(scene_body(backend, shape, [3, 6], 3, supports=supports), None)


def pressed(backend, contact):
    """A block pressed by its ceiling, beside walls whose edges lie in the contact, on another."""
    data = coarse(two_blocks(backend, {}, mu=MU, held=True), degree=2)
    wall = {"surface": "x_min", "components": ["normal"]}
    ceiling = {"surface": "z_max", "components": ["y", "z"], "value": [0.0, -1e-2]}
    data["bodies"]["upper"]["supports"] = [wall, ceiling]
    fields = data["contacts"]["interface"] | CONTACTS[contact]
    if "c_n" in fields:
        del fields["P"]
    if contact == "bonded":
        del fields["mu"], fields["friction_direction_on_a"]
    return data | {"contacts": {"interface": fields}, "analysis": STATIC}


def solved(data):
    return run_scene(read_scene(data))


def reactions_of(data):
    """What the supports of a scene bear, by body."""
    return solved(data).reactions


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


@pytest.mark.grid
@pytest.mark.parametrize("contact", CONTACTS)
def test_supports_bear_what_contacts_of_every_kind_do(backend, contact):
    """Action and reaction, Coulomb's law, walls that bear along their normals alone."""
    forces = reactions_of(pressed(backend, contact))
    wall, ceiling = forces["upper"]
    (ground,) = forces["lower"]
    size = np.abs(ground).max()
    assert ceiling[2] < -1e-4
    assert wall + ceiling + ground == pytest.approx(np.zeros(3), abs=1e-10 * size)
    assert np.abs([*wall[1:], ceiling[0]]).max() < 1e-13 * size
    if contact != "bonded":
        along = np.array([1.0, 0.5]) / np.sqrt(1.25)
        assert ground[:2] == pytest.approx(MU * ground[2] * along, abs=1e-10 * size)


def test_springs_and_loads_are_borne_too(backend):
    """A column on a foundation bears on nothing else; of a load the foot bears what is left."""
    area, height, push = 0.01 * 0.02, 0.04, 300.0
    names = ("x_min", "x_max", "y_min", "y_max", "z_min")
    supports = [{"surface": name, "components": ["normal"]} for name in names]
    body = scene_body(
        backend,
        {"shape": "box", "size": [0.01, 0.02, height]},
        [1, 1, 4],
        material={"E": 1e9, "nu": 0.0, "rho": 2000.0},
        supports=supports,
        springs=[{"surface": "z_max", "stiffness": [0.0, 0.0, 1e9]}],
    )
    loads = [{"surface": "part.z_max", "force": [0.0, 0.0, -push]}]
    data = alone(body, None) | {"loads": loads}
    forces = reactions_of(data)["part"]
    spring, rod = 1e9 * area, 1e9 * area / height
    assert forces[-1, 2] == pytest.approx(push * rod / (rod + spring), rel=1e-10)
    supports.pop()
    forces = reactions_of(data)["part"]
    assert np.abs(forces).max() < 1e-11 * push
    loads.append({"body": "part", "body_force": [0.0, 5e6, 0.0]})
    forces = reactions_of(data)["part"].sum(axis=0)
    assert forces == pytest.approx([0.0, -5e6 * area * height, 0.0], abs=1e-9 * push)


@pytest.mark.grid
@pytest.mark.parametrize("contact", ["penalty", "tied", "mortar", "lumped", "law"])
@pytest.mark.parametrize("at_supports", [False, True])
def test_forces_that_do_not_balance_end_the_run(backend, contact, at_supports, monkeypatch):
    """A contact whose friction or side is wrong, also where supports would take what is added."""
    real = support_forces.contact_forces

    def wrong(system, *others):
        forces, size = real(system, *others)
        upper = 1.0001 * forces["upper"]
        if at_supports:
            upper = forces["upper"].copy()
            body = system.bodies["upper"]
            dofs = body.constraints.dofs
            held = body.constraints.split(np.ones_like(upper[dofs]), len(body.supports))
            upper[dofs] += 1e-3 * np.abs(upper).max() * held.sum(axis=0)
        return forces | {"upper": upper}, size

    monkeypatch.setattr("cea.system.support_forces.contact_forces", wrong)
    told = "contact forces add up to" if at_supports else "N on upper"
    with pytest.raises(ConvergenceError, match=f"do not balance: .*{told}") as raised:
        run_scene(read_scene(pressed(backend, contact)))
    assert set(raised.value.best) == {"upper", "lower"}


def borne(backend, contacts):
    """What supports bear, by kind of contact; and of the sector."""
    made = {name: pressed(backend, name) for name in contacts}
    made["sector"] = sector(backend, ("normal", "circumferential"))
    found = {}
    for name, data in made.items():
        reactions = reactions_of(data)
        found[name] = {body: np.round(force, 15).tolist() for body, force in reactions.items()}
    return found


KINDS = ("saddle", "full pass", "mortar, full pass", "bonded", "lumped", "law")


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("ranks", "backend", "contacts"),
    [
        *((2, "fe", KINDS[1:2]), (2, "iga", KINDS[2:3])),
        *(pytest.param(2, backend, KINDS, marks=pytest.mark.slow) for backend in ("fe", "iga")),
        *(pytest.param(3, backend, KINDS, marks=pytest.mark.slow) for backend in ("fe", "iga")),
    ],
)
def test_reactions_are_the_same_on_any_ranks(ranks, backend, contacts):
    expected, found = borne(backend, contacts), on_ranks(ranks, borne, backend, contacts)
    assert found.keys() == expected.keys()
    for case, bodies in expected.items():
        for name, forces in bodies.items():
            size = np.abs(forces).max()
            assert found[case][name] == pytest.approx(np.array(forces), abs=1e-8 * size), case


STRETCH = 1e-3
SIZE = (1.0, 0.8, 0.5)
CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}


def box(backend, *others, dim=3, degree=2, divided=False):
    """A static box stretched along x, free to shrink across, with its corner at the origin."""
    supports = [{"surface": f"{axis}_min", "components": [axis]} for axis in "xyz"[:dim]]
    supports += [{"surface": "x_max", "components": ["x"], "value": STRETCH}, *others]
    body = {"supports": supports, "material": {"E": E, "nu": NU, "rho": 1.0}}
    geometry = {"shape": "box" if dim == 3 else "rectangle", "size": list(SIZE[:dim])}
    section = scene_body(backend, geometry, [3, 2, 2][:dim], degree, **body)
    section["mesh"]["fe"]["cell"] = CELLS[dim][divided]
    return alone(section, None)


@pytest.mark.parametrize(
    ("cells", "dim", "degree"),
    covering([("fe", False), ("fe", True), ("iga", False)], [2, 3], [1, 3]),
)
def test_a_stretched_box_is_exact(cells, dim, degree):
    """Of elements that are boxes, or divided into triangles or tetrahedra; splines have boxes."""
    backend, divided = cells
    result = solved(box(backend, dim=dim, degree=degree, divided=divided))
    sample = result.bodies["part"].space.volume_cells().straight()
    across = -NU if dim == 3 else -NU / (1 - NU)
    expected = STRETCH * np.array([1.0, across, across])[:dim] * sample.points
    found = result.displacements("part", sample.values)
    assert found == pytest.approx(expected, abs=1e-13 * STRETCH)
    modulus = E if dim == 3 else E / (1 - NU**2)
    force = modulus * STRETCH * np.prod(SIZE[1:dim])
    reactions = result.reactions["part"]
    assert reactions[[0, -1], 0] == pytest.approx([-force, force], rel=1e-12)
    assert np.abs(reactions.sum(axis=0)).max() <= 1e-12 * force


@pytest.mark.grid
@pytest.mark.parametrize("form", ["penalty", "saddle"])
def test_supports_that_reach_a_contact_close_it(backend, form):
    """Moving the walls of one block by as much as the ground of the other changes no force."""
    pressures, reactions = [], []
    for mover, value in (("upper", -1e-3), ("lower", 1e-3)):
        data = coarse(two_blocks(backend, GPTS, mu=0.2, held=True, form=form), degree=2)
        data["analysis"] = STATIC
        moved = {"value": value} if mover == "upper" else {}
        data["bodies"]["upper"]["supports"] = [
            {"surface": "y_min", "components": ["x", "y"]},
            {"surface": "x_min", "components": ["x"]},
            {"surface": "x_min", "components": ["z"]} | moved,
            {"surface": "z_max", "components": ["z"]} | moved,
        ]
        if mover == "lower":
            data["bodies"]["lower"]["supports"][0]["value"] = [0.0, 0.0, value]
        result = solved(data)
        pressures.append(result.stresses["interface"]["a"].sigma_n)
        reactions.append(result.reactions)
        for name, sign in (("upper", -1), ("lower", 1)):
            assert sign * result.reactions[name].sum(axis=0)[2] > 1e-5
    for one, other in (pressures, *([r[name] for r in reactions] for name in ("upper", "lower"))):
        assert other == pytest.approx(one, abs=1e-10 * np.abs(one).max())


def test_small_motions_are_held_at_zero(backend):
    """Where all of a contact is closed and m_n = 1, how it was closed changes no mode."""
    modes = []
    for value in (-1e-3, -2e-3):
        data = coarse(pressed_blocks(backend, GPTS, c_n=10.0, mu=0.1)) | {"loads": []}
        data["bodies"]["upper"]["supports"] = [{"surface": "z_max", "value": [0.0, 0.0, value]}]
        data["analysis"]["max_frequency"] = 1.0
        result = solved(data)
        assert result.steady.contacts["interface"].closed_fraction == 1.0
        modes.append(result.eigenvalues)
    assert len(modes[0])
    assert modes[1] == pytest.approx(modes[0], rel=1e-10)


def test_values_that_contradict_each_other_are_refused(backend):
    with pytest.raises(InputError, match=r"supports\.value"):
        solved(box(backend, {"surface": "y_max", "components": ["x"], "value": 0.0}))


UNFIT = [
    {"formulation": {"method": "mortar"}},
    {"formulation": GPTS, "form": "saddle", "P": float("inf")},
    {"formulation": GPTS | {"lumped": True}},
]


@pytest.mark.grid
@pytest.mark.parametrize("contact", UNFIT, ids=str)
def test_contacts_that_know_no_forces_at_points_refuse_values_that_reach_them(backend, contact):
    data = coarse(two_blocks(backend, mu=0.0, held=True, **contact)) | {"analysis": STATIC}
    supports = data["bodies"]["upper"]["supports"]
    supports[0]["value"] = [0.0, 0.0, -1e-3]
    solved(data)
    supports.append({"surface": "x_min", "components": ["z"], "value": -1e-3})
    with pytest.raises(InputError, match=r"contacts\.interface"):
        solved(data)
