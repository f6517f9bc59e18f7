"""Lagrange surfaces: rules, trace, gradient, and location of points against brute force."""

import numpy as np
import pytest
from bodies import lagrange_body

from cea.errors import InputError
from cea.location import locate_along
from cea.material import IsotropicMaterial
from cea.surface_points import Status, SurfaceCoordinates
from meshes.breaks import breaks_of
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box

ELEMENTS = [("tetrahedron", 1), ("tetrahedron", 2), ("hexahedron", 1), ("hexahedron", 2)]
PLACEMENT = Placement(axis=(1.0, 2.0, -0.5), angle=37.0, translation=(0.3, -0.2, 0.7))
BOX = Box((2.0, 1.0, 0.5), origin=(0.1, -0.3, 0.2))
ANNULUS = Annulus(0.5, 1.0, 0.0, 0.3)
MESHES = {
    "box": (BOX, (3, 3, 2), {"x": [0.6]}, 0.4),
    "annulus": (ANNULUS, (2, 16, 1), None, 0.25),
    "graded": (BOX, (6, 3, 3), {"x": [0.101, 0.11, 0.2], "z": [0.21]}, 0.4),
}

every_element = pytest.mark.parametrize(("cell", "degree"), ELEMENTS)


def make(kind, cell, degree, placement=PLACEMENT):
    shape, elements, through, size = MESHES[kind]
    mesh = (
        {"size": size} if cell == "tetrahedron" else {"breaks": breaks_of(shape, elements, through)}
    )
    made = shape_mesh(shape, cell, degree, placement=placement, **mesh)
    material = IsotropicMaterial(1.0, 0.3)
    return lagrange_body("part", made, degree=degree, material=material)


def coordinates(body, degree):
    sample = body.space.volume_sample(degree)
    return sample.values.T @ sample.points


def scattered(surface, n, seed=1):
    """Random points of a surface, away from the edges of its facets."""
    rng = np.random.default_rng(seed)
    return SurfaceCoordinates(
        rng.integers(0, surface.num_elements, n), rng.uniform(0.02, 0.48, (n, 2))
    )


def native(points):
    return (points - PLACEMENT.translation) @ PLACEMENT.rotation


def outward(name, x):
    """Outward normals of the shapes in their own frame, by name of the surface."""
    if name in ("inner", "outer"):
        radial = x * [1.0, 1.0, 0.0]
        radial /= np.linalg.norm(radial, axis=1, keepdims=True)
        return radial if name == "outer" else -radial
    axis, side = {"bottom": "z_min", "top": "z_max"}.get(name, name).split("_")
    return np.tile(np.eye(3)["xyz".index(axis)] * (1 if side == "max" else -1), (len(x), 1))


@every_element
@pytest.mark.parametrize("kind", MESHES)
def test_normals_point_outward_and_points_lie_on_the_surface(kind, cell, degree):
    for name, surface in make(kind, cell, degree).surfaces.items():
        for points in (surface.gauss_points(3), surface.grid(3), surface.abscissae("nodes")):
            normal = points.normal @ PLACEMENT.rotation
            np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1, rtol=1e-14)
            x = native(points.x)
            aligned = np.einsum("ni,ni->n", normal, outward(name, x))
            curved = name in ("inner", "outer")
            assert aligned.min() > 1 - ({1: 0.05, 2: 1e-3}[degree] if curved else 1e-12)
            if curved:
                radius = getattr(ANNULUS, f"{name}_radius")
                sag = {1: 0.03, 2: 1e-3}[degree]
                np.testing.assert_allclose(np.hypot(x[:, 0], x[:, 1]), radius, rtol=sag)


@every_element
@pytest.mark.parametrize("kind", MESHES)
def test_every_rule_measures_the_area(kind, cell, degree):
    for surface in make(kind, cell, degree).surfaces.values():
        assert surface.gauss_points(9).weight.sum() == pytest.approx(surface.area, rel=1e-9)
        for points in (surface.grid(4), surface.abscissae("nodes")):
            assert np.ptp(points.weight) == 0
            assert points.weight.sum() == pytest.approx(surface.area, rel=1e-12)


@every_element
def test_abscissae_are_the_nodes_of_the_surface(cell, degree):
    body = make("annulus", cell, degree)
    for surface in body.surfaces.values():
        points = surface.abscissae("nodes")
        trace = surface.trace(points.at)
        values = trace.toarray()
        assert np.array_equal(np.rint(values).sum(axis=1), np.ones(len(points)))
        np.testing.assert_allclose(values, np.rint(values), atol=1e-14)
        # As many points as basis functions that live on the surface, each picked once.
        alive = np.unique(surface.trace(scattered(surface, 4000)).indices)
        assert np.array_equal(np.unique(values.argmax(axis=1)), alive)
        assert len(points) == len(alive)


@every_element
@pytest.mark.parametrize("kind", MESHES)
def test_grid_has_shared_points_once(kind, cell, degree):
    surface = make(kind, cell, degree).surfaces["top" if kind == "annulus" else "z_max"]
    corners = len(surface.grid(2))
    for n in (3, 5):
        points = surface.grid(n)
        assert len(np.unique(np.round(points.x, 9), axis=0)) == len(points)
        facets = surface.num_elements
        # Euler: V - E + F is 0 for a ring, 1 for a disc.
        edges = corners + facets - (0 if kind == "annulus" else 1)
        inner = (n - 2) * (n - 3) // 2 if cell == "tetrahedron" else (n - 2) ** 2
        assert len(points) == corners + edges * (n - 2) + facets * inner


