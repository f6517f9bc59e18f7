"""Matrices of NURBS bodies against slow loops: every degree, joint and map; sums of products."""

import numpy as np
import pytest
from bodies import nurbs_body
from iga_data import STEEL, TILTED, TURNED, body, slow_matrices, slow_points, turned
from petsc_matrices import to_scipy

from cea.body import Body
from cea.motion import Rotation
from iga_cea.patch import refine
from iga_cea.separation import holds, separate
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.shapes import Box, Disc, RingSector, Sector

SECTOR = Sector(0.8, 1.7, 20.0, 85.0, -0.1, 0.2)
RING_SECTOR = RingSector(0.8, 1.7, 20.0, 85.0)


def distorted(shape, elements, *, weights: bool) -> NurbsPatch:
    """Patch of a shape with its control points moved, and its weights changed if wanted."""
    placement = TILTED if len(elements) == 3 else TURNED
    (whole,) = nurbs_shape(shape, breaks_of(shape, elements), placement).patches
    fine = refine(whole, whole.degrees, [p - 1 for p in whole.degrees])
    rng = np.random.default_rng(3)
    moved = fine.control_points + 0.02 * rng.uniform(-1, 1, fine.control_points.shape)
    factors = 1 + 0.2 * rng.uniform(-1, 1, fine.weights.shape) if weights else 1.0
    return NurbsPatch(fine.degrees, fine.knots, moved, fine.weights * factors, whole.breaks)


def distorted_body(shape, elements, degree, *, weights: bool, **options) -> Body:
    patch = distorted(shape, elements, weights=weights)
    return nurbs_body("part", [patch], {}, degree, material=STEEL, **options)


def assert_agrees_with_slow_loops(part: Body) -> None:
    for ours, slow in zip((part.stiffness(), part.mass()), slow_matrices(part), strict=True):
        A = to_scipy(ours)
        assert np.abs(A.toarray() - slow).max() <= 1e-13 * np.abs(slow).max()
        assert abs(A - A.T).max() == 0


@pytest.mark.parametrize("q", [2, 3, 4, 5, 6, 8])
def test_every_degree_in_the_plane(q: int) -> None:
    """Continuity 0 along one parameter, the highest along the other."""
    assert_agrees_with_slow_loops(body(RING_SECTOR, (2, 3), (q - 1, q), continuity=(0, q - 1)))


