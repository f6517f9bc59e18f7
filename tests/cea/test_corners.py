"""Contact surfaces that turn a corner: what reaches over it is split by normal."""

import corners
import numpy as np
import pytest
from corners import KINDS, MATERIAL, block, rules, seat, system
from motions import dense, product, unknowns

from cea.contact.formulations import Mortar, NodeToSurface
from cea.contact.sampling import sampling
from cea.corners import pairs_of_equal, smooth_groups, smooth_parts, split_functions
from cea.matrices import gather
from cea.supports.boundary import Pressure, Support
from fe_cea.body import FEBody
from iga_cea import NurbsBody
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Disc, Ring

EVERY = [(kind, dim) for dim in KINDS for kind in KINDS[dim]]
OF = {"fe": "triangle", "iga": "nurbs"}
"""Bodies of each backend in the plane."""


def matrices(coupled):
    """K_n and K_f of all contacts together, dense."""
    normal, friction = zip(*((c.stiffness, c.friction) for c in coupled.contacts), strict=True)
    return [sum(map(dense, parts)) for parts in (normal, friction)]


@pytest.mark.parametrize(("kind", "dim"), EVERY)
@pytest.mark.parametrize("name", ["mortar", "segments"])
def test_rigid_block_in_a_corner_has_the_closed_form(kind, dim, name):
    coupled = system(kind, dim, rules(kind)[name])
    contact = coupled.contacts[0]
    motions = [unknowns(coupled, {"block": motion}) for motion in corners.rigid_motions(dim)]
    for matrix, true in zip(
        (contact.stiffness, contact.friction), corners.rigid_stiffness(dim), strict=True
    ):
        forces = [product(matrix, x) for x in motions]
        found = np.array([[x.dot(force) for force in forces] for x in motions])
        assert np.abs(found - true).max() <= 1e-12 * np.abs(true).max()


@pytest.mark.parametrize(("kind", "dim"), EVERY)
@pytest.mark.parametrize("reverse", [False, True], ids=["block on seat", "seat on block"])
def test_one_contact_over_a_corner_is_one_for_each_face(kind, dim, reverse):
    for name, rule in rules(kind).items():
        one, several = (
            system(kind, dim, rule, together=together, reverse=reverse)
            for together in (True, False)
        )
        assert one.contacts[0].P == pytest.approx(sum(c.P for c in several.contacts), rel=1e-13)
        for found, expected in zip(matrices(one), matrices(several), strict=True):
            error = np.abs(found - expected).max() / np.abs(expected).max()
            assert error <= 1e-12, name


@pytest.mark.parametrize("p", [30.0, float("inf")])
def test_modes_of_one_contact_over_a_corner_are_those_of_two(backend, p):
    kind = OF[backend]
    one, two = (corners.modes(kind, Mortar(), together=together, p=p) for together in (True, False))
    assert len(one) > 6
    assert np.abs(one.real).max() > 1e-3
    assert one == pytest.approx(two, rel=1e-9)


@pytest.mark.parametrize(("kind", "dim"), EVERY)
@pytest.mark.parametrize("name", ["mortar", "segments"])
def test_different_uniform_pressures_on_two_faces_of_a_corner(kind, dim, name):
    """A block of uniform stress diag(-q_0, -q_1, 0) in a rigid seat: q_k on face k, exactly."""
    q = np.array([3e-3, 1e-3, 0.0])[:dim]
    held = [Support("corner")]
    loads = [Pressure(f"back {k}", float(q[k])) for k in range(2)]
    bodies = {
        "block": block(kind, dim, 3, pressures=loads),
        "seat": seat(kind, dim, 3, supports=held),
    }
    coupled = corners.coupled(bodies, rules(kind)[name], mu=0.0, with_load=True)
    K = dense(coupled.stiffness) + dense(coupled.contacts[0].stiffness)
    x = coupled.vector()
    x.array[:] = np.linalg.solve(K, gather(coupled.load))
    pressure = coupled.contacts[0].pressure(x)
    expected = -coupled.contacts[0].interface.points.normal @ q
    assert pressure == pytest.approx(expected, abs=1e-9 * q.max())


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


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
def test_straight_facets_of_a_circle_are_one_smooth_part(cell):
    """12 of them, from one to the next 30 degrees."""
    mesh = shape_mesh(Ring(0.5, 1.0), cell, 1, breaks=breaks_of(Ring(0.5, 1.0), (1, 12)))
    for surface in FEBody.from_mesh("ring", mesh, degree=2, material=MATERIAL).surfaces.values():
        nodes = surface.abscissae("nodes")
        assert len(nodes) == 24
        assert nodes.weight == pytest.approx(np.full(24, surface.area / 24), rel=1e-14)
        at = surface.gauss_points(2).at
        assert (surface.split_trace(at) != surface.trace(at)).nnz == 0


