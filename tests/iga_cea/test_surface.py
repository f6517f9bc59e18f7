"""Surfaces of NURBS bodies: handedness, derivatives along the normal, edges and beyond them."""

import numpy as np
import pytest
from bodies import PLASTIC, nurbs_body, shape_body
from iga_data import TILTED, basis_on_grid

from cea.body import Body
from cea.surface_points import Status
from iga_cea.splines import grid_points
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Sector, Shape

INNER, OUTER, BOTTOM, TOP = 0.8, 1.7, -0.1, 0.2
ANNULUS = Annulus(INNER, OUTER, BOTTOM, TOP)
START, END = 20.0, 110.0
SECTOR = Sector(INNER, OUTER, START, END, BOTTOM, TOP)
BOX = Box((2.0, 1.0, 0.5), (0.1, 0.2, 0.3))
RNG = np.random.default_rng(11)


def body(shape: Shape, elements=(2, 8, 2), degree=(2, 3, 2), placement=TILTED) -> Body:
    return shape_body(shape, None, degree, elements, placement=placement)


@pytest.fixture(scope="module")
def ring() -> Body:
    return body(ANNULUS, placement=Placement())


def test_normals_point_outward_whatever_the_handedness() -> None:
    """A box whose first parameter runs backward."""
    patch = nurbs_shape(BOX, breaks_of(BOX, (2, 2, 2))).patches[0]
    mirrored = NurbsPatch(
        patch.degrees, patch.knots, patch.control_points[::-1], patch.weights, patch.breaks
    )
    faces = {"x_max": [(0, 0, 0)], "x_min": [(0, 0, 1)], "z_max": [(0, 2, 1)]}
    part = nurbs_body("part", [mirrored], faces, (2, 2, 2), material=PLASTIC)
    for name, surface in part.surfaces.items():
        points = surface.gauss_points(2)
        outward = np.eye(3)["xyz".index(name[0])] * (1 if name.endswith("max") else -1)
        np.testing.assert_allclose(points.normal, np.tile(outward, (len(points), 1)), atol=1e-14)
    assert (part.stiffness().getDiagonal().getArray() > 0).all()


def test_gradient_agrees_with_finite_differences_of_the_volume() -> None:
    """A rough field: its derivative along the normal needs the layer behind the face."""
    patch_body = body(SECTOR, (1, 2, 1), (2, 3, 2))
    (patch,) = patch_body.space.multipatch.patches
    field = RNG.random(patch_body.num_scalar_dofs)
    coefficients = field[patch_body.space.multipatch.dofs[0].ravel()]
    step = 1e-6
    for (name, surface), (axis, side) in zip(
        patch_body.surfaces.items(), [(a, s) for a in range(3) for s in (0, 1)], strict=True
    ):
        at = surface.gauss_points(1).at
        gradient = np.stack([g @ field for g in surface.gradient(at)], axis=1)
        for row, xi in enumerate(at.xi):
            inward = step if side == 0 else -step
            values, positions = [], []
            for k in (0, 1, 2):
                parameter = np.insert(xi, axis, side + k * inward)
                basis = basis_on_grid(patch, list(parameter[:, None]))
                values.append(basis @ coefficients)
                positions.append(basis @ patch.control_points.reshape(-1, 3))
            one_sided = np.array([-1.5, 2.0, -0.5])
            change = one_sided @ np.array(values)[:, 0]
            tangent = np.einsum("k,ki->i", one_sided, np.array(positions)[:, 0])
            assert gradient[row] @ tangent == pytest.approx(change, abs=1e-9), name


def test_location_of_edges_and_joints(ring: Body) -> None:
    angle = np.concatenate([np.linspace(0, 2 * np.pi, 33), [0, np.pi / 2, np.pi]])
    radius = np.concatenate([np.tile([INNER, OUTER], 17)[:33], [1.0, 1.1, 1.2]])
    x = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(36, TOP + 0.05)], 1)
    found = ring.surfaces["top"].locate(x, np.tile([0.0, 0.0, 1.0], (36, 1)), 0.1)
    assert (found.status == Status.EDGE).all()
    assert np.abs(found.distance + 0.05).max() < 1e-14


def test_faces_go_on_beyond_their_edges_whatever_their_outermost_spans_are():
    tiny = np.array([0.0, 1e-5, 1e-3, 0.1, 0.5, 0.9, 1 - 1e-3, 1 - 1e-5, 1.0])
    low, high = np.array([INNER, START, BOTTOM]), np.array([OUTER, END, TOP])
    fine = [a + (b - a) * tiny for a, b in zip(low, high, strict=True)]
    refined, plain = (
        nurbs_body("part", data.patches, data.faces, degree, material=PLASTIC).surfaces["top"]
        for data, degree in (
            (nurbs_shape(SECTOR, fine, TILTED), (5, 5, 5)),
            (nurbs_shape(SECTOR, breaks_of(SECTOR, (1, 1, 1)), TILTED), (2, 2, 2)),
        )
    )
    knots = refined.faces[0].knots
    ends = np.array([[k[0], k[-1]] for k in knots])
    parts = np.array([-0.5, -0.01, 0.3, 1.01, 1.5])
    xi = grid_points(tuple(a + (b - a) * parts for a, b in ends))
    element = np.zeros(len(xi), dtype=np.int64)
    for found, exact in zip(
        refined.tangents(element, xi), plain.tangents(element, xi), strict=True
    ):
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-12 * np.abs(exact).max())