@pytest.mark.parametrize("q", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("axis", range(3))
def test_every_degree_in_space(axis: int, q: int) -> None:
    degree = [1, 1, 1]
    degree[axis] = q
    continuity = [0, 0, 0]
    continuity[axis] = q // 2
    elements = [1, 1, 1]
    elements[axis] = 3
    assert_agrees_with_slow_loops(
        body(Box((2.0, 1.0, 0.5)), elements, degree, continuity=continuity)
    )


@pytest.mark.parametrize(("axes", "flip"), [((1, 2, 0), 0), ((2, 1, 0), 2), ((0, 2, 1), 1)])
def test_odd_orientations_in_space(axes: tuple[int, ...], flip: int) -> None:
    halves = [
        nurbs_shape(
            Sector(0.8, 1.7, a, b, -0.1, 0.2),
            (np.array([0.8, 1.1, 1.7]), np.array([a, b]), np.array([-0.1, 0.2])),
            TILTED,
        ).patches[0]
        for a, b in ((10.0, 40.0), (40.0, 95.0))
    ]
    patches = [halves[0], turned(halves[1], axes, flip)]
    part = nurbs_body("part", patches, {}, (2, 2, 2), material=STEEL)
    assert part.num_scalar_dofs == 4 * 5 * 3
    assert_agrees_with_slow_loops(part)


@pytest.mark.parametrize("elements", [(1, 4, 1), (2, 8, 2)])
def test_collapsed_edges(elements: tuple[int, ...]) -> None:
    """Elements at the axis of a disc have several functions of one dof."""
    assert_agrees_with_slow_loops(body(Disc(1.2, -0.1, 0.2), elements, (2, 2, 1)))


@pytest.mark.parametrize("weights", [False, True])
@pytest.mark.parametrize(
    "degree", [(1, 2, 1), (2, 2, 2), (1, 3, 2), (1, 4, 1), (5, 2, 1), (1, 2, 6)]
)
def test_distorted_maps_in_space(degree: tuple[int, ...], weights: bool) -> None:
    assert_agrees_with_slow_loops(distorted_body(SECTOR, (2, 2, 1), degree, weights=weights))


@pytest.mark.parametrize("weights", [False, True])
@pytest.mark.parametrize("continuity", [None, (0, 1), (2, 0)])
def test_distorted_maps_in_the_plane(continuity, weights: bool) -> None:
    """More spans than a window has, so that windows move."""
    part = distorted_body(RING_SECTOR, (6, 5), (3, 3), weights=weights, continuity=continuity)
    assert_agrees_with_slow_loops(part)


def test_a_bulge_between_the_samples_is_seen() -> None:
    """One control point of a box moved, where the points tried first do not feel it."""
    (whole,) = nurbs_shape(
        Box((1.0, 12.0, 1.0)), breaks_of(Box((1.0, 12.0, 1.0)), (3, 12, 1))
    ).patches
    fine = refine(whole, (1, 1, 1), (0, 0, 0))
    moved = fine.control_points.copy()
    moved[1, 4, 0] += 0.1
    patch = NurbsPatch(fine.degrees, fine.knots, moved, fine.weights, whole.breaks)
    part = nurbs_body("part", [patch], {}, (2, 1, 1), material=STEEL)
    assert_agrees_with_slow_loops(part)


def test_sums_of_products_are_found_and_others_refused() -> None:
    """Rank 3 of 40 points is found to rounding; a difference at one point is not overlooked."""
    q, x = np.linspace(0, 1, 40), np.linspace(0, 2, 11)
    c = sum(np.multiply.outer(q**k, np.cos(k * x)) for k in range(3)) + 2.0
    every = {(1, 1): c[None, :, :, None]}
    few = {pair: values[:, :, ::2] for pair, values in every.items()}
    found = separate(few, most=5)
    assert found is not None
    assert len(found[0, 0].rows) == 3

    def skeleton(pair):
        return every[pair][:, found[0, 0].rows]

    assert holds(found, skeleton, iter([(slice(0, 40), every)]), 1)
    other = {(1, 1): every[1, 1].copy()}
    other[1, 1][0, 7, 3, 0] *= 1 + 1e-12
    assert not holds(found, skeleton, iter([(slice(0, 40), other)]), 1)
    assert separate(few, most=2) is None


@pytest.mark.parametrize("coriolis", [True, False])
@pytest.mark.parametrize("shape", ["disc", "distorted"])
def test_matrices_of_rotation(shape: str, coriolis: bool) -> None:
    """Y and Z against slow loops, where weights are a product and where not, and at an axis."""
    part = (
        body(Disc(1.2, -0.1, 0.2), (1, 4, 1), (2, 2, 1))
        if shape == "disc"
        else distorted_body(SECTOR, (2, 2, 1), (2, 2, 1), weights=True)
    )
    rotation = Rotation(1.0, (0.2, -0.5, 1.0), (0.3, 0.1, -0.2), coriolis=coriolis)
    spin, n = rotation.spin(3), part.num_scalar_dofs
    m, A, B = np.zeros((3, n, n))
    for dof, R, grad, dV, x in slow_points(part):
        t = (spin @ (x - rotation.origin)) @ grad
        dV *= STEEL.rho
        at = np.ix_(dof, dof)
        np.add.at(m, at, dV * np.outer(R, R))
        np.add.at(A, at, dV * (np.outer(R, t) - np.outer(t, R)))
        np.add.at(B, at, dV * np.outer(t, t))
    Y, Z = np.kron(A, np.eye(3)), np.kron(B, np.eye(3))
    if not coriolis:
        Y -= 2 * np.kron(m, spin)
        Z += np.kron(A, spin) + np.kron(m, spin.T @ spin)
    for ours, slow in ((part.gyroscopic(rotation), Y), (part.convective_stiffness(rotation), Z)):
        assert np.abs(to_scipy(ours).toarray() - slow).max() <= 1e-13 * np.abs(slow).max()


@pytest.mark.parametrize("weights", [False, True])
def test_geometric_stiffness(weights: bool) -> None:
    part = distorted_body(SECTOR, (2, 2, 1), (2, 2, 1), weights=weights)
    u = np.random.default_rng(5).uniform(-1, 1, (part.num_scalar_dofs, 3))
    slow = np.zeros((part.num_scalar_dofs,) * 2)
    lam, mu = STEEL.lame
    for dof, _, grad, dV, _ in slow_points(part):
        slope = u[dof].T @ grad.T
        stress = lam * np.trace(slope) * np.eye(3) + mu * (slope + slope.T)
        np.add.at(slow, np.ix_(dof, dof), dV * grad.T @ stress @ grad)
    ours = to_scipy(part.geometric_stiffness(u.ravel())).toarray()
    slow = np.kron(slow, np.eye(3))
    assert np.abs(ours - slow).max() <= 1e-13 * np.abs(slow).max()