@every_element
def test_points_beyond_the_rim_or_reach_are_missed(cell, degree):
    body = make("box", cell, degree, Placement())
    surface = body.surfaces["z_max"]
    (x0, x1), (y0, y1), (_, z1) = BOX.extent
    up = np.tile([0.0, 0.0, 1.0], (5, 1))
    size = surface.mesh_size
    x = np.array(
        [
            [x1 + 1e-6 * size, 0.0, z1],
            [x0 - 1e-3, y0 - 1e-3, z1],
            [x1 + 5.0, y1 + 7.0, z1],
            [x0 + 0.31, 0.03, z1 + 0.11],
            [x0 + 0.31, 0.03, z1 + 0.09],
        ]
    )
    found = surface.locate(x, up, reach=0.1)
    assert found.status[:4].tolist() == [Status.MISSED] * 4
    assert found.status[4] in (Status.INSIDE, Status.EDGE)
    assert found.distance[4] == pytest.approx(-0.09, abs=1e-12)
    # Clamped in reference coordinates, a point on a slanted triangle is not quite the nearest.
    nearest = np.array([1e-6 * size, np.sqrt(2) * 1e-3])
    assert (found.miss[:2] > (1 - 1e-6) * nearest).all()
    assert (found.miss[:2] < (1.5 if cell == "tetrahedron" else 1 + 1e-6) * nearest).all()
    assert np.isinf(found.miss[2])
    assert found.at.element[2] == -1


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_a_short_reach_finds_points_on_the_bulge_of_a_curved_facet(cell):
    """Facets of a quarter circle leave the boxes of their corners by far more than the reach."""
    ring = Annulus(0.5, 1.0, 0.0, 0.3)
    mesh = {"size": 0.6} if cell == "tetrahedron" else {"breaks": breaks_of(ring, (1, 4, 1))}
    made = shape_mesh(ring, cell, 2, placement=Placement(angle=45.0), **mesh)
    body = lagrange_body("ring", made, degree=2, material=IsotropicMaterial(1.0, 0.3))
    for name in ("inner", "outer"):
        surface = body.surfaces[name]
        points = surface.gauss_points(8)
        found = surface.locate(points.x, points.normal, reach=1e-6)
        assert not found.missed.any()
        np.testing.assert_allclose(surface.position(found.at), points.x, atol=1e-8)


class EveryPair:
    """Chart that tries every facet for every point."""

    def __init__(self, surface):
        self._surface = surface
        self._count = surface.num_elements

    def __getattr__(self, name):
        return getattr(self._surface, name)

    def candidates(self, x, direction, reach):
        """Every point with every facet."""
        point = np.repeat(np.arange(len(x)), self._count)
        element = np.tile(np.arange(self._count), len(x))
        return point, element, np.full((len(point), 2), 0.3)


@pytest.mark.parametrize(
    ("cell", "kind", "name"),
    [
        ("hexahedron", "annulus", "outer"),
        ("tetrahedron", "box", "y_max"),
        ("hexahedron", "graded", "y_max"),
        pytest.param("tetrahedron", "annulus", "outer", marks=pytest.mark.slow),
        pytest.param("hexahedron", "box", "y_max", marks=pytest.mark.slow),
        pytest.param("tetrahedron", "graded", "y_max", marks=pytest.mark.slow),
    ],
)
def test_candidates_agree_with_brute_force(kind, name, cell):
    """2000 points in and around the surface, directions aslant: the same status for all."""
    surface = make(kind, cell, 2).surfaces[name]
    rng = np.random.default_rng(5)
    at = scattered(surface, 2000)
    normal = surface.normal(at)
    spread = rng.normal(0, 0.15, (2000, 3))
    x = surface.position(at) + spread
    direction = normal + rng.normal(0, 0.2, (2000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    reach = 0.15
    found = surface.locate(x, direction, reach)
    truth = locate_along(EveryPair(surface), x, direction, reach)
    assert 200 < found.missed.sum() < 1800
    assert np.array_equal(found.status, truth.status)
    hit = ~found.missed
    np.testing.assert_allclose(found.distance[hit], truth.distance[hit], atol=1e-8)
    same = surface.position(found.at[hit]) - surface.position(truth.at[hit])
    assert np.abs(same).max() < 1e-8


def test_wrong_requests_are_refused():
    surface = make("box", "hexahedron", 1).surfaces["x_min"]
    with pytest.raises(InputError, match="greville"):
        surface.abscissae("greville")
    with pytest.raises(InputError, match="at least one"):
        surface.gauss_points(0)
    with pytest.raises(InputError, match="at least two"):
        surface.grid(1)
    lost = SurfaceCoordinates(np.array([0, -1]), np.full((2, 2), 0.5))
    for evaluate in (surface.position, surface.normal, surface.trace, surface.gradient):
        with pytest.raises(InputError, match=r"at\.element"):
            evaluate(lost)
