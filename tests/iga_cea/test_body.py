"""NURBS bodies: joints, collapsed edges and axes, plate theory, refusals."""

import numpy as np
import pytest
from bodies import nurbs_body
from covering import covering
from iga_data import STEEL, TILTED, body, slow_matrices, turned
from petsc_matrices import to_scipy
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from cea.errors import InputError
from cea.material import IsotropicMaterial
from cea.supports.boundary import Support
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.shapes import Box, Disc, Sector

SECTOR = Sector(0.8, 1.7, 20.0, 85.0, -0.1, 0.2)
DISC = Disc(1.2, -0.1, 0.2)


def box_patch(x=0.0, y=0.0, z=0.0, size=(1.0, 1.0, 1.0), between=(0.5,)) -> NurbsPatch:
    """A patch of a box with breaks along y between its ends."""
    shape = Box(size, (x, y, z))
    ends = [np.array(e) for e in shape.extent]
    ends[1] = y + size[1] * np.array([0.0, *between, 1.0])
    return nurbs_shape(shape, tuple(ends))[0][0]


def joined(*patches, degree=(2, 2, 2)):
    return nurbs_body("part", patches, {}, degree, material=STEEL)


@pytest.mark.parametrize(
    ("axes", "flip"), covering(((0, 1, 2), (1, 2, 0), (2, 1, 0)), (0, 1, 2), strength=1)
)
def test_joints_are_found_whatever_the_parameters(axes: tuple[int, ...], flip: int) -> None:
    """Two boxes side by side, the second turned and flipped: same spectrum as one box."""
    first, second = (
        nurbs_shape(Box((1.0, 1.0, 0.5), (x, 0.0, 0.0)), (x + halves, thirds, ends))[0][0]
        for halves, thirds, ends in [map(np.array, ([0, 0.5, 1.0], [0, 0.3, 1.0], [0, 0.5]))]
        for x in (0.0, 1.0)
    )
    straight, mixed = joined(first, second), joined(first, turned(second, axes, flip))
    assert mixed.num_scalar_dofs == straight.num_scalar_dofs == 7 * 4 * 3
    spectra = [
        eigh(to_scipy(b.stiffness()).toarray(), eigvals_only=True) for b in (straight, mixed)
    ]
    np.testing.assert_allclose(spectra[0], spectra[1], atol=1e-13 * spectra[0][-1])


UNLIKE = r"patch 0 axis 0 side 1 and patch 1 axis 0 side 0"


@pytest.mark.parametrize(
    ("neighbour", "message"),
    [
        pytest.param(box_patch(1.0, between=(0.4,)), UNLIKE, id="other knots"),
        pytest.param(box_patch(1.0, size=(1.0, 0.5, 1.0)), UNLIKE, id="half the face"),
        pytest.param(box_patch(1.0, -0.9, -0.9), UNLIKE, id="overlapping corners"),
        pytest.param(box_patch(1.1), "2 bodies that share no face", id="apart"),
        pytest.param(box_patch(1.0, 1.0), "2 bodies that share no face", id="sharing an edge"),
    ],
)
def test_patches_that_do_not_conform_are_refused(neighbour: NurbsPatch, message: str) -> None:
    with pytest.raises(InputError, match=message):
        joined(box_patch(), neighbour)


@pytest.mark.parametrize("thick", [1e-3, 1e-5])
def test_thin_patches_are_not_taken_for_gaps_between_their_faces(thick: float) -> None:
    """Two layers, a thousandth and less of their elements thick: one face of each is joined."""
    part = joined(*(box_patch(z=k * thick, size=(1.0, 1.0, thick)) for k in (0, 1)))
    assert part.num_scalar_dofs == 2 * 3 * 4 * 3 - 3 * 4


def test_degrees_below_that_of_the_geometry_are_refused() -> None:
    told = r"bodies.part.degree = \(2, 1, 2\): at least \(1, 2, 1\)"
    with pytest.raises(InputError, match=told):
        body(SECTOR, (1, 1, 1), degree=(2, 1, 2))


