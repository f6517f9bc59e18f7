"""Contact surfaces that turn a corner: what reaches over it is split by normal."""

import corners
import numpy as np
import pytest
from bodies import lagrange_body
from corners import KINDS, MATERIAL, block, rules, seat, system
from motions import dense, product, unknowns
from mpi import on_ranks

from cea.contact.formulations import Mortar, NodeToSurface
from cea.contact.laws import NormalCompliance
from cea.contact.sampling import sampling
from fe_cea.corners import smooth_pairs
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus

EVERY = [(kind, dim) for dim in KINDS for kind in KINDS[dim]]
OF = {"fe": "triangle", "iga": "nurbs"}
"""Bodies of each backend in the plane."""


def matrices(coupled):
    """K_n and K_f of all contacts together, dense."""
    normal, friction = zip(*((c.K_n, c.K_f) for c in coupled.contacts), strict=True)
    return [sum(map(dense, parts)) for parts in (normal, friction)]


@pytest.mark.parametrize(("kind", "dim"), EVERY)
@pytest.mark.parametrize("name", ["mortar", "segments"])
def test_rigid_block_in_a_corner_has_the_closed_form(kind, dim, name):
    coupled = system(kind, dim, rules(kind)[name])
    contact = coupled.contacts[0]
    motions = [unknowns(coupled, {"block": motion}) for motion in corners.rigid_motions(dim)]
    for matrix, true in zip((contact.K_n, contact.K_f), corners.rigid_stiffness(dim), strict=True):
        forces = [product(matrix, x) for x in motions]
        found = np.array([[x.dot(force) for force in forces] for x in motions])
        assert np.abs(found - true).max() <= 1e-12 * np.abs(true).max()


@pytest.mark.grid
@pytest.mark.parametrize(("kind", "dim"), EVERY)
@pytest.mark.parametrize("reverse", [False, True], ids=["block on seat", "seat on block"])
def test_one_contact_over_a_corner_is_one_for_each_face(kind, dim, reverse):
    for name, rule in rules(kind).items():
        one, several = (
            system(kind, dim, rule, together=together, reverse=reverse)
            for together in (True, False)
        )
        P = one.contacts[0].P
        assert sum(contact.P for contact in several.contacts) == pytest.approx(P, rel=1e-13)
        for found, expected in zip(matrices(one), matrices(several), strict=True):
            error = np.abs(found - expected).max() / np.abs(expected).max()
            assert error <= 1e-12, name


@pytest.mark.parametrize("p", [30.0, float("inf")])
def test_modes_of_one_contact_over_a_corner_are_those_of_two(backend, p):
    one, two = (
        corners.modes(OF[backend], Mortar(), 1.0, together=together, p=p)
        for together in (True, False)
    )
    assert len(one) > 6
    assert np.abs(one.real).max() > 1e-3
    assert one == pytest.approx(two, rel=1e-9)


@pytest.mark.parametrize("name", ["mortar", "segments"])
def test_a_law_of_the_gap_over_a_corner(backend, name):
    """Normal compliance, linearised about the same penetration of both faces."""
    kind = OF[backend]
    one, two = (
        matrices(
            system(
                kind,
                2,
                rules(kind)[name],
                together=together,
                p=NormalCompliance(c=30.0, m=2.0),
                penetration=0.1,
            )
        )
        for together in (True, False)
    )
    for found, expected in zip(one, two, strict=True):
        assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


