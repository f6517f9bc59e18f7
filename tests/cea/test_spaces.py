"""What every backend must hold: matrices, supports, loads, surfaces of a `cea.body.Space`.

The stub of tests/helpers/stub_backend.py shows how little a new backend has to implement; it takes
part in all but rotations and prestress.
"""

import numpy as np
import pytest
from bodies import PLASTIC as MATERIAL
from bodies import shape_body
from motions import rigid_motions
from mpi import on_ranks
from petsc_matrices import to_numpy
from stub_backend import StubSpace

from cea.body import Body
from cea.errors import InputError
from cea.matrices import gather
from cea.motion import Rotation
from cea.petsc import MPI
from cea.supports.boundary import Force, Pressure, Spring, Support
from cea.surface_points import Status, SurfaceCoordinates
from meshes.shapes import Annulus, Box, Rectangle, Ring

BOX, PLATE, RING, ANNULUS = (
    Box((1.0, 0.8, 0.5)),
    Rectangle((1.0, 0.8)),
    Ring(0.5, 1.0),
    Annulus(0.5, 1.0, 0.0, 0.3),
)
FLAT = {
    "P2": (BOX, "tetrahedron", 2, 0.5),
    "Q1": (BOX, "hexahedron", 1, (2, 2, 1)),
    "Q3 plane": (PLATE, "quadrilateral", 3, (2, 2)),
    "NURBS 2": (BOX, None, 2, (2, 2, 1)),
    "NURBS 3 plane": (PLATE, None, 3, (3, 2)),
    "stub": (PLATE, "stub", 1, (3, 2)),
}
ROUND = {
    "P2": (ANNULUS, "tetrahedron", 2, 0.4),
    "Q2": (ANNULUS, "hexahedron", 2, (1, 12, 1)),
    "P3 plane": (RING, "triangle", 3, 0.4),
    "NURBS 2": (ANNULUS, None, 2, (1, 8, 1)),
    "NURBS 3 plane": (RING, None, 3, (1, 8)),
}
TOP = {"box": ("z_min", "z_max"), "plate": ("y_min", "y_max")}


def made(case, **conditions):
    shape, cell, degree, mesh = case
    if cell == "stub":
        return Body("part", StubSpace(shape.size, mesh), MATERIAL, **conditions)
    return shape_body(shape, cell, degree, mesh, comm=MPI.COMM_SELF, **conditions)


def ends(case):
    """Opposite flat surfaces: below and above."""
    if case[1] == "stub":
        return "bottom", "top"
    return TOP["box" if case[0] is BOX else "plate"]


@pytest.fixture(params=FLAT)
def flat(request):
    return FLAT[request.param]


@pytest.fixture(params=ROUND)
def curved(request):
    return ROUND[request.param]


def test_matrices_are_symmetric_and_conserve_momentum(flat):
    part = made(flat)
    K, M = to_numpy(part.stiffness()), to_numpy(part.mass())
    np.testing.assert_array_equal(K, K.T)
    np.testing.assert_array_equal(M, M.T)
    motions = rigid_motions(part.space.dof_positions)
    assert np.abs(K @ motions).max() < 1e-13 * np.abs(K).max()
    assert np.linalg.matrix_rank(K, tol=1e-9 * np.abs(K).max()) == len(K) - motions.shape[1]
    volume = np.prod(flat[0].size)
    translations = motions[:, : part.dim]
    expected = MATERIAL.rho * volume * np.eye(part.dim)
    np.testing.assert_allclose(translations.T @ M @ translations, expected, atol=1e-13)
    middle = part.space.dof_positions.T @ M[:: part.dim, :: part.dim].sum(axis=1)
    np.testing.assert_allclose(middle, MATERIAL.rho * volume * np.array(flat[0].size) / 2)


def test_a_linear_field_is_the_answer_to_its_tractions(flat):
    """Pressed with 0.3 on both ends, nothing held: u = -0.3 / E (d - nu (others))."""
    low, high = ends(flat)
    part = made(flat, pressures=[Pressure(low, 0.3), Pressure(high, 0.3)])
    x, dim = part.space.dof_positions, part.dim
    strain = np.full(dim, 0.3 * MATERIAL.nu / MATERIAL.E)
    strain[-1] = -0.3 / MATERIAL.E
    if dim == 2:  # plane strain
        strain = 0.3 * (1 + MATERIAL.nu) / MATERIAL.E * np.array([MATERIAL.nu, MATERIAL.nu - 1])
    residual = to_numpy(part.stiffness()) @ (x * strain).ravel() - part.load().array_r
    assert np.abs(residual).max() < 1e-14


