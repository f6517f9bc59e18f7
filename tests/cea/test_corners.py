"""Contact surfaces that turn a corner: what reaches over it is split by normal."""

import corners
import numpy as np
import pytest
from corners import KINDS, part, rules, system
from motions import dense, product, rigid_motions, unknowns
from mpi import on_ranks

from cea.contact.formulations import Mortar
from cea.contact.laws import NormalCompliance
from fe_cea.corners import smooth_pairs

EVERY = pytest.mark.parametrize(
    ("kind", "dim"), [(kind, dim) for dim in KINDS for kind in KINDS[dim]]
)
OF = {"fe": "triangle", "iga": "nurbs"}
"""Bodies of each backend in the plane."""


def assert_one_is_several(kind, dim, rule, within=1e-12, **options):
    """K_n and K_f of one contact over a corner are those of one contact for each face."""
    one, several = (
        system(kind, dim, rule, together=together, **options).contacts for together in (True, False)
    )
    assert sum(c.P for c in several) == pytest.approx(sum(c.P for c in one), rel=1e-13)
    for matrix in ("K_n", "K_f"):
        found, expected = (sum(dense(getattr(c, matrix)) for c in each) for each in (one, several))
        assert np.abs(found - expected).max() <= within * np.abs(expected).max(), rule


@EVERY
@pytest.mark.parametrize("name", ["mortar", "segments"])
def test_rigid_block_in_a_corner_has_the_closed_form(kind, dim, name):
    coupled = system(kind, dim, rules(kind)[name])
    contact = coupled.contacts[0]
    motions = [
        unknowns(coupled, {"block": lambda X, k=k: rigid_motions(X)[:, k]})
        for k in range(3 * (dim - 1))
    ]
    for matrix, true in zip((contact.K_n, contact.K_f), corners.rigid_stiffness(dim), strict=True):
        forces = [product(matrix, x) for x in motions]
        found = np.array([[x.dot(force) for force in forces] for x in motions])
        assert np.abs(found - true).max() <= 1e-12 * np.abs(true).max()


@pytest.mark.grid
@EVERY
@pytest.mark.parametrize("reverse", [False, True], ids=["block on seat", "seat on block"])
def test_one_contact_over_a_corner_is_one_for_each_face(kind, dim, reverse):
    for rule in rules(kind).values():
        assert_one_is_several(kind, dim, rule, reverse=reverse)


@pytest.mark.parametrize("name", ["mortar", "segments"])
def test_a_law_of_the_gap_over_a_corner(backend, name):
    """Normal compliance, linearised about the same penetration of both faces."""
    law = {"p": NormalCompliance(c=30.0, m=2.0), "penetration": 0.1}
    assert_one_is_several(OF[backend], 2, rules(OF[backend])[name], **law)


def test_a_corner_of_which_parts_have_lifted_off(backend):
    """Open parts cut traces; another stiffness on each face."""

    def stiffness(x, normal):
        floor = normal[:, 1] < -0.5
        return np.where(floor, 3.0, 8.0) * (x.max(axis=1) < np.where(floor, 0.5, 0.8))

    assert_one_is_several(OF[backend], 2, Mortar(), 1e-10, p=stiffness)


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
    surface = part("seat", kind, dim, 3).surfaces["corner"]
    faces = part("seat", kind, dim, 3, together=False).surfaces
    own, weights = surface.abscissa_kinds[0], {"fe": "tributary", "iga": "area"}[backend]
    for points_of in (
        lambda s: s.abscissae(own),
        lambda s: s.abscissae(own, weights),
        lambda s: s.grid(4),
    ):
        points = points_of(surface)
        at_tip = (np.abs(points.x) < 1e-12).all(axis=1)
        assert at_tip.sum() == dim
        assert np.sort(points.normal[at_tip], axis=0)[-1] == pytest.approx(np.ones(dim))
        for axis in range(dim):
            alone, here = points_of(faces[f"face {axis}"]), points.normal[:, axis] > 0.5
            assert np.sort(points.weight[here]) == pytest.approx(np.sort(alone.weight), rel=1e-13)


def corners_of(*pieces):
    """Points of a polyline of straight facets where it has a corner."""
    x = np.vstack(pieces)
    along = np.diff(x, axis=0) / np.linalg.norm(np.diff(x, axis=0), axis=1, keepdims=True)
    normals = np.column_stack([along[:, 1], -along[:, 0]])
    number = np.arange(len(along))
    nodes = np.column_stack([number, number + 1])
    smooth = smooth_pairs(nodes, np.repeat(normals[:, None], 2, axis=1), 1)
    return sorted(set(range(1, len(x) - 1)) - set(smooth[:, 1]))


@pytest.mark.parametrize("turn", [2.0, 20.0, 60.0, 90.0])
def test_straight_sides_have_a_corner_and_rounded_ones_none(turn):
    end = np.deg2rad(turn)
    side = np.linspace(1.0, 0.0, 4)[:, None] * [-1.0, 0.0]
    other = np.linspace(0.0, 1.0, 4)[1:, None] * [np.cos(end), np.sin(end)]
    assert corners_of(side, other) == [3]
    arc = end * np.linspace(0.0, 1.0, 4)
    rounded = 0.2 * np.column_stack([np.sin(arc), 1 - np.cos(arc)])
    assert corners_of(side, rounded[1:], rounded[-1] + other) == []


@pytest.mark.parametrize("order", [1, -1])
def test_points_at_a_corner_are_found_on_the_face_that_faces_them(order):
    """Both faces are met there: one squarely, one at its rim along the line."""
    corner = part("seat", "nurbs", 2, 3).surfaces["corner"]
    surface = type(corner)("corner", corner.faces[::order], 100)
    found = surface.locate(np.zeros((2, 2)), -np.eye(2), 0.5)
    assert surface.normal(found.at) == pytest.approx(np.eye(2), abs=1e-12)
