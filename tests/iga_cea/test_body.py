"""NURBS bodies: closed forms, joints, boundary conditions, refusals."""

import numpy as np
import pytest
from bodies import nurbs_body
from covering import covering
from iga_data import STEEL, body, scipy_of, slow_matrices, turned
from petsc4py import PETSc
from scipy.linalg import eigh

from cea.body import Body
from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.supports.boundary import Pressure, Spring, Support
from iga_cea.multipatch import join
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Disc, Sector

ANNULUS = Annulus(0.8, 1.7, -0.1, 0.2)
SECTOR = Sector(0.8, 1.7, 20.0, 85.0, -0.1, 0.2)
BOX = Box((2.0, 1.0, 0.5))


def solve(matrix, load) -> np.ndarray:
    solution = load.duplicate()
    ksp = PETSc.KSP().create()
    ksp.setOperators(matrix)
    ksp.setType("preonly")
    ksp.getPC().setType("lu")
    ksp.solve(load, solution)
    return solution.getArray()


def displacement(part: Body) -> np.ndarray:
    """Static displacement of every control point."""
    free = PETSc.Vec().createWithArray(solve(part.stiffness(), part.load()))
    full = part.expansion.createVecLeft()
    part.expansion.mult(free, full)
    return full.getArray().reshape(-1, part.dim)


@pytest.mark.parametrize(
    "degree",
    [(3, 4, 2), *(pytest.param(q, marks=pytest.mark.slow) for q in ((1, 2, 1), (2, 2, 2)))],
)
def test_quarters_of_an_annulus_are_joined(degree: tuple[int, int, int]) -> None:
    part = body(ANNULUS, (3, 8, 2), degree)
    r, z = 3 + degree[0], 2 + degree[2]
    round_about = 4 * (2 + degree[1] - 1)
    assert part.num_scalar_dofs == r * round_about * z
    assert len(np.unique(np.round(part.dof_positions, 9), axis=0)) == part.num_scalar_dofs


@pytest.mark.parametrize(
    ("axes", "flip"), covering(((0, 1, 2), (1, 2, 0), (2, 1, 0)), (0, 1, 2), strength=1)
)
def test_joints_are_found_whatever_the_parameters(axes: tuple[int, ...], flip: int) -> None:
    """Two boxes side by side, the second turned and flipped: same spectrum as one box."""
    halves = [
        nurbs_shape(Box((1.0, 1.0, 0.5), (x, 0.0, 0.0)), breaks).patches[0]
        for x, breaks in (
            (0.0, ([0, 0.5, 1.0], [0, 0.3, 1.0], [0, 0.5])),
            (1.0, ([1, 1.5, 2.0], [0, 0.3, 1.0], [0, 0.5])),
        )
        for breaks in [tuple(np.asarray(b, dtype=float) for b in breaks)]
    ]
    straight = nurbs_body("part", halves, {}, (2, 2, 2), material=STEEL)
    other = turned(halves[1], axes, flip)
    mixed = nurbs_body("part", [halves[0], other], {}, (2, 2, 2), material=STEEL)
    assert mixed.num_scalar_dofs == straight.num_scalar_dofs == 7 * 4 * 3
    spectra = [
        eigh(scipy_of(b.stiffness()).toarray(), eigvals_only=True) for b in (straight, mixed)
    ]
    np.testing.assert_allclose(spectra[0], spectra[1], atol=1e-13 * spectra[0][-1])


def box_patch(origin, size, y=(0.0, 0.5, 1.0)) -> NurbsPatch:
    shape = Box(size, origin)
    ends = [np.array(e) for e in shape.extent]
    ends[1] = origin[1] + size[1] * np.asarray(y)
    return nurbs_shape(shape, tuple(ends)).patches[0]