def test_curved_bodies_have_no_resultant_of_a_pressure_all_around(curved):
    part = made(curved, pressures=[Pressure(name, 0.7) for name in made(curved).surfaces])
    force = gather(part.load()).reshape(-1, part.dim)
    assert np.abs(force.sum(axis=0)).max() < 1e-13
    assert np.abs(rigid_motions(part.space.dof_positions).T @ force.ravel()).max() < 1e-13


def test_curved_matrices_are_symmetric_skew_and_leave_rigid_motions_free(curved):
    part = made(curved)
    K, motions = to_numpy(part.stiffness()), rigid_motions(part.space.dof_positions)
    assert np.abs(K @ motions).max() < 1e-12 * np.abs(K).max()
    for rotation in (Rotation(1.0), Rotation(1.0, coriolis=False)):
        Y, Z = to_numpy(part.gyroscopic(rotation)), to_numpy(part.convective_stiffness(rotation))
        np.testing.assert_array_equal(Y, -Y.T)
        np.testing.assert_array_equal(Z, Z.T)
        if not rotation.coriolis:  # nothing changes where a body turns as a whole about its axis
            turn = motions[:, part.dim]
            assert np.abs(Z @ turn).max() < 1e-12 * np.abs(Z).max()
    u = np.random.default_rng(1).normal(size=len(K))
    S = to_numpy(part.geometric_stiffness(u))
    np.testing.assert_array_equal(S, S.T)
    assert np.abs(S @ motions[:, : part.dim]).max() < 1e-12 * np.abs(S).max()


def test_round_bodies_have_the_areas_normals_and_volume_of_their_shape(curved):
    part, exact = made(curved), curved[1] is None
    allowed = 1e-13 if exact else 5e-3
    height = 0.3 if part.dim == 3 else 1.0
    flat = np.pi * (1.0 - 0.5**2)
    areas = {"inner": np.pi * height, "outer": 2 * np.pi * height, "bottom": flat, "top": flat}
    for name, surface in part.surfaces.items():
        assert surface.area == pytest.approx(areas[name], rel=allowed)
        kinds = (surface.abscissae(kind) for kind in surface.abscissa_kinds)
        for points in (surface.gauss_points(3), surface.grid(3), *kinds):
            outward = points.x * ([1.0, 1.0, 0.0][: part.dim] if name in ("inner", "outer") else 0)
            outward *= -1 if name == "inner" else 1
            outward[:, -1] += {"bottom": -1.0, "top": 1.0}.get(name, 0.0)
            outward /= np.linalg.norm(outward, axis=1)[:, None]
            assert np.einsum("ni,ni->n", points.normal, outward).min() > 1 - allowed
            assert points.weight.min() > 0
            assert points.weight.sum() == pytest.approx(surface.area, rel=1e-3)
    mass = to_numpy(part.mass())[:: part.dim, :: part.dim].sum()
    assert mass == pytest.approx(MATERIAL.rho * flat * height, rel=max(allowed, 1e-6))


@pytest.mark.parametrize(
    ("field", "options"),
    [
        ("supports[0].surface", {"supports": [Support("lid", (0,))]}),
        ("springs[0].surface", {"springs": [Spring("lid", (1.0, 1.0, 1.0))]}),
        ("pressures[0].surface", {"pressures": [Pressure("lid", 1.0)]}),
        ("springs[0].stiffness", {"springs": [Spring("top", (1.0, 1.0))]}),
    ],
)
@pytest.mark.parametrize("case", ["Q2", "NURBS 2"])
def test_wrong_conditions_are_refused_by_name(case, field, options):
    with pytest.raises(InputError) as refused:
        made(ROUND[case], **options)
    assert refused.value.field == f"bodies.part.{field}"
    if field.endswith("surface"):
        assert all(name in refused.value.allowed for name in ANNULUS.surfaces)


