"""Numbers of small Lagrange scenes that must not depend on the number of ranks."""

from bodies import lagrange_body

from cea.contact.friction import AlongVector
from cea.contact.half_pass import HalfPass
from cea.contact.interface import pair
from cea.contact.laws import Friction, LinearLaw
from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.static import solve_static
from cea.material import IsotropicMaterial
from cea.matrices import gather, largest_row
from cea.petsc import MPI, PETSc
from cea.ranks import made_on_first
from cea.supports.boundary import Pressure, Spring, Support
from cea.system.coupling import couple
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Disc, Rectangle, Ring

MATERIAL = IsotropicMaterial(2.0, 0.3, 1.5)
CASES = {
    "tetrahedron": (Annulus(0.5, 1.0, 0.0, 0.3), 2, "bottom", "top", 0.35),
    "hexahedron": (Disc(1.0, 0.0, 0.2), 3, "bottom", "top", 0.7),
    "triangle": (Ring(0.5, 1.0), 4, "inner", "outer", 0.5),
    "quadrilateral": (Rectangle((2.0, 1.0)), 3, "x_min", "y_max", 0.7),
}
"""Shape, degree, held surface, pressed surface, highest frequency (Hz)."""
ELEMENTS = {"hexahedron": (2, 8, 1), "quadrilateral": (3, 2)}


def body_of(name, cell, shape, degree, **conditions):
    """A small body on all ranks."""
    mesh = {"size": 0.5}
    if cell in ELEMENTS:
        mesh = {"breaks": breaks_of(shape, ELEMENTS[cell])}
    made = made_on_first(MPI.COMM_WORLD, lambda: shape_mesh(shape, cell, degree, **mesh))
    return lagrange_body(name, made, degree=degree, material=MATERIAL, **conditions)


def numbers(cell):
    """Eigenvalues, areas, work of a load and volume of samples of one body."""
    shape, degree, held, pressed, top = CASES[cell]
    dim = len(shape.directions)
    body = body_of(
        "part",
        cell,
        shape,
        degree,
        supports=[Support(held, (0,))],
        springs=[Spring(held, (1.0, 2.0, 3.0)[:dim])],
        pressures=[Pressure(pressed, 0.3)],
    )
    modes = solve_modes(Pencil.of(body.stiffness(), body.mass()), top)
    x = solve_static(Pencil.of(body.stiffness()), body.load()).displacement
    full = body.expansion.createVecLeft()
    body.expansion.mult(x, full)
    sample = body.volume_sample(2)
    moved = sample.values @ gather(full).reshape(-1, dim)
    corners = sample.points[sample.cells]
    surface = body.surfaces[pressed]
    points = surface.gauss_points(2)
    traced = surface.trace(points.at) @ gather(full).reshape(-1, dim)
    return {
        "frequencies": sorted(modes.frequencies.tolist()),
        "work": body.load().dot(x),
        "areas": [s.area for s in body.surfaces.values()],
        "surface moments": (points.weight @ points.x**2).tolist(),
        "trace": (points.weight @ traced**2).tolist(),
        "cells": len(corners),
        "second moments": (corners**2).mean(axis=(0, 1)).tolist(),
        "squares": float((moved**2).sum()),
        "asymmetry": [asymmetry(body.stiffness()), asymmetry(body.mass())],
    }


def asymmetry(matrix):
    """Largest row of a matrix less its transpose: zero on any number of ranks."""
    difference = matrix.transpose(PETSc.Mat())
    difference.axpy(-1.0, matrix, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    return largest_row(difference)


def contact():
    """Eigenvalues of two blocks in frictional contact."""
    bodies = {}
    for name, y, n, held in (("a", 0.0, (3, 2), "y_max"), ("b", -1.0, (4, 1), "y_min")):
        shape = Rectangle((2.0, 1.0), origin=(0.0, y))
        made = shape_mesh(shape, "quadrilateral", 2, breaks=breaks_of(shape, n))
        bodies[name] = lagrange_body(  # every rank has the mesh: that of rank 0 is read
            name, made, degree=2, material=MATERIAL, supports=[Support(held, (0, 1))]
        )
    a, b = bodies["a"].surfaces["y_min"], bodies["b"].surfaces["y_max"]
    interface = pair(a, b, a.gauss_points(3))
    friction = Friction(0.4, AlongVector((1.0, 0.0)))
    half = HalfPass("a", "b", interface, LinearLaw(50.0), friction)
    system = couple(bodies, {"c": half})
    modes = solve_modes(system.pencil(), 0.3)
    return {"frequencies": sorted(modes.frequencies.tolist())}


def of_cases(*names):
    """Numbers of some cases by name."""
    return {name: contact() if name == "contact" else numbers(name) for name in names}
