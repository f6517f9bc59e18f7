"""What every backend must hold: matrices, supports, loads, surfaces of a `cea.body.Space`."""

from functools import cache

import numpy as np
import pytest
from bodies import PLASTIC as MATERIAL
from bodies import shape_body
from closed_patches import annulus, as_shape
from motions import asymmetry, rigid_motions
from mpi import on_ranks
from petsc_matrices import gather, to_numpy

from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.static import solve_static
from cea.motion import Rotation
from cea.petsc import MPI
from cea.supports.boundary import Force, Pressure, Spring, Support
from cea.surface_points import Status, SurfaceCoordinates
from meshes.shapes import Annulus, Box, Disc, Hub, Rectangle, Ring

BOX, PLATE = Box((1.0, 0.8, 0.5)), Rectangle((1.0, 0.8))
RING, ANNULUS = Ring(0.5, 1.0), Annulus(0.5, 1.0, 0.0, 0.3)
FLAT = {
    "P2": (BOX, "tetrahedron", 2, 0.5),
    "Q1": (BOX, "hexahedron", 1, (2, 2, 1)),
    "Q3 plane": (PLATE, "quadrilateral", 3, (2, 2)),
    "NURBS 2": (BOX, None, 2, (2, 2, 1)),
    "NURBS 3 plane": (PLATE, None, 3, (3, 2)),
}
ROUND = {
    "P2": (ANNULUS, "tetrahedron", 2, 0.4),
    "Q2": (ANNULUS, "hexahedron", 2, (1, 12, 1)),
    "P3 plane": (RING, "triangle", 3, 0.4),
    "NURBS 2": (ANNULUS, None, 2, (1, 16, 1)),
    "NURBS 3 plane": (RING, None, 3, (1, 8)),
}


def made(case, **conditions):
    shape, cell, degree, mesh = case
    return shape_body(shape, cell, degree, mesh, comm=MPI.COMM_SELF, **conditions)


@cache
def plain(case):
    """A body without supports or loads, which the tests leave as it is."""
    return made(case)


def ends(case):
    """Opposite flat surfaces: below and above."""
    return ("z_min", "z_max") if case[0] is BOX else ("y_min", "y_max")


@pytest.fixture(params=FLAT)
def flat(request):
    return FLAT[request.param]


@pytest.fixture(params=ROUND)
def curved(request):
    return ROUND[request.param]


def assert_mirrored(matrix, free, *, sign=1.0, within=1e-12):
    """A matrix equals plus or minus its transpose, and does nothing to some motions."""
    np.testing.assert_array_equal(matrix, sign * matrix.T)
    assert np.abs(matrix @ free).max(initial=0.0) < within * np.abs(matrix).max()


def test_matrices_are_symmetric_and_conserve_momentum(flat):
    part = plain(flat)
    motions = rigid_motions(part.space.dof_positions)
    K, M, translations = to_numpy(part.stiffness()), to_numpy(part.mass()), motions[:, : part.dim]
    assert_mirrored(K, motions, within=1e-13)
    assert_mirrored(M, motions[:, :0])
    assert np.linalg.matrix_rank(K, tol=1e-9 * np.abs(K).max()) == len(K) - motions.shape[1]
    mass = MATERIAL.rho * np.prod(flat[0].size)
    found = translations.T @ M @ translations
    np.testing.assert_allclose(found, mass * np.eye(part.dim), atol=1e-13)
    middle = part.space.dof_positions.T @ M[:: part.dim, :: part.dim].sum(axis=1)
    np.testing.assert_allclose(middle, mass * np.array(flat[0].size) / 2)


def test_curved_matrices_are_symmetric_skew_and_leave_rigid_motions_free(curved):
    part = made(curved, pressures=[Pressure(name, 0.7) for name in curved[0].surfaces])
    motions = rigid_motions(part.space.dof_positions)
    assert np.abs(motions.T @ gather(part.load())).max() < 1e-13  # of a pressure all around
    assert_mirrored(to_numpy(part.stiffness()), motions)
    for rotation in (Rotation(1.0), Rotation(1.0, coriolis=False)):
        assert_mirrored(to_numpy(part.gyroscopic(rotation)), motions[:, :0], sign=-1.0)
        # Nothing changes where a body turns as a whole about its axis.
        free = motions[:, part.dim : part.dim + (not rotation.coriolis)]
        assert_mirrored(to_numpy(part.convective_stiffness(rotation)), free)
    u = np.random.default_rng(1).normal(size=len(motions))
    assert_mirrored(to_numpy(part.geometric_stiffness(u)), motions[:, : part.dim])