def test_a_corner_of_which_parts_have_lifted_off(backend):
    """Open parts cut traces; another stiffness on each face."""

    def stiffness(x, normal):
        floor = normal[:, 1] < -0.5
        return np.where(floor, 3.0, 8.0) * (x.max(axis=1) < np.where(floor, 0.5, 0.8))

    one, two = (
        matrices(system(OF[backend], 2, Mortar(), together=together, p=stiffness))
        for together in (True, False)
    )
    for found, expected in zip(one, two, strict=True):
        assert np.abs(found - expected).max() <= 1e-10 * np.abs(expected).max()


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("ranks", "kind"),
    [(2, "nurbs"), (2, "triangle"), pytest.param(3, "triangle", marks=pytest.mark.slow)],
)
def test_numbers_of_a_corner_do_not_depend_on_the_ranks(ranks, kind):
    alone, together = (on_ranks(n, "corners.numbers", kind) for n in (1, ranks))
    assert len(alone) == 2
    for case, expected in alone.items():
        assert len(expected["frequencies"]) >= 4
        assert together[case]["rows"] == expected["rows"]
        for quantity in ("frequencies", "norms"):
            assert together[case][quantity] == pytest.approx(expected[quantity], rel=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_points_at_a_corner_have_normal_and_area_of_their_own_faces(backend, dim):
    kind = KINDS[dim][{"fe": 1, "iga": 0}[backend]]
    surface = seat(kind, dim, 3).surfaces["corner"]
    faces = seat(kind, dim, 3, together=False).surfaces
    weights = {"fe": "tributary", "iga": "area"}[backend]
    kind_of_points = surface.abscissa_kinds[0]
    for points_of in (
        lambda s: s.abscissae(kind_of_points),
        lambda s: s.abscissae(kind_of_points, weights),
        lambda s: s.grid(4),
    ):
        points = points_of(surface)
        at_tip = (np.abs(points.x) < 1e-12).all(axis=1)
        assert at_tip.sum() == dim
        assert np.sort(points.normal[at_tip], axis=0)[-1] == pytest.approx(np.ones(dim))
        for axis in range(dim):
            alone, here = points_of(faces[f"face {axis}"]), points.normal[:, axis] > 0.5
            assert here.sum() == len(alone)
            assert np.sort(points.weight[here]) == pytest.approx(np.sort(alone.weight), rel=1e-13)


@pytest.mark.parametrize("dim", [2, 3])
def test_split_traces_are_partitions_of_unity_on_each_face(backend, dim):
    kind = KINDS[dim][{"fe": 2, "iga": 0}[backend]]
    surface = block(kind, dim, 3).surfaces["corner"]
    points = surface.gauss_points(3)
    whole, split = (of(points.at).toarray() for of in (surface.trace, surface.split_trace))
    reached = [
        set(np.flatnonzero(np.abs(split[points.normal[:, axis] < -0.5]).max(axis=0) > 0))
        for axis in range(dim)
    ]
    assert split.sum(axis=1) == pytest.approx(np.ones(len(points)), abs=1e-14)
    for axis in range(1, dim):
        assert not reached[axis] & reached[axis - 1]
    assert sum(map(len, reached)) == (np.abs(split).max(axis=0) > 0).sum()
    assert (np.abs(whole).max(axis=0) > 0).sum() < (np.abs(split).max(axis=0) > 0).sum()


def test_a_rule_of_one_point_for_each_function_counts_as_many_over_a_corner(backend):
    kind = OF[backend]
    rule = NodeToSurface() if backend == "fe" else rules(kind)["Greville"]
    counts = sampling(system(kind, 2, rule).contacts[0].interface)
    assert counts.points == counts.functions_a


def facets_of(x):
    """Nodes and normals of straight facets from point to point."""
    along = np.diff(x, axis=0) / np.linalg.norm(np.diff(x, axis=0), axis=1, keepdims=True)
    normals = np.column_stack([along[:, 1], -along[:, 0]])
    number = np.arange(len(x) - 1)
    return np.column_stack([number, number + 1]), np.repeat(normals[:, None], 2, axis=1)


def corners_of(x):
    """Points of a polyline where it has a corner."""
    smooth = smooth_pairs(*facets_of(x), 1)
    return sorted(set(range(1, len(x) - 1)) - set(smooth[:, 1]))


def corners_round(x):
    """Points of a closed polyline where it has a corner."""
    dofs, normals = facets_of(np.vstack([x, x[:1]]))
    smooth = smooth_pairs(dofs % len(x), normals, 1)
    last = smooth[:, 1] - smooth[:, 0] > 1
    return sorted(set(range(len(x))) - set(np.where(last, 0, smooth[:, 1])))


def on_circle(degrees):
    """Points of the unit circle."""
    turn = np.deg2rad(degrees)
    return np.column_stack([np.cos(turn), np.sin(turn)])


def test_facets_of_any_lengths_on_a_circle_are_one_smooth_part():
    """All round: at the ends of an arc nothing tells what lies beyond."""
    rng = np.random.default_rng(4)
    for _ in range(50):
        shares = rng.uniform(1.0, 20.0, 30)
        assert corners_round(on_circle(360 * np.cumsum(shares) / shares.sum())) == []


@pytest.mark.parametrize("turn", [2.0, 20.0, 60.0, 90.0])
def test_straight_sides_have_a_corner_and_rounded_ones_none(turn):
    end = np.deg2rad(turn)
    side = np.linspace(1.0, 0.0, 4)[:, None] * [-1.0, 0.0]
    other = np.linspace(0.0, 1.0, 4)[1:, None] * [np.cos(end), np.sin(end)]
    assert corners_of(np.vstack([side, other])) == [3]
    arc = end * np.linspace(0.0, 1.0, 4)
    rounded = 0.2 * np.column_stack([np.sin(arc), 1 - np.cos(arc)])
    assert corners_of(np.vstack([side, rounded[1:], rounded[-1] + other])) == []


def test_a_square_of_one_facet_a_side_has_corners_and_an_octagon_none():
    for sides, expected in ((4, 4), (6, 6), (8, 0)):
        assert len(corners_round(on_circle(360 * np.arange(sides) / sides))) == expected


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_straight_facets_of_a_cylinder_are_one_smooth_part(cell):
    shape = Annulus(0.5, 1.0, 0.0, 0.6)
    mesh = shape_mesh(shape, cell, 1, breaks=breaks_of(shape, (1, 8, 2)))
    for surface in lagrange_body("part", mesh, degree=2, material=MATERIAL).surfaces.values():
        at = surface.gauss_points(2).at
        assert (surface.split_trace(at) != surface.trace(at)).nnz == 0


@pytest.mark.parametrize("order", [1, -1])
def test_points_at_a_corner_are_found_on_the_face_that_faces_them(order):
    """Both faces are met there: one squarely, one at its rim along the line."""
    parts = seat("nurbs", 2, 3).surfaces["corner"].faces
    surface = type(seat("nurbs", 2, 3).surfaces["corner"])("corner", parts[::order], 100)
    found = surface.locate(np.zeros((2, 2)), -np.eye(2), 0.5)
    assert surface.normal(found.at) == pytest.approx(np.eye(2), abs=1e-12)