@pytest.mark.parametrize(
    ("place", "points"),
    [
        pytest.param((1, 1, 1), (-0.9, -0.8, -0.7), id="folded"),
        pytest.param((..., 2), 0.0, id="without thickness"),
    ],
)
def test_folded_and_flat_patches_are_refused(place, points) -> None:
    patch = box_patch()
    patch.control_points[place] = points
    with pytest.raises(InputError, match="neither folded nor collapsed"):
        joined(patch, degree=(1, 1, 1))


@pytest.mark.parametrize("edge", [(1, 1, slice(None)), (slice(None), 0, 1), (0, slice(None), 0)])
def test_a_collapsed_edge_is_one_dof(edge: tuple) -> None:
    """Any edge of a box drawn together to its middle: matrices exact, six rigid motions."""
    patch = box_patch()
    patch.control_points[edge] = patch.control_points[edge].mean(axis=0)
    part = joined(patch, degree=(2, 2, 1))
    along = next(k for k in range(3) if isinstance(edge[k], slice))
    counts = (3, 4, 2)
    assert part.num_scalar_dofs == np.prod(counts) - counts[along] + 1
    for ours, slow in zip((part.stiffness(), part.mass()), slow_matrices(part), strict=True):
        assert np.abs(to_scipy(ours).toarray() - slow).max() <= 1e-13 * np.abs(slow).max()
    values = eigh(to_scipy(part.stiffness()).toarray(), eigvals_only=True)
    assert values[5] < 1e-12 * values[-1] < values[6]


def test_location_about_the_axis() -> None:
    rng = np.random.default_rng(3)
    radius = np.repeat([0.0, 1e-9, 0.1], 300)
    r, angle = radius * rng.random(900), rng.uniform(0, 2 * np.pi, 900)
    x = np.stack([r * np.cos(angle), r * np.sin(angle), np.full(900, 0.25)], axis=1)
    top = body(DISC, (2, 4, 1), (2, 3, 2)).surfaces["top"]
    up = np.broadcast_to(TILTED.rotation[:, 2], x.shape)
    found = top.locate(TILTED.apply(x), up, 0.1)
    assert not found.missed.any()
    assert np.abs(found.distance + 0.05).max() < 1e-14
    foot = TILTED.apply(x - [0, 0, 0.05])
    assert np.abs(top.position(found.at) - foot).max() < 1e-8


@pytest.mark.slow
def test_clamped_thin_disc_against_plate_theory() -> None:
    """Frequencies a^2 sqrt(rho h / D) omega of a clamped plate (Leissa, Vibration of Plates).

    Shear and rotary inertia, which plate theory leaves out, lower them by some (h / a)^2. Elements
    at the rim resolve the layer, as thick as the plate, where the clamp holds back Poisson strain.
    """
    h, material = 0.01, IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
    shape = Disc(1.0, -h / 2, h / 2)
    patches, faces = nurbs_shape(
        shape, breaks_of(shape, (12, 16, 1), {"r": [0.95, 0.97, 0.985, 0.995]})
    )
    options = {"material": material, "supports": [Support("outer")]}
    part = nurbs_body("disc", patches, {"outer": faces["outer"]}, (4, 4, 3), **options)
    K, M = to_scipy(part.stiffness()).tocsc(), to_scipy(part.mass()).tocsc()
    kappa = np.sort(eigsh(K, 6, M, sigma=0, return_eigenvectors=False))
    rigidity = 2.0 * h**3 / (12 * (1 - 0.3**2))
    numbers = np.sqrt(kappa * 1.5 * h / rigidity)
    leissa = [10.2158, 21.26, 21.26, 34.88, 34.88, 39.771]
    np.testing.assert_allclose(numbers, leissa, rtol=1e-3)
    assert numbers[2] - numbers[1] < 1e-6 * numbers[1]