def test_round_bodies_have_the_areas_normals_and_volume_of_their_shape(curved):
    part, exact = plain(curved), curved[1] is None
    allowed = 1e-13 if exact else 5e-3
    height = 0.3 if part.dim == 3 else 1.0
    flat = np.pi * (1.0 - 0.5**2)
    areas = {"inner": np.pi * height, "outer": 2 * np.pi * height, "bottom": flat, "top": flat}
    for name, surface in part.surfaces.items():
        assert surface.area == pytest.approx(areas[name], rel=allowed)
        for points in points_of(surface):
            outward = points.x * ([1.0, 1.0, 0.0][: part.dim] if name in ("inner", "outer") else 0)
            outward *= -1 if name == "inner" else 1
            outward[:, -1] += {"bottom": -1.0, "top": 1.0}.get(name, 0.0)
            outward /= np.linalg.norm(outward, axis=1)[:, None]
            assert np.einsum("ni,ni->n", points.normal, outward).min() > 1 - allowed
            assert points.weight.min() > 0
            assert points.weight.sum() == pytest.approx(surface.area, rel=1e-3)
    mass = to_numpy(part.mass())[:: part.dim, :: part.dim].sum()
    assert mass == pytest.approx(MATERIAL.rho * flat * height, rel=max(allowed, 1e-6))


def points_of(surface):
    """Every kind of points on a surface."""
    yield surface.gauss_points(3)
    yield surface.grid(3)
    for kind in surface.abscissa_kinds:
        for weights in surface.abscissa_weights:
            yield surface.abscissae(kind, weights)


@pytest.mark.parametrize("name", FLAT)
def test_straight_cells_fill_the_body_and_know_its_positions(name):
    part = plain(FLAT[name])
    own = part.space.volume_cells()
    cells = own.straight()
    assert len(np.unique(np.round(cells.points, 9), axis=0)) == len(cells.points)
    control = np.linalg.lstsq(own.values.toarray(), own.points, rcond=None)[0]
    np.testing.assert_allclose(cells.values @ control, cells.points, atol=1e-13)
    corners = cells.points[cells.cells]
    along = [3, 2, 1][-part.dim :] if own.simplex else [4, 2, 1][-part.dim :]
    volume = np.linalg.det(corners[:, along] - corners[:, :1])
    assert volume.min() > 0
    whole = volume.sum() / (6 if own.simplex else 1)
    assert whole == pytest.approx(np.prod(FLAT[name][0].size), rel=1e-12)


def test_springs_and_loads_have_their_sums(flat):
    low, high = ends(flat)
    stiffness = (2.0, 3.0, 5.0)[: len(flat[0].size)]
    value = tuple(0.1 * k for k in stiffness)
    loads = {"forces": [Force(value, high), Force(value)], "pressures": [Pressure(low, 0.3)]}
    part = made(flat, springs=[Spring(low, stiffness)], **loads)
    translations = rigid_motions(part.space.dof_positions)[:, : part.dim]
    total = translations.T @ to_numpy(part.stiffness()) @ translations
    area, volume = np.prod(flat[0].size[:-1]), np.prod(flat[0].size)
    np.testing.assert_allclose(total, area * np.diag(stiffness), atol=1e-12)
    expected = np.array(value) * (1 + volume)
    expected[-1] += 0.3 * area
    np.testing.assert_allclose(translations.T @ gather(part.load()), expected, rtol=1e-12)


def test_supports_hold_the_components_they_name(flat):
    low, _ = ends(flat)
    part = made(flat, supports=[Support(low, (low[0],))])
    surface, Z = part.surfaces[low], to_numpy(part.expansion)
    u = Z @ np.random.default_rng(2).normal(size=Z.shape[1])
    traced = surface.trace(surface.gauss_points(2).at) @ u.reshape(-1, part.dim)
    assert np.abs(traced[:, -1]).max() < 1e-14
    assert np.abs(traced[:, 0]).max() > 0.01


