"""Surfaces of NURBS bodies: points, areas, normals, location, trace and derivatives."""

import numpy as np
import pytest
from bodies import nurbs_body
from covering import covering

from cea.body import Body
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.surface_points import Status
from iga_cea.grids import grid_points
from iga_cea.surface import NurbsSurface
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Sector, Shape

STEEL = IsotropicMaterial(E=2.1, nu=0.3)
TILTED = Placement(axis=(1.0, 2.0, -0.5), angle=33.0, translation=(0.1, -0.2, 0.3))
INNER, OUTER, BOTTOM, TOP = 0.8, 1.7, -0.1, 0.2
ANNULUS = Annulus(INNER, OUTER, BOTTOM, TOP)
START, END = 20.0, 110.0
SECTOR = Sector(INNER, OUTER, START, END, BOTTOM, TOP)
BOX = Box((2.0, 1.0, 0.5), (0.1, 0.2, 0.3))
RNG = np.random.default_rng(11)


def body(shape: Shape, elements=(2, 8, 2), degree=(2, 3, 2), placement=TILTED) -> Body:
    data = nurbs_shape(shape, breaks_of(shape, elements), placement)
    return nurbs_body("part", data.patches, data.faces, degree, material=STEEL)


@pytest.fixture(scope="module")
def ring() -> Body:
    return body(ANNULUS, placement=Placement())


def exact_area(shape: Shape, name: str) -> float:
    """Area of a named surface in closed form."""
    if isinstance(shape, Box):
        x, y, z = shape.size
        return {"x": y * z, "y": x * z, "z": x * y}[name[0]]
    angle = 2 * np.pi if isinstance(shape, Annulus) else np.deg2rad(END - START)
    height = TOP - BOTTOM
    return {
        "inner": INNER * angle * height,
        "outer": OUTER * angle * height,
        "start": (OUTER - INNER) * height,
        "end": (OUTER - INNER) * height,
        "bottom": angle * (OUTER**2 - INNER**2) / 2,
        "top": angle * (OUTER**2 - INNER**2) / 2,
    }[name]


def exact_normal(name: str, x: np.ndarray) -> np.ndarray:
    """Outward normal at points of a shape that has not been placed."""
    out = np.zeros_like(x)
    if name[1:] in ("_min", "_max"):
        out[:, "xyz".index(name[0])] = 1 if name.endswith("max") else -1
    elif name in ("inner", "outer"):
        out[:, :2] = x[:, :2] / np.linalg.norm(x[:, :2], axis=1)[:, None]
        out *= 1 if name == "outer" else -1
    elif name in ("start", "end"):
        angle = np.deg2rad(START if name == "start" else END)
        out[:, :2] = -np.sin(angle), np.cos(angle)
        out *= -1 if name == "start" else 1
    else:
        out[:, 2] = 1 if name == "top" else -1
    return out


@pytest.mark.parametrize(
    ("shape", "placement"), covering((BOX, ANNULUS, SECTOR), (Placement(), TILTED), strength=1)
)
def test_areas_and_normals(shape: Shape, placement: Placement) -> None:
    part = body(shape, placement=placement)
    assert tuple(part.surfaces) == shape.surfaces
    for name, surface in part.surfaces.items():
        assert surface.area == pytest.approx(exact_area(shape, name), rel=1e-13)
        for points in (surface.gauss_points(3), surface.abscissae("greville"), surface.grid(4)):
            original = (points.x - placement.translation) @ placement.rotation
            normal = exact_normal(name, original) @ placement.rotation.T
            assert np.abs(points.normal - normal).max() < 1e-13
            assert points.weight.min() > 0
            assert points.weight.sum() == pytest.approx(surface.area, rel=1e-3)


def test_normals_point_outward_whatever_the_handedness() -> None:
    """A box whose first parameter runs backward."""
    patch = nurbs_shape(BOX, breaks_of(BOX, (2, 2, 2))).patches[0]
    mirrored = NurbsPatch(
        patch.degrees, patch.knots, patch.control_points[::-1], patch.weights, patch.breaks
    )
    faces = {"x_max": [(0, 0, 0)], "x_min": [(0, 0, 1)], "z_max": [(0, 2, 1)]}
    part = nurbs_body("part", [mirrored], faces, (2, 2, 2), material=STEEL)
    for name, surface in part.surfaces.items():
        points = surface.gauss_points(2)
        np.testing.assert_allclose(points.normal, exact_normal(name, points.x), atol=1e-14)
    assert (part.stiffness().getDiagonal().getArray() > 0).all()


