"""Prolongation of bodies of both backends: coarse functions are kept at any point."""

from dataclasses import replace

import numpy as np
import pytest
from bodies import FLAT, PLASTIC, ROUND, SPACE, body_of, lagrange_body
from iga_data import TURNED, basis_on_grid, body, two_sectors
from petsc_matrices import to_scipy

from cea.errors import InputError
from cea.nested.prolongation import of_body as prolongation
from cea.supports.boundary import Support
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Disc, Hub, Rectangle, Ring

RNG = np.random.default_rng(11)
HUB = Hub(0.3, 0.8, 1.7, -0.1, 0.1, -0.1, 0.3)
PLATE = Rectangle((1.0, 0.8))
SLOW = pytest.mark.slow


def on_grid(part, u, patch, parameters):
    """Displacement of a NURBS body at the points of a grid in one patch, (points, dim)."""
    basis = basis_on_grid(part.space.multipatch.patches[patch], parameters)
    return basis @ u.reshape(-1, part.dim)[part.space.multipatch.dofs[patch].ravel()]


def apart(coarse, fine, u, moved):
    """Largest difference of displacements of all dofs, on surfaces or in NURBS patches."""
    differences = []
    if hasattr(coarse.space, "multipatch"):
        for patch in range(len(coarse.space.multipatch.patches)):
            at = [RNG.uniform(0, 1, 5) for _ in range(coarse.dim)]
            differences.append(on_grid(fine, moved, patch, at) - on_grid(coarse, u, patch, at))
    else:
        for name, surface in fine.surfaces.items():
            points, own = surface.gauss_points(3), coarse.surfaces[name]
            found = surface.trace(points.at) @ moved.reshape(-1, fine.dim)
            at = own.locate(points.x, points.normal, 1e-3).at
            differences.append(found - own.trace(at) @ u.reshape(-1, fine.dim))
    return max(np.abs(each).max() for each in differences)


def divided(cell, degree, **options):
    """Boxes of a Lagrange body, and the same divided."""
    return [body_of(FLAT, cell, degree, elements=n, **options) for n in ((2, 1, 1), (4, 3, 2))]


def refined(shape, coarse, fine):
    """A NURBS body by its elements, degrees and continuity, and another of the same shape."""
    return [body(shape, n, degree, continuity=c) for n, degree, c in (coarse, fine)]


def odd():
    """Two patches whose parameters lie otherwise, held on top; and the same refined."""
    options = {"supports": [Support("top")], "faces": {"top": [(0, 2, 1), (1, 1, 1)]}}
    return [
        two_sectors((n,) * 3, (q,) * 3, (1, 2, 0), 0, continuity=continuity, **options)
        for n, q, continuity in ((2, 2, None), (4, 3, (1, 1, 1)))
    ]


HELD = [Support("z_min", ("x", "z")), Support("x_max")]
PAIRS = {
    "Q2 plane": lambda: divided("quadrilateral", 2),
    "Q2 held": lambda: divided("hexahedron", 2, supports=HELD),
    "Q4": lambda: divided("hexahedron", 4),
    "curved": lambda: [body_of(ROUND, "hexahedron", degree, order=2) for degree in (2, 3)],
    "rough": lambda: refined(PLATE, ((2, 3), (1, 3), (0, 1)), ((4, 3), (3, 4), (0, 0))),
    "high": lambda: refined(PLATE, ((2, 3), (2, 3), None), ((2, 3), (7, 8), (1, 2))),
    "disc": lambda: refined(
        Disc(1.7, -0.1, 0.2), ((1, 8, 1), (2, 2, 2), None), ((2, 16, 2), (3, 3, 2), (1, 1, 1))
    ),
    "hub": lambda: refined(HUB, ((2, 4, 2), (2, 2, 1), None), ((2, 4, 4), (2, 3, 1), (1, 1, 0))),
    "odd": odd,
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=SLOW) if n in ("Q4", "hub") else n for n in PAIRS]
)
def test_coarse_functions_stay_what_they_are(name):
    """On surfaces and in patches; where quadrature is exact, in energy and mass too."""
    coarse, fine = PAIRS[name]()
    P = to_scipy(prolongation(coarse, fine))
    assert P.shape == (fine.expansion.getSize()[1], coarse.expansion.getSize()[1])
    u = RNG.uniform(-1, 1, P.shape[1])
    whole, moved = (to_scipy(p.expansion) @ v for p, v in ((coarse, u), (fine, P @ u)))
    assert apart(coarse, fine, whole, moved) < 1e-12
    if name.startswith("Q"):
        for matrix in ("stiffness", "mass"):
            wanted, found = (to_scipy(getattr(part, matrix)()) for part in (coarse, fine))
            assert abs(P.T @ found @ P - wanted).max() < 1e-12 * abs(wanted).max()


def test_a_higher_continuity_is_met_at_full_order():
    """A smooth coarse function between spaces that are not nested: errors fall like h^(q + 1)."""
    errors = []
    for n in (8, 16, 32):
        coarse, fine = (body(PLATE, (n, 2), (q, 2), placement=TURNED) for q in (2, 3))
        step = prolongation(coarse, fine)
        at = [np.linspace(0, 1, 201), np.array([0.0, 0.3, 0.7, 1.0])]
        x = on_grid(coarse, coarse.space.dof_positions, 0, at)
        basis = basis_on_grid(coarse.space.multipatch.patches[0], at).toarray()
        u = np.zeros_like(coarse.space.dof_positions)
        u[coarse.space.multipatch.dofs[0].ravel()] = np.linalg.lstsq(basis, np.sin(3 * x))[0]
        moved = to_scipy(step) @ u.ravel()
        errors.append(np.abs(on_grid(fine, moved, 0, at) - on_grid(coarse, u, 0, at)).max())
    assert -np.polyfit(np.log([8, 16, 32]), np.log(errors), 1)[0] == pytest.approx(3, abs=0.2)


def test_another_body_is_refused():
    coarse = body_of(FLAT, "hexahedron", 1, elements=(2, 2, 2))
    far = shape_mesh(FLAT[3], "hexahedron", 1, breaks=[np.array([0, e]) for e in (1.0, 0.8, 0.5)])
    far = replace(far, points=SPACE.apply(far.points) + 5.0)
    ring = body(Ring(0.8, 1.7), (2, 8), (2, 2))
    for one, other, told in (
        (coarse, lagrange_body("part", far, degree=1, material=PLASTIC), r"mesh = .* cells apart"),
        (ring, body(PLATE, (2, 8), (2, 2)), "patches = '1 in 2 dimensions': 4 in 2"),
        (ring, body(Ring(0.9, 1.7), (2, 8), (2, 2)), "the same body in both"),
    ):
        with pytest.raises(InputError, match=told):
            prolongation(one, other)