@pytest.mark.parametrize("shape", [Annulus(0.5, 1.0, 0.0, 0.3), Disc(1.0, 0.0, 0.2)])
def test_patches_that_join_smoothly_are_one_smooth_part(shape):
    data = nurbs_shape(shape, breaks_of(shape, (2, 8, 1)))
    part = NurbsBody("part", data.patches, data.faces, (2, 2, 2), material=MATERIAL)
    for surface in part.surfaces.values():
        at = surface.gauss_points(2).at
        assert (surface.split_trace(at) != surface.trace(at)).nnz == 0


def bent_seat(kink):
    """A seat of one patch: its contact surface turns the corner at a repeated knot."""
    inner = np.array([[0.0, 1.5], [0.0, 0.0], [1.5, 0.0]])
    outer = np.array([[-0.5, 1.5], [-0.5, -0.5], [1.5, -0.5]])
    knots = np.array([0.0, 0.0, kink, 1.0, 1.0])
    breaks = np.array([0.0, 0.5 * kink, kink, 0.6 + 0.4 * kink, 1.0])
    patch = NurbsPatch(
        (1, 1),
        (knots, np.array([0.0, 0.0, 1.0, 1.0])),
        np.stack([outer, inner], axis=1),
        np.ones((3, 2)),
        (breaks, np.array([0.0, 1.0])),
    )
    faces = {"corner": [(0, 1, 1)]}
    return NurbsBody("seat", [patch], faces, (2, 2), material=MATERIAL)


@pytest.mark.parametrize("kink", [0.5, 0.3])
def test_a_face_of_one_patch_is_split_at_its_kink(kink):
    """Rigid motions of the seat against a block that stands still, points on the seat."""
    bodies = {"seat": bent_seat(kink), "block": block("nurbs", 2, 3)}
    surface = bodies["seat"].surfaces["corner"]
    tip = surface.abscissae("greville")
    tip = tip[(np.abs(tip.x) < 1e-12).all(axis=1)]
    assert np.sort(tip.normal, axis=0) == pytest.approx(np.array([[0.0, 0.0], [1.0, 1.0]]))
    coupled = corners.coupled(bodies, Mortar(), a="seat", b="block")
    motions = [unknowns(coupled, {"seat": motion}) for motion in corners.rigid_motions(2)]
    forces = [product(coupled.contacts[0].stiffness, x) for x in motions]
    found = np.array([[x.dot(force) for force in forces] for x in motions])
    true = corners.rigid_stiffness(2)[0]
    assert np.abs(found - true).max() <= 1e-12 * np.abs(true).max()


@pytest.mark.parametrize("order", [1, -1])
def test_points_at_a_corner_are_found_on_the_face_that_faces_them(order):
    """Both faces are met there: one squarely, one at its rim along the line."""
    parts = seat("nurbs", 2, 3).surfaces["corner"].faces
    surface = type(seat("nurbs", 2, 3).surfaces["corner"])("corner", parts[::order], 100)
    found = surface.locate(np.zeros((2, 2)), -np.eye(2), 0.5)
    assert surface.normal(found.at) == pytest.approx(np.eye(2), abs=1e-12)


def test_a_cone_is_one_smooth_part_however_far_it_turns():
    """Normals of facets round its tip: each near the next, first and last far apart."""
    turn = np.linspace(0.0, 2.0, 9)
    normals = np.column_stack([np.cos(turn), np.sin(turn)])
    pairs = pairs_of_equal(np.zeros(9, dtype=int))
    assert len(pairs) == 36
    assert len(set(smooth_groups(pairs, normals, np.cos(0.3)))) == 1
    assert len(set(smooth_groups(pairs, normals, np.cos(0.2)))) == 9


def test_functions_are_split_where_a_crease_begins_and_whole_where_it_ends():
    """Two rows of two elements: the normal jumps between them in the first row alone."""
    dofs = np.array([0, 1, 3, 4, 1, 2, 4, 5, 3, 4, 6, 7, 4, 5, 7, 8])
    element = np.repeat(np.arange(4), 4)
    normals = np.tile([0.0, 1.0], (16, 1))
    normals[4:6] = [1.0, 0.0]  # the second element, at its nodes in the first row
    groups = smooth_groups(pairs_of_equal(dofs), normals, 0.9)
    functions = split_functions(dofs, groups, 9)
    assert sorted(set(functions)) == list(range(10))
    assert functions[1] != functions[4]
    assert {functions[1], functions[4]} == {1, 9}
    assert len(set(functions[dofs == 4])) == 1
    assert set(smooth_parts(element, functions, 4)) == {0}