def test_numbers_of_points(ring: Body) -> None:
    """Spans 2 x 8 on top, degree (2, 3): joints of the four faces count once."""
    top, outer = ring.surfaces["top"], ring.surfaces["outer"]
    assert top.num_elements == 4
    assert len(top.gauss_points(3)) == 2 * 8 * 9
    assert len(top.abscissae("greville")) == 4 * 4 * 4 == len(top.dofs)
    assert len(top.grid(5)) == 5 * 4 * 4
    assert len(outer.grid(5)) == 5 * 4 * 4
    for points in (top.abscissae("greville"), top.grid(5)):
        assert len(np.unique(np.round(points.x, 9), axis=0)) == len(points)
        np.testing.assert_allclose(points.weight, top.area / len(points), rtol=1e-15)


def test_greville_points_interpolate(ring: Body) -> None:
    """As many points as trace functions, and the collocation matrix is regular."""
    for surface in ring.surfaces.values():
        square = surface.trace(surface.abscissae("greville").at).toarray()[:, surface.dofs]
        assert square.shape[0] == square.shape[1]
        assert np.linalg.cond(square) < 100


@pytest.mark.parametrize("shape", [ANNULUS, SECTOR, BOX], ids=lambda s: s.shape)
def test_trace_and_gradient_of_linear_fields(shape: Shape) -> None:
    part = body(shape)
    x = part.dof_positions
    slope, shift = np.array([0.3, -0.7, 1.1]), 0.4
    for surface in part.surfaces.values():
        points = surface.gauss_points(2)
        trace, gradient = surface.trace(points.at), surface.gradient(points.at)
        assert np.abs(trace @ x - points.x).max() < 2e-15
        assert np.abs(trace.sum(axis=1) - 1).max() < 1e-15
        linear = x @ slope + shift
        for d in range(3):
            assert np.abs(gradient[d] @ linear - slope[d]).max() < 1e-12


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
                basis = patch.basis_on_grid(list(parameter[:, None]))
                values.append(basis @ coefficients)
                positions.append(basis @ patch.control_points.reshape(-1, 3))
            one_sided = np.array([-1.5, 2.0, -0.5])
            change = one_sided @ np.array(values)[:, 0]
            tangent = np.einsum("k,ki->i", one_sided, np.array(positions)[:, 0])
            assert gradient[row] @ tangent == pytest.approx(change, abs=1e-9), name


