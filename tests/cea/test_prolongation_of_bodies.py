"""Prolongation of bodies of both backends: coarse functions are kept at any point."""

from dataclasses import replace

import numpy as np
import pytest
from bodies import PLASTIC, lagrange_body, nurbs_body
from dolfinx.fem import Function, functionspace
from dolfinx.geometry import bb_tree, compute_colliding_cells, compute_collisions_points
from iga_data import TURNED, basis_on_grid, body, turned
from lagrange_bodies import FLAT, ROUND, SPACE, body_of
from petsc_matrices import to_scipy

from cea.errors import InputError
from cea.nested.prolongation import of_body as prolongation
from cea.supports.boundary import Support
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box, Disc, Hub, Rectangle, Ring, Sector

RNG = np.random.default_rng(11)
HUB = Hub(0.3, 0.8, 1.7, -0.1, 0.1, -0.1, 0.3)
PLATE = Rectangle((1.0, 0.8))
SLOW = pytest.mark.slow


def on_grid(part, u, patch, parameters):
    """Displacement of a NURBS body at the points of a grid in one patch, (points, dim)."""
    basis = basis_on_grid(part.space.multipatch.patches[patch], parameters)
    return basis @ u.reshape(-1, part.dim)[part.space.multipatch.dofs[patch].ravel()]


def at_points(part, u, x):
    """Displacement of a Lagrange body at points by dolfinx."""
    scalar = part.space.scalar
    mesh = scalar.mesh
    f = Function(functionspace(mesh, ("Lagrange", scalar.ufl_element().degree, (part.dim,))))
    f.x.array[:] = u
    padded = np.zeros((len(x), 3))
    padded[:, : part.dim] = x
    near = compute_collisions_points(bb_tree(mesh, mesh.topology.dim, padding=1e-12), padded)
    cells = compute_colliding_cells(mesh, near, padded)
    return f.eval(padded, [cells.links(i)[0] for i in range(len(x))])


def inside(part, count=60):
    """Random points within the cells of a body."""
    sample = part.space.volume_cells().straight()
    share = RNG.dirichlet(np.ones(sample.cells.shape[1]), count)
    cells = sample.cells[RNG.integers(len(sample.cells), size=count)]
    return np.einsum("nk,nki->ni", share, sample.points[cells])


def apart(coarse, fine, step, u):
    """Largest difference of coarse displacements of free dofs and their prolongation."""
    one = to_scipy(coarse.expansion) @ u
    other = to_scipy(fine.expansion) @ (to_scipy(step) @ u)
    if not hasattr(coarse.space, "multipatch"):
        x = inside(coarse)
        return np.abs(at_points(fine, other, x) - at_points(coarse, one, x)).max()
    worst = 0.0
    for patch in range(len(coarse.space.multipatch.patches)):
        at = [RNG.uniform(0, 1, 5) for _ in range(coarse.dim)]
        difference = on_grid(fine, other, patch, at) - on_grid(coarse, one, patch, at)
        worst = max(worst, np.abs(difference).max())
    return worst


def divided(cell, degree, **options):
    """Boxes of a Lagrange body, and the same divided."""
    return [body_of(FLAT, cell, degree, elements=n, **options) for n in ((2, 1, 1), (4, 3, 2))]


def refined(shape, coarse, fine):
    """A NURBS body by its elements, degrees and continuity, and another of the same shape."""
    return [body(shape, n, degree, continuity=c) for n, degree, c in (coarse, fine)]


def odd():
    """Two patches whose parameters lie otherwise, held on top; and the same refined."""
    shapes = [Sector(0.8, 1.7, a, b, -0.1, 0.2) for a, b in ((10.0, 60.0), (60.0, 95.0))]
    options = {"material": PLASTIC, "supports": [Support("top")]}
    faces = {"top": [(0, 2, 1), (1, 1, 1)]}
    pair = []
    for n, degree, continuity in ((2, 2, None), (4, 3, (1, 1, 1))):
        one, other = (nurbs_shape(s, breaks_of(s, (n,) * 3)).patches[0] for s in shapes)
        patches = [one, turned(other, (1, 2, 0), 0)]
        made = nurbs_body("odd", patches, faces, (degree,) * 3, continuity=continuity, **options)
        pair.append(made)
    return pair


HELD = [Support("z_min", ("x", "z")), Support("x_max")]
PAIRS = {
    "Q1 plane": lambda: divided("quadrilateral", 1),
    "Q2 plane": lambda: divided("quadrilateral", 2),
    "Q4 plane": lambda: divided("quadrilateral", 4),
    "Q1": lambda: divided("hexahedron", 1),
    "Q2": lambda: divided("hexahedron", 2),
    "Q2 held": lambda: divided("hexahedron", 2, supports=HELD),
    "Q4": lambda: divided("hexahedron", 4),
    "plate": lambda: refined(PLATE, ((2, 3), (2, 2), None), ((4, 6), (2, 2), None)),
    "rough": lambda: refined(PLATE, ((2, 3), (1, 3), (0, 1)), ((4, 3), (3, 4), (0, 0))),
    "high": lambda: refined(PLATE, ((2, 3), (2, 3), None), ((2, 3), (7, 8), (1, 2))),
    "ring": lambda: refined(Ring(0.8, 1.7), ((2, 8), (2, 3), None), ((6, 16), (2, 4), (1, 2))),
    "box": lambda: refined(
        Box((1.0, 0.8, 0.5)), ((2, 1, 2), (2, 2, 1), None), ((4, 3, 2), (3, 2, 2), (1, 1, 0))
    ),
    "disc": lambda: refined(
        Disc(1.7, -0.1, 0.2), ((2, 8, 1), (2, 2, 2), None), ((4, 8, 2), (3, 3, 2), (1, 1, 1))
    ),
    "hub": lambda: refined(HUB, ((2, 4, 2), (2, 2, 1), None), ((2, 4, 4), (2, 3, 1), (1, 1, 0))),
    "odd": odd,
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=SLOW) if n in ("Q4", "hub") else n for n in PAIRS]
)
def test_coarse_functions_stay_what_they_are(name):
    coarse, fine = PAIRS[name]()
    step = prolongation(coarse, fine)
    P = to_scipy(step)
    assert P.shape == (fine.expansion.getSize()[1], coarse.expansion.getSize()[1])
    assert apart(coarse, fine, step, RNG.uniform(-1, 1, P.shape[1])) < 1e-12
    if name.startswith("Q"):  # where quadrature is exact
        for matrix in ("stiffness", "mass"):
            wanted, whole = (to_scipy(getattr(part, matrix)()) for part in (coarse, fine))
            assert abs(P.T @ whole @ P - wanted).max() < 1e-12 * abs(wanted).max()


def test_curved_cells_of_one_geometry():
    coarse, fine = (body_of(ROUND, "hexahedron", q, order=2) for q in (2, 3))
    step = prolongation(coarse, fine)
    P = to_scipy(step)
    u = RNG.uniform(-1, 1, P.shape[1])
    for name, surface in fine.surfaces.items():
        points = surface.gauss_points(3)
        found = surface.trace(points.at) @ (P @ u).reshape(-1, 3)
        at = coarse.surfaces[name].locate(points.x, points.normal, 1e-3).at
        expected = coarse.surfaces[name].trace(at) @ u.reshape(-1, 3)
        assert np.abs(found - expected).max() < 1e-12


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