@pytest.mark.parametrize("case", ["Q2", "NURBS 2"])
def test_requests_that_make_no_points_are_refused(case):
    top = made(ROUND[case]).surfaces["top"]
    lost = SurfaceCoordinates(np.array([0, -1]), np.full((2, 2), 0.5))
    requests = [
        (lambda: top.abscissae("midpoints"), "one of "),
        (lambda: top.gauss_points(0), "at least one"),
        (lambda: top.grid(1), "at least two"),
        (lambda: top.position(lost), r"at\.element"),
        (lambda: top.trace(lost), r"at\.element"),
    ]
    for request, words in requests:
        with pytest.raises(InputError, match=words):
            request()


@pytest.mark.parametrize("name", [name for name in FLAT if name != "stub"])
def test_straight_cells_fill_the_body_and_know_its_positions(name):
    part = made(FLAT[name])
    own = part.space.volume_cells()
    cells = own.straight()
    assert len(np.unique(np.round(cells.points, 9), axis=0)) == len(cells.points)
    control = np.linalg.lstsq(own.values.toarray(), own.points, rcond=None)[0]
    np.testing.assert_allclose(cells.values @ control, cells.points, atol=1e-13)
    corners = cells.points[cells.cells]
    along = range(1, part.dim + 1) if own.simplex else [1, 3, 4][: part.dim]
    volume = np.linalg.det(corners[:, along] - corners[:, :1])
    assert volume.min() > 0
    whole = volume.sum() / (6 if own.simplex else 1)
    assert whole == pytest.approx(np.prod(FLAT[name][0].size), rel=1e-12)


def test_springs_and_forces_have_their_sums(flat):
    low, high = ends(flat)
    stiffness = (2.0, 3.0, 5.0)[: len(flat[0].size)]
    value = tuple(0.1 * k for k in stiffness)
    loads = [Force(value, high), Force(value)]
    part = made(flat, springs=[Spring(low, stiffness)], forces=loads)
    translations = rigid_motions(part.space.dof_positions)[:, : part.dim]
    total = translations.T @ to_numpy(part.stiffness()) @ translations
    area = np.prod(flat[0].size[:-1])
    np.testing.assert_allclose(total, area * np.diag(stiffness), atol=1e-12)
    resultant = gather(part.load()).reshape(-1, part.dim).sum(axis=0)
    expected = np.array(value) * (1 + np.prod(flat[0].size))
    np.testing.assert_allclose(resultant, expected, rtol=1e-12)


def test_supports_leave_what_they_do_not_hold(flat):
    low, high = ends(flat)
    last = len(flat[0].size) - 1
    part = made(
        flat, supports=[Support(low, (last,))], forces=[Force((0.0,) * last + (0.2,), high)]
    )
    Z = to_numpy(part.expansion)
    np.testing.assert_allclose(Z.T @ Z, np.eye(Z.shape[1]), atol=1e-14)
    K = Z.T @ to_numpy(part.full_stiffness()) @ Z
    np.testing.assert_allclose(to_numpy(part.stiffness()), K, atol=1e-13 * np.abs(K).max())
    surface = part.surfaces[low]
    points = surface.gauss_points(2)
    u = Z @ np.random.default_rng(2).normal(size=Z.shape[1])
    traced = surface.trace(points.at) @ u.reshape(-1, part.dim)
    assert np.abs(traced[:, last]).max() < 1e-14
    assert np.abs(traced[:, 0]).max() > 0.01


def test_surfaces_measure_trace_and_differentiate(flat):
    part = made(flat)
    rng = np.random.default_rng(3)
    slope, shift = rng.normal(size=part.dim), 0.4
    field = part.space.dof_positions @ slope + shift
    for name, side in zip(ends(flat), (-1.0, 1.0), strict=True):
        surface = part.surfaces[name]
        for points in (
            surface.gauss_points(2),
            surface.grid(3),
            *(
                surface.abscissae(kind, weights)
                for kind in surface.abscissa_kinds
                for weights in surface.abscissa_weights
            ),
        ):
            assert points.weight.sum() == pytest.approx(np.prod(flat[0].size[:-1]))
            assert points.weight.min() > 0
            np.testing.assert_allclose(points.normal[:, -1], side, atol=1e-14)
            np.testing.assert_allclose(points.x, surface.position(points.at), atol=1e-14)
            traced = surface.trace(points.at) @ field
            np.testing.assert_allclose(traced, points.x @ slope + shift, atol=1e-13)
            np.testing.assert_allclose((surface.split_trace(points.at)).sum(axis=1), 1, atol=1e-13)
            for part_of, expected in zip(surface.gradient(points.at), slope, strict=True):
                np.testing.assert_allclose(part_of @ field, expected, atol=1e-12)


