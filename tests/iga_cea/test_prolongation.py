"""Prolongation of NURBS: coarse functions are kept at any point, matrices by P^T A P."""

import numpy as np
import pytest
from bodies import nurbs_body
from iga_data import TURNED, basis_on_grid, body, turned
from petsc_matrices import to_scipy

from cea.errors import InputError
from cea.nested.prolongation import of_body as prolongation
from cea.nested.prolongation import varied_coefficients
from cea.supports.boundary import Support
from cea.supports.frames import SurfaceNormal
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.shapes import Box, Disc, Hub, Rectangle, Ring, Sector

RNG = np.random.default_rng(11)
HUB = Hub(0.3, 0.8, 1.7, -0.1, 0.1, -0.1, 0.3)


def values(part, u, patch, parameters):
    """Displacement at the points of a random grid in one patch, (points, dim)."""
    basis = basis_on_grid(part.space.multipatch.patches[patch], parameters)
    return basis @ u.reshape(-1, part.dim)[part.space.multipatch.dofs[patch].ravel()]


@pytest.mark.parametrize(
    ("shape", "coarse", "fine"),
    [
        (Rectangle((1.0, 0.8)), ((2, 3), (2, 2), None), ((4, 6), (2, 2), None)),
        (Rectangle((1.0, 0.8)), ((2, 3), (1, 3), (0, 1)), ((4, 3), (3, 4), (0, 0))),
        (Rectangle((1.0, 0.8)), ((2, 3), (2, 3), None), ((2, 3), (7, 8), (1, 2))),
        (Ring(0.8, 1.7), ((2, 8), (2, 3), None), ((6, 16), (2, 4), (1, 2))),
        (Box((1.0, 0.8, 0.5)), ((2, 1, 2), (2, 2, 1), None), ((4, 3, 2), (3, 2, 2), (1, 1, 0))),
        (Disc(1.7, -0.1, 0.2), ((2, 8, 1), (2, 2, 2), None), ((4, 8, 2), (3, 3, 2), (1, 1, 1))),
        pytest.param(
            HUB,
            ((2, 4, 2), (2, 2, 1), None),
            ((2, 4, 4), (2, 3, 1), (1, 1, 0)),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_coarse_functions_stay_what_they_are(shape, coarse, fine):
    one, other = (
        body(shape, n, degree, continuity=continuity) for n, degree, continuity in (coarse, fine)
    )
    step = prolongation(one, other)
    assert step.defect < 1e-10
    u = RNG.uniform(-1, 1, one.dim * one.num_scalar_dofs)
    prolonged = to_scipy(step.matrix) @ u
    for patch in range(len(one.space.multipatch.patches)):
        at = [RNG.uniform(0, 1, 5) for _ in range(one.dim)]
        difference = values(other, prolonged, patch, at) - values(one, u, patch, at)
        assert np.abs(difference).max() < 1e-12


def test_patches_whose_parameters_lie_otherwise():
    shapes = [Sector(0.8, 1.7, a, b, -0.1, 0.2) for a, b in ((10.0, 60.0), (60.0, 95.0))]

    def part(elements, degree, continuity):
        one, other = (nurbs_shape(s, breaks_of(s, elements)).patches[0] for s in shapes)
        return nurbs_body(
            "odd",
            [one, turned(other, (1, 2, 0), 0)],
            {"top": [(0, 2, 1), (1, 1, 1)]},
            degree,
            continuity=continuity,
            material=body(shapes[0], (1, 1, 1), (2, 2, 2)).material,
            supports=[Support("top")],
        )

    coarse, fine = part((2, 2, 2), (2, 2, 2), None), part((4, 4, 4), (3, 3, 3), (1, 1, 1))
    step = prolongation(coarse, fine)
    assert step.defect < 1e-10
    u = varied_coefficients(step.matrix.getSize()[1])
    full = [to_scipy(b.expansion) @ v for b, v in ((coarse, u), (fine, to_scipy(step.matrix) @ u))]
    for patch in (0, 1):
        at = [RNG.uniform(0, 1, 4) for _ in range(3)]
        apart = values(fine, full[1], patch, at) - values(coarse, full[0], patch, at)
        assert np.abs(apart).max() < 1e-12


def test_a_higher_continuity_is_met_at_full_order():
    """A smooth coarse function between spaces that are not nested: errors fall like h^(q + 1)."""
    errors = []
    for n in (8, 16, 32):
        coarse, fine = (
            body(Rectangle((1.0, 0.8)), (n, 2), (q, 2), placement=TURNED) for q in (2, 3)
        )
        step = prolongation(coarse, fine)
        assert step.defect > 1e-10
        at = [np.linspace(0, 1, 201), np.array([0.0, 0.3, 0.7, 1.0])]
        x = values(coarse, coarse.space.dof_positions, 0, at)
        basis = basis_on_grid(coarse.space.multipatch.patches[0], at).toarray()
        u = np.zeros_like(coarse.space.dof_positions)
        u[coarse.space.multipatch.dofs[0].ravel()] = np.linalg.lstsq(basis, np.sin(3 * x))[0]
        apart = values(fine, to_scipy(step.matrix) @ u.ravel(), 0, at) - values(coarse, u, 0, at)
        errors.append(np.abs(apart).max())
    assert -np.polyfit(np.log([8, 16, 32]), np.log(errors), 1)[0] == pytest.approx(3, abs=0.2)


def test_supports_that_turn_along_a_face_are_told():
    """Radial rollers on a round rim are projected on each trace space: no function is common."""
    supports = [Support("inner", (0,))]
    plain = body(Ring(0.8, 1.7), (2, 8), (2, 2), supports=supports)
    fine = body(Ring(0.8, 1.7), (4, 16), (2, 2), supports=supports)
    assert prolongation(plain, fine).defect < 1e-10
    rollers = [Support("inner", (0,), SurfaceNormal())]
    coarse, fine = (body(Ring(0.8, 1.7), (n, 4 * n), (2, 2), supports=rollers) for n in (2, 4))
    defect = prolongation(coarse, fine).defect
    assert 1e-6 < defect < 1


def test_another_body_is_refused():
    coarse = body(Ring(0.8, 1.7), (2, 8), (2, 2))
    with pytest.raises(InputError, match="patches = '1 in 2 dimensions': 4 in 2"):
        prolongation(coarse, body(Rectangle((1.0, 0.8)), (2, 8), (2, 2)))
    with pytest.raises(InputError, match="one body in both"):
        prolongation(coarse, body(Ring(0.9, 1.7), (2, 8), (2, 2)))
