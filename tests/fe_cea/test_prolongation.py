"""Prolongation of Lagrange bodies: coarse functions are kept at any point, matrices by P^T A P."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from bodies import lagrange_body
from dolfinx.fem import Function, functionspace
from dolfinx.geometry import bb_tree, compute_colliding_cells, compute_collisions_points
from lagrange_bodies import FLAT, MATERIAL, ROUND, SPACE, body_of
from petsc_matrices import to_scipy

from cea.errors import InputError
from cea.nested.prolongation import of_body as prolongation
from cea.supports.boundary import Support
from meshes.shape_mesh import shape_mesh

RNG = np.random.default_rng(12)


def values(body, u, x):
    """Displacement at points by dolfinx."""
    scalar = body.space.scalar
    mesh = scalar.mesh
    f = Function(functionspace(mesh, ("Lagrange", scalar.ufl_element().degree, (body.dim,))))
    f.x.array[:] = u
    padded = np.zeros((len(x), 3))
    padded[:, : body.dim] = x
    near = compute_collisions_points(bb_tree(mesh, mesh.topology.dim, padding=1e-12), padded)
    cells = compute_colliding_cells(mesh, near, padded)
    return f.eval(padded, [cells.links(i)[0] for i in range(len(x))])


def inside(body, count=60):
    """Random points within the cells of a body."""
    sample = body.space.volume_cells().straight()
    share = RNG.dirichlet(np.ones(sample.cells.shape[1]), count)
    cells = sample.cells[RNG.integers(len(sample.cells), size=count)]
    return np.einsum("nk,nki->ni", share, sample.points[cells])


@pytest.mark.parametrize(
    ("cell", "degree"),
    [
        *product(("quadrilateral", "hexahedron"), (1, 2)),
        ("quadrilateral", 4),
        pytest.param("hexahedron", 4, marks=pytest.mark.slow),
    ],
)
def test_boxes_divided(cell, degree):
    coarse, fine = (body_of(FLAT, cell, degree, elements=n) for n in ((2, 1, 1), (4, 3, 2)))
    assert_kept(coarse, fine)


def assert_kept(coarse, fine):
    step = prolongation(coarse, fine)
    assert step.defect < 1e-10
    P, u = to_scipy(step.matrix), RNG.uniform(-1, 1, step.matrix.getSize()[1])
    x = inside(coarse)
    assert np.abs(values(fine, P @ u, x) - values(coarse, u, x)).max() < 1e-12
    for name in ("stiffness", "mass"):
        wanted, whole = (to_scipy(getattr(part, name)()) for part in (coarse, fine))
        assert abs(P.T @ whole @ P - wanted).max() < 1e-12 * abs(wanted).max()


def test_curved_cells_of_one_geometry():
    coarse, fine = (body_of(ROUND, "hexahedron", q, order=2) for q in (2, 3))
    step = prolongation(coarse, fine)
    assert step.defect < 1e-10
    P = to_scipy(step.matrix)
    u = RNG.uniform(-1, 1, P.shape[1])
    for name, surface in fine.surfaces.items():
        points = surface.gauss_points(3)
        found = surface.trace(points.at) @ (P @ u).reshape(-1, 3)
        at = coarse.surfaces[name].locate(points.x, points.normal, 1e-3).at
        expected = coarse.surfaces[name].trace(at) @ u.reshape(-1, 3)
        assert np.abs(found - expected).max() < 1e-12


@pytest.mark.parametrize("order", [1, 2])
def test_how_far_curved_geometries_are_apart(order):
    """Rings divided: new nodes lie on the circle, off the coarse cells by O(h^(order + 1))."""
    defects, counts = [], (8, 16, 32)
    for n in counts:
        coarse, fine = (
            body_of(ROUND, "quadrilateral", 2, order=order, elements=(1, m)) for m in (n, 2 * n)
        )
        defects.append(prolongation(coarse, fine).defect)
    assert all(defect > 1e-6 for defect in defects)
    assert -np.polyfit(np.log(counts), np.log(defects), 1)[0] > 0.8 * order


def test_held_components_are_left_out():
    held = [Support("z_min", (0, 2)), Support("x_max")]
    coarse, fine = (
        body_of(FLAT, "hexahedron", 2, elements=n, supports=held) for n in ((2, 1, 1), (4, 2, 2))
    )
    step = prolongation(coarse, fine)
    assert step.defect < 1e-10
    assert step.matrix.getSize() == (fine.expansion.getSize()[1], coarse.expansion.getSize()[1])


def test_another_body_is_refused():
    coarse = body_of(FLAT, "hexahedron", 1, elements=(2, 2, 2))
    far = shape_mesh(FLAT[3], "hexahedron", 1, breaks=[np.array([0, e]) for e in (1.0, 0.8, 0.5)])
    far = replace(far, points=SPACE.apply(far.points) + 5.0)
    other = lagrange_body("part", far, degree=1, material=MATERIAL)
    with pytest.raises(InputError, match=r"part.mesh = .* cells apart"):
        prolongation(coarse, other)