def test_gradients_along_a_surface_are_those_of_the_trace(curved):
    part = made(curved)
    u = np.random.default_rng(4).normal(size=part.num_scalar_dofs)
    for surface in part.surfaces.values():
        at = surface.gauss_points(2).at
        gradient = np.stack([part_of @ u for part_of in surface.gradient(at)], axis=1)
        _, tangents = surface.tangents(at.element, at.xi)
        low, high = (end[at.element] for end in surface.domains)
        for k in range(part.dim - 1):
            step = 1e-5 * (high - low) * np.eye(part.dim - 1)[k]
            ahead, behind = (
                surface.trace(SurfaceCoordinates(at.element, at.xi + way * step)) @ u
                for way in (1, -1)
            )
            along = np.einsum("ni,ni->n", gradient, tangents[:, :, k])
            expected = (ahead - behind) / (2 * step[:, k])
            np.testing.assert_allclose(along, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("cases", [FLAT, ROUND], ids=["flat", "round"])
def test_points_beside_a_surface_are_found_where_they_came_from(cases):
    for case in cases.values():
        part = made(case)
        for surface in part.surfaces.values():
            points = surface.gauss_points(3)
            gap = 0.05 * np.cos(np.arange(len(points)))
            found = surface.locate(points.x + gap[:, None] * points.normal, points.normal, 0.06)
            assert not found.missed.any()
            np.testing.assert_allclose(found.distance, -gap, atol=1e-9)
            np.testing.assert_allclose(surface.position(found.at), points.x, atol=1e-8)
            far = surface.locate(points.x + 3.0 * points.normal, points.normal, 0.06)
            assert (far.status == Status.MISSED).all()


@pytest.mark.parametrize("kind", ["fe", "iga", "stub"])
def test_frequencies_of_a_sliding_plate_converge_at_twice_the_degree(kind):
    """Between rollers at both ends: plane waves across the height, kappa = c^2 (pi / 0.8)^2."""
    degree = {"fe": 2, "iga": 2, "stub": 1}[kind]
    cell = {"fe": "quadrilateral", "iga": None, "stub": "stub"}[kind]
    lam, mu = MATERIAL.lame
    exact = (lam + 2 * mu) / MATERIAL.rho * (np.pi / 0.8) ** 2
    errors, counts = [], (2, 4, 8)
    for n in counts:
        case = (PLATE, cell, degree, (1, n))
        low, high = ends(case)
        part = made(case, supports=[Support(low, (1,)), Support(high, (1,))])
        K, M, Z = to_numpy(part.stiffness()), to_numpy(part.mass()), to_numpy(part.expansion)
        y = part.space.dof_positions[:, 1]
        lines = np.unique(np.round(y, 9))[1:-1]
        # Uniform along x: one unknown for each row of nodes.
        rows = [np.column_stack([0 * y, np.abs(y - line) < 1e-8]).ravel() for line in lines]
        own = Z.T @ np.transpose(rows)
        A, B = own.T @ K @ own, own.T @ M @ own
        values = np.sort(np.linalg.eigvals(np.linalg.solve(B, A)).real)
        errors.append(abs(values[0] / exact - 1))
    rate = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert rate == pytest.approx(2 * degree, abs=0.35)
    assert errors[-1] < {2: 1e-4, 1: 2e-2}[degree]


TOPS = {
    "hexahedron": 0.35,
    "tetrahedron": 0.35,
    "triangle": 0.5,
    "quadrilateral": 0.7,
    "ring": 0.25,
    "closed": 0.3,
    "disc": 0.35,
    "odd": 0.4,
    "sector": 0.5,
    "hub": 0.3,
}
"""Highest frequency (Hz) by body: planes, closed and collapsed patches, odd joints among them."""


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("case", TOPS)
def test_static_work_and_modes_agree_on_any_ranks(case, ranks):
    alone, together = (on_ranks(n, "space_numbers.numbers", case, TOPS[case]) for n in (1, ranks))
    assert len(alone["same"]["frequencies"]) >= 3
    for quantity, expected in alone["same"].items():
        allowed = 1e-9 * np.abs(expected).max()
        found = together["same"][quantity]
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=allowed, err_msg=quantity)
    assert {*alone["asymmetry"], *together["asymmetry"]} == {0.0}