@pytest.mark.parametrize(
    "neighbour",
    [
        box_patch((1.0, 0.0, 0.0), (1.0, 1.0, 1.0), y=(0.0, 0.4, 1.0)),
        box_patch((1.0, 0.0, 0.0), (1.0, 0.5, 1.0)),
        box_patch((1.0, 0.6, 0.0), (1.0, 1.0, 1.0)),
        box_patch((1.0, 0.3, -1.0), (1.0, 0.1, 3.0)),
        box_patch((1.0, -0.9, -0.9), (1.0, 1.0, 1.0)),
    ],
    ids=["other knots", "half the face", "shifted", "crossing", "overlapping corners"],
)
def test_patches_that_touch_but_do_not_conform_are_refused(neighbour: NurbsPatch) -> None:
    first = box_patch((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(InputError, match=r"patch 0 axis 0 side 1 and patch 1 axis 0 side 0"):
        nurbs_body("part", [first, neighbour], {}, (2, 2, 2), material=STEEL)


def test_patches_apart_or_sharing_an_edge_are_refused() -> None:
    first = box_patch((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    for origin in ((1.1, 0.0, 0.0), (1.0, 1.0, 0.0)):
        other = box_patch(origin, (1.0, 1.0, 1.0))
        with pytest.raises(InputError, match="2 bodies that share no face"):
            nurbs_body("part", [first, other], {}, (2, 2, 2), material=STEEL)


def test_thin_patches_are_not_taken_for_gaps_between_their_faces() -> None:
    """Two layers, a thousandth and less of their elements thick: one face of each is joined."""
    for thick in (1e-3, 1e-5):
        layers = [box_patch((0.0, 0.0, k * thick), (1.0, 1.0, thick)) for k in (0, 1)]
        part = nurbs_body("part", layers, {}, (2, 2, 2), material=STEEL)
        assert part.num_scalar_dofs == 2 * 3 * 4 * 3 - 3 * 4


def test_column_on_springs_is_exact() -> None:
    part = body(
        BOX,
        (2, 2, 3),
        (2, 2, 2),
        Placement(),
        material=IsotropicMaterial(E=2.0, nu=0.0),
        springs=[Spring("z_min", (3.0, 4.0, 5.0))],
        pressures=[Pressure("z_max", 0.7)],
    )
    exact = np.zeros_like(part.dof_positions)
    exact[:, 2] = -0.7 / 5.0 - 0.7 / 2.0 * part.dof_positions[:, 2]
    np.testing.assert_allclose(displacement(part), exact, atol=1e-13)


def test_supports_hold_components_of_whole_surfaces() -> None:
    part = body(ANNULUS, (2, 8, 2), (2, 2, 2), supports=[Support("inner", (0, 2))])
    Z = scipy_of(part.expansion)
    held = 4 * 3 * 4 * 2
    full = 3 * part.num_scalar_dofs
    assert Z.shape == (full, full - held)
    assert part.stiffness().getSize() == part.mass().getSize() == (full - held,) * 2
    unheld = scipy_of(body(ANNULUS, (2, 8, 2), (2, 2, 2)).stiffness())
    assert abs(Z.T @ unheld @ Z - scipy_of(part.stiffness())).max() == 0
    motion = (Z @ np.ones(Z.shape[1])).reshape(-1, 3)
    dofs = part.surfaces["inner"].dofs
    np.testing.assert_array_equal(motion[dofs], np.tile([0, 1, 0], (len(dofs), 1)))


@pytest.mark.convergence
@pytest.mark.parametrize("degree", [2, 3])
def test_first_frequency_converges_at_twice_the_degree(degree: int) -> None:
    """A bar held laterally, nu = 0: kappa = (pi / 2L)^2 E / rho."""
    rollers = [Support("x_min", (0,))] + [
        Support(f"{axis}_{end}", (c,)) for c, axis in ((1, "y"), (2, "z")) for end in ("min", "max")
    ]
    counts = np.array([2, 4, 8]) if degree == 2 else np.array([4, 6, 8])
    errors = []
    for n in counts:
        part = body(
            BOX,
            (int(n), 1, 1),
            (degree, 1, 1),
            Placement(),
            material=IsotropicMaterial(E=2.0, nu=0.0, rho=3.0),
            supports=rollers,
        )
        K, M = scipy_of(part.stiffness()).toarray(), scipy_of(part.mass()).toarray()
        exact = (np.pi / 4) ** 2 * 2.0 / 3.0
        errors.append(eigh(K, M, eigvals_only=True)[0] / exact - 1)
    rate = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert rate == pytest.approx(2 * degree, abs=0.2)
    assert 0 < errors[-1] < 1e-5


def test_volume_sample_fills_the_body() -> None:
    part = body(ANNULUS, (2, 16, 2), (2, 2, 2), Placement())
    sample = part.volume_sample(6)
    assert np.abs(sample.values @ part.dof_positions - sample.points).max() < 1e-15
    assert np.abs(sample.values.sum(axis=1) - 1).max() < 1e-15
    radius = np.linalg.norm(sample.points[:, :2], axis=1)
    assert radius.min() == pytest.approx(0.8, abs=1e-14)
    assert radius.max() == pytest.approx(1.7, abs=1e-14)
    corners = sample.points[sample.cells]
    edges = [corners[:, k] - corners[:, 0] for k in (1, 3, 4)]
    volume = np.einsum("ni,ni->n", np.cross(edges[0], edges[1]), edges[2])
    assert volume.min() > 0
    assert volume.sum() == pytest.approx(np.pi * (1.7**2 - 0.8**2) * 0.3, rel=0.05)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"degree": (2, 1, 2)}, r"bodies.part.degree = \(2, 1, 2\): at least \(1, 2, 1\)"),
        ({"degree": (2, 9, 2)}, "whole numbers from 1 to 8"),
        ({"degree": (2, 2)}, "3 whole numbers"),
        ({"continuity": (2, 1, 1)}, "bodies.part.continuity"),
        ({"supports": [Support("side", (0,))]}, r"supports\[0\].surface = 'side': one of .*outer"),
        ({"springs": [Spring("top", (1.0, 2.0))]}, r"springs\[0\].stiffness"),
        ({"pressures": [Pressure("tpo", 1.0)]}, r"pressures\[0\].surface = 'tpo'"),
    ],
)
def test_wrong_input_is_refused(options: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        body(SECTOR, (1, 1, 1), options.pop("degree", (2, 2, 2)), **options)


@pytest.mark.parametrize("corner", [(-0.9, -0.8, -0.7), (0.5, 0.5, 1.0)], ids=["folded", "flat"])
def test_folded_and_flat_patches_are_refused(corner: tuple[float, ...]) -> None:
    patch = box_patch((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    patch.control_points[1, 1, 1] = corner
    with pytest.raises(InputError, match="neither folded nor collapsed"):
        nurbs_body("part", [patch], {}, (1, 1, 1), material=STEEL)


def test_a_patch_without_thickness_is_refused() -> None:
    patch = box_patch((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    patch.control_points[..., 2] = 0.0
    with pytest.raises(InputError, match="neither folded nor collapsed"):
        nurbs_body("part", [patch], {}, (1, 1, 1), material=STEEL)


@pytest.mark.parametrize("edge", [(1, 1, slice(None)), (slice(None), 0, 1), (0, slice(None), 0)])
def test_a_collapsed_edge_is_one_dof(edge: tuple) -> None:
    """Any edge of a box drawn together to its middle: matrices exact, six rigid motions."""
    patch = box_patch((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    patch.control_points[edge] = patch.control_points[edge].mean(axis=0)
    part = nurbs_body("part", [patch], {}, (2, 2, 1), material=STEEL)
    along = next(k for k in range(3) if isinstance(edge[k], slice))
    counts = (3, 4, 2)
    assert part.num_scalar_dofs == np.prod(counts) - counts[along] + 1
    for ours, slow in zip((part.stiffness(), part.mass()), slow_matrices(part), strict=True):
        assert np.abs(scipy_of(ours).toarray() - slow).max() <= 1e-13 * np.abs(slow).max()
    values = eigh(scipy_of(part.stiffness()).toarray(), eigvals_only=True)
    assert values[5] < 1e-12 * values[-1] < values[6]


def test_a_collapsed_face_is_no_surface() -> None:
    disc = nurbs_shape(Disc(1.0, 0.0, 0.2), breaks_of(Disc(1.0, 0.0, 0.2), (1, 4, 1)))
    with pytest.raises(InputError, match=r"faces.axis = \(0, 0, 0\): faces that are not"):
        nurbs_body("part", disc.patches, {"axis": [(0, 0, 0)]}, (2, 2, 1), material=STEEL)


def test_cells_of_a_left_handed_patch_are_not_inverted() -> None:
    patch = box_patch((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    mirrored = turned(patch, (0, 1, 2), 1)
    for given in (patch, mirrored):
        part = nurbs_body("part", [given], {}, (2, 1, 1), material=STEEL)
        sample = part.volume_sample(2)
        corners = sample.points[sample.cells]
        assert np.linalg.det(corners[:, [1, 3, 4]] - corners[:, :1]).min() > 0


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_two_ranks_share_out_the_layers_of_functions_evenly(degree):
    patches = body(BOX, (12, 3, 2), (degree,) * 3).space.multipatch.patches
    ranges = join(patches, 2, "patches").dof_ranges
    layer = ranges[-1] / (12 + degree)
    assert np.ptp(np.diff(ranges)) <= layer