def test_surfaces_measure_trace_and_differentiate(flat):
    part = plain(flat)
    slope, shift = np.random.default_rng(3).normal(size=part.dim), 0.4
    field = part.space.dof_positions @ slope + shift
    for name, side in zip(ends(flat), (-1.0, 1.0), strict=True):
        surface = part.surfaces[name]
        for points in points_of(surface):
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
    part = plain(curved)
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
        for surface in plain(case).surfaces.values():
            points = surface.gauss_points(3)
            gap = 0.05 * np.cos(np.arange(len(points)))
            found = surface.locate(points.x + gap[:, None] * points.normal, points.normal, 0.06)
            assert not found.missed.any()
            np.testing.assert_allclose(found.distance, -gap, atol=1e-9)
            np.testing.assert_allclose(surface.position(found.at), points.x, atol=1e-8)
            far = surface.locate(points.x + 3.0 * points.normal, points.normal, 0.06)
            assert (far.status == Status.MISSED).all()


ON_RANKS = ROUND | {
    "Q3 plane": FLAT["Q3 plane"],
    "closed": (as_shape(annulus(0.5, 1.0)), None, (3, 2), (8, 2)),
    "disc": (Disc(1.2, -0.1, 0.2), None, 2, (1, 8, 1)),
    "hub": (Hub(0.3, 0.6, 1.2, -0.1, 0.1, -0.1, 0.3), None, (2, 2, 1), (2, 12, 2)),
}
"""Patches that close on themselves and that collapse at an axis among them."""


def numbers(name):
    """Frequencies, work of loads, areas, integrals of traces and in cells, norms; asymmetry."""
    shape, cell, degree, mesh = ON_RANKS[name]
    held, *_, pressed = shape.surfaces
    dim = 2 if "plane" in name or name == "closed" else 3
    part = shape_body(
        shape,
        cell,
        degree,
        mesh,
        supports=[Support(held, ("x",))],
        springs=[Spring(held, (1.0, 2.0, 3.0)[:dim])],
        pressures=[Pressure(pressed, 0.3)],
        forces=[Force((0.1, 0.0, 0.2)[:dim]), Force((0.1, 0.3, 0.0)[:dim], pressed)],
    )
    modes = solve_modes(Pencil.of(part.stiffness(), part.mass()), 0.5)
    x = solve_static(Pencil.of(part.stiffness()), part.load()).displacement
    u = gather(part.expansion @ x)
    moved = u.reshape(-1, dim)
    shown = {"frequencies": sorted(modes.frequencies.tolist()), "work": part.load().dot(x)}
    for surface in part.surfaces.values():
        points = surface.gauss_points(2)
        traced = surface.trace(points.at) @ moved
        slope = np.stack([g @ moved for g in surface.gradient(points.at)])
        shown[f"area of {surface.name}"] = surface.area
        shown[f"trace on {surface.name}"] = (points.weight @ traced**2).tolist()
        shown[f"gradient on {surface.name}"] = float(points.weight @ (slope**2).sum(axis=(0, 2)))
    sample = part.space.volume_cells().straight()
    shown["cells"] = [len(sample.cells), *(sample.points[sample.cells] ** 2).mean(axis=(0, 1))]
    shown["in cells"] = [((sample.values @ moved)[sample.cells] ** 2).mean()]
    symmetric = [part.stiffness(), part.mass()]
    if dim == 3:
        symmetric.append(part.geometric_stiffness(u))
        shown["gyroscopic"] = part.gyroscopic(Rotation(2.0, coriolis=False)).norm()
    shown["norms"] = [matrix.norm() for matrix in symmetric]
    return shown, [asymmetry(matrix) for matrix in symmetric]


QUICK = ("P2", "Q3 plane", "NURBS 3 plane", "closed", "disc")


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in ON_RANKS]
)
def test_static_work_and_modes_agree_on_any_ranks(name, ranks):
    (alone, _), (together, asymmetries) = numbers(name), on_ranks(ranks, numbers, name)
    assert len(alone["frequencies"]) >= 3
    assert not any(asymmetries)
    for quantity, expected in alone.items():
        allowed = 1e-9 * np.abs(expected).max()
        found = together[quantity]
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=allowed, err_msg=quantity)
