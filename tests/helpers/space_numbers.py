"""Numbers of small bodies on each backend that must not depend on the number of ranks."""

import numpy as np
from bodies import PLASTIC, nurbs_body, shape_body
from closed_patches import annulus, as_shape
from iga_data import TURNED, body, turned
from motions import asymmetry
from petsc_matrices import gather

from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.static import solve_static
from cea.motion import Rotation
from cea.supports.boundary import Force, Pressure, Spring, Support
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.shapes import Annulus, Disc, Hub, Rectangle, Ring, Sector

ANNULUS, RING = Annulus(0.5, 1.0, 0.0, 0.3), Ring(0.5, 1.0)
LAGRANGE = {
    "hexahedron": (ANNULUS, 2, (1, 8, 1)),
    "tetrahedron": (ANNULUS, 2, 0.5),
    "triangle": (RING, 4, 0.5),
    "quadrilateral": (Rectangle((2.0, 1.0)), 3, (3, 2)),
}
"""Shape, degree and mesh by cell."""
NURBS = {
    "ring": (Ring(0.8, 1.7), (2, 12), (2, 3)),
    "closed": (as_shape(annulus(0.8, 1.7)), (8, 2), (3, 2)),
    "disc": (Disc(1.7, -0.1, 0.2), (3, 8, 2), (2, 2, 2)),
    "sector": (Sector(0.8, 1.7, 20.0, 85.0, -0.1, 0.2), (3, 7, 2), (2, 3, 2)),
    "hub": (Hub(0.3, 0.8, 1.7, -0.1, 0.1, -0.1, 0.3), (2, 8, 2), (2, 2, 1)),
    "odd": None,
}
"""Shape, elements and degree; two patches joined with their parameters in another order."""


def _conditions(surfaces, dim):
    """Support and springs on the first surface of some, a pressure on the last, forces."""
    held, pressed = surfaces[0], surfaces[-1]
    return {
        "material": PLASTIC,
        "supports": [Support(held, ("x",))],
        "springs": [Spring(held, (1.0, 2.0, 3.0)[:dim])],
        "pressures": [Pressure(pressed, 0.3)],
        "forces": [Force((0.1, 0.0, 0.2)[:dim]), Force((0.1, 0.3, 0.0)[:dim], pressed)],
    }


def _body(case):
    if case in LAGRANGE:
        shape, degree, mesh = LAGRANGE[case]
        conditions = _conditions(shape.surfaces, len(shape.directions))
        return shape_body(shape, case, degree, mesh, **conditions)
    if NURBS[case] is not None:
        shape, elements, degree = NURBS[case]
        return body(shape, elements, degree, **_conditions(shape.surfaces, len(degree)))
    shapes = [Sector(0.8, 1.7, a, b, -0.1, 0.2) for a, b in ((10.0, 60.0), (60.0, 95.0))]
    one, other = (nurbs_shape(s, breaks_of(s, (2, 2, 2)), TURNED).patches[0] for s in shapes)
    faces = {"bottom": [(0, 2, 0)], "top": [(0, 2, 1), (1, 1, 1)]}
    patches, conditions = [one, turned(other, (1, 2, 0), 0)], _conditions(("bottom", "top"), 3)
    return nurbs_body("odd", patches, faces, (2, 2, 2), **conditions)


def numbers(case, top):
    """Frequencies up to one (Hz), work of loads, norms, areas, traces, samples, asymmetry."""
    part = _body(case)
    modes = solve_modes(Pencil.of(part.stiffness(), part.mass()), top)
    x = solve_static(Pencil.of(part.stiffness()), part.load()).displacement
    full = part.expansion.createVecLeft()
    part.expansion.mult(x, full)
    u = gather(full)
    moved = u.reshape(-1, part.dim)
    shown = {"frequencies": sorted(modes.frequencies.tolist()), "work": part.load().dot(x)}
    for surface in part.surfaces.values():
        points = surface.gauss_points(2)
        traced = surface.trace(points.at) @ moved
        slope = np.stack([g @ moved for g in surface.gradient(points.at)])
        shown[f"area of {surface.name}"] = surface.area
        shown[f"trace on {surface.name}"] = (points.weight @ traced**2).tolist()
        shown[f"gradient on {surface.name}"] = float(points.weight @ (slope**2).sum(axis=(0, 2)))
    sample = part.space.volume_cells().straight()
    shown["sample"] = [len(sample.cells), *(sample.points[sample.cells] ** 2).mean(axis=(0, 1))]
    shown["sampled"] = [((sample.values @ moved)[sample.cells] ** 2).mean()]
    symmetric = [part.stiffness(), part.mass()]
    if part.dim == 3:
        symmetric.append(part.geometric_stiffness(u))
        shown["gyroscopic"] = part.gyroscopic(Rotation(2.0, coriolis=False)).norm()
    shown["norms"] = [matrix.norm() for matrix in symmetric]
    return {"same": shown, "asymmetry": [asymmetry(matrix) for matrix in symmetric]}