def flat_points(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Radii that reach beyond both rims, and angles (rad)."""
    return RNG.uniform(INNER - 0.2, OUTER + 0.2, count), RNG.uniform(0, 2 * np.pi, count)


@pytest.mark.parametrize(
    "gap", [0.03, *(pytest.param(gap, marks=pytest.mark.slow) for gap in (0.0, -0.02))]
)
def test_location_on_a_flat_face(gap: float) -> None:
    part = body(ANNULUS)
    top = part.surfaces["top"]
    radius, angle = flat_points(2000)
    x = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(2000, TOP + gap)], 1)
    direction = np.broadcast_to(TILTED.rotation[:, 2], x.shape)
    found = top.locate(TILTED.apply(x), direction, 0.1)
    inside = (radius > INNER) & (radius < OUTER)
    np.testing.assert_array_equal(found.status == Status.INSIDE, inside)
    np.testing.assert_array_equal(found.missed, ~inside)
    assert np.abs(found.distance[inside] + gap).max() < 1e-14
    foot = TILTED.apply(np.column_stack([x[:, :2], np.full(2000, TOP)]))
    assert np.abs(top.position(found.at[inside]) - foot[inside]).max() < 1e-9
    off = np.maximum(INNER - radius, radius - OUTER)[~inside]
    assert (found.miss[~inside] >= off - 1e-9).all()


def test_location_of_edges_and_joints(ring: Body) -> None:
    angle = np.concatenate([np.linspace(0, 2 * np.pi, 33), [0, np.pi / 2, np.pi]])
    radius = np.concatenate([np.tile([INNER, OUTER], 17)[:33], [1.0, 1.1, 1.2]])
    x = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(36, TOP + 0.05)], 1)
    found = ring.surfaces["top"].locate(x, np.tile([0.0, 0.0, 1.0], (36, 1)), 0.1)
    assert (found.status == Status.EDGE).all()
    assert np.abs(found.distance + 0.05).max() < 1e-14


def test_reach_is_kept(ring: Body) -> None:
    x = np.array([[1.0, 0.3, TOP + 0.05]])
    up = np.array([[0.0, 0.0, 1.0]])
    assert ring.surfaces["top"].locate(x, up, 0.04).missed.all()
    assert not ring.surfaces["top"].locate(x, up, 0.06).missed.any()
    far = ring.surfaces["top"].locate(x + 10, up, 0.06)
    assert far.status[0] == Status.MISSED
    assert far.at.element[0] == -1
    assert np.isinf(far.miss[0])


def cylinder_distance(x: np.ndarray, d: np.ndarray, radius: float, reach: float) -> np.ndarray:
    """Signed distance along d to the nearer hit within height and reach; NaN where there is none.

    Roots s of |x + s d| = radius in the plane.
    """
    a = (d[:, :2] ** 2).sum(axis=1)
    b = (x[:, :2] * d[:, :2]).sum(axis=1)
    c = (x[:, :2] ** 2).sum(axis=1) - radius**2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b**2 - a * c)
    roots = np.stack([(-b - root) / a, (-b + root) / a], axis=1)
    height = x[:, 2:] + roots * d[:, 2:]
    valid = (height > BOTTOM) & (height < TOP) & (np.abs(roots) <= reach)
    roots = np.where(valid, roots, np.inf)
    nearest = np.take_along_axis(roots, np.abs(roots).argmin(axis=1)[:, None], axis=1)[:, 0]
    return np.where(np.isfinite(nearest), nearest, np.nan)


@pytest.mark.parametrize(
    ("name", "radius", "gap", "reach"),
    [
        ("outer", OUTER, 0.05, 0.2),
        ("outer", OUTER, -0.3, 0.8),
        ("inner", INNER, 0.04, 0.2),
        ("inner", INNER, -0.4, 1.0),
    ],
)
def test_location_on_a_cylinder(
    ring: Body, name: str, radius: float, gap: float, reach: float
) -> None:
    """Random oblique lines, 60 degrees at most from the radius, also past the rims."""
    n = 2500
    angle, height = RNG.uniform(0, 2 * np.pi, n), RNG.uniform(BOTTOM - 0.1, TOP + 0.1, n)
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    x = (radius + gap) * outward
    x[:, 2] = height
    direction = outward + 0.9 * RNG.uniform(-1, 1, (n, 3))
    direction *= (RNG.choice([-1, 1], n) / np.linalg.norm(direction, axis=1))[:, None]
    exact = cylinder_distance(x, direction, radius, reach)
    found = ring.surfaces[name].locate(x, direction, reach)
    np.testing.assert_array_equal(found.missed, np.isnan(exact))
    hit = ~found.missed
    assert hit.sum() > 800
    assert np.abs(found.distance[hit] - exact[hit]).max() < 1e-8
    on_surface = ring.surfaces[name].position(found.at[hit])
    line = x[hit] + found.distance[hit, None] * direction[hit]
    assert np.abs(on_surface - line).max() < 1e-8


def test_unknown_abscissae_and_bad_counts_are_refused(ring: Body) -> None:
    top: NurbsSurface = ring.surfaces["top"]
    with pytest.raises(InputError, match="one of greville"):
        top.abscissae("nodes")
    with pytest.raises(InputError, match="at least two"):
        top.grid(1)
    with pytest.raises(InputError, match="at least one"):
        top.gauss_points(0)


def test_mesh_size_is_that_of_the_largest_span() -> None:
    part = body(Box((3.0, 4.0, 1.0)), (1, 2, 1), (1, 1, 1), Placement())
    assert part.surfaces["z_max"].mesh_size == pytest.approx(np.hypot(3, 2))


@pytest.mark.parametrize("shape", [BOX, SECTOR, ANNULUS], ids=lambda shape: type(shape).__name__)
def test_grids_are_evaluated_as_scattered_points_are(shape: Shape) -> None:
    """Direction by direction, to rounding; so are normals and areas."""
    for surface in body(shape).surfaces.values():
        for face in surface.faces:
            parameters = tuple(np.linspace(k[0], k[-1], 7) for k in face.knots)
            xi = grid_points(parameters)
            pairs = zip(
                (*face.tangents_on(parameters), *face.normals_on(parameters)),
                (*face.tangents(xi), *face.normals(xi)),
                strict=True,
            )
            for found, expected in pairs:
                np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * 10)


def test_faces_go_on_beyond_their_edges_whatever_their_outermost_spans_are():
    tiny = np.array([0.0, 1e-5, 1e-3, 0.1, 0.5, 0.9, 1 - 1e-3, 1 - 1e-5, 1.0])
    low, high = np.array([INNER, START, BOTTOM]), np.array([OUTER, END, TOP])
    fine = [a + (b - a) * tiny for a, b in zip(low, high, strict=True)]
    refined, plain = (
        nurbs_body("part", data.patches, data.faces, degree, material=STEEL).surfaces["top"]
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
