"""Numbers of small NURBS bodies that must not depend on the number of ranks."""

import numpy as np
from bodies import nurbs_body
from closed_patches import annulus, as_shape
from iga_data import STEEL, TURNED, body, turned

from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.static import solve_static
from cea.matrices import gather
from cea.supports.boundary import Pressure, Spring, Support
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.shapes import Disc, Hub, Ring, Sector


def cases(name):
    """A held, sprung and pressed body, and the highest frequency of interest (Hz)."""
    if name == "ring":
        conditions = {
            "supports": [Support("inner", (0,))],
            "springs": [Spring("outer", (1.0, 2.0))],
            "pressures": [Pressure("outer", 0.3)],
        }
        return body(Ring(0.8, 1.7), (2, 12), (2, 3), **conditions), 0.12
    if name == "closed":
        conditions = {
            "supports": [Support("inner", (0, 1))],
            "springs": [Spring("outer", (1.0, 2.0))],
            "pressures": [Pressure("outer", 0.3)],
        }
        return body(as_shape(annulus(0.8, 1.7)), (8, 2), (3, 2), **conditions), 0.5
    conditions = {
        "supports": [Support("bottom", (0, 2))],
        "springs": [Spring("top", (1.0, 2.0, 3.0))],
        "pressures": [Pressure("top", 0.3)],
    }
    if name == "disc":
        return body(Disc(1.7, -0.1, 0.2), (3, 8, 2), (2, 2, 2), **conditions), 0.165
    if name == "sector":  # one patch, cut across its second parameter
        sector = Sector(0.8, 1.7, 20.0, 85.0, -0.1, 0.2)
        return body(sector, (3, 7, 2), (2, 3, 2), **conditions), 0.35
    if name == "hub":
        hub = Hub(0.3, 0.8, 1.7, -0.1, 0.1, -0.1, 0.3)
        return body(hub, (2, 8, 2), (2, 2, 1), **conditions), 0.15
    shapes = [Sector(0.8, 1.7, a, b, -0.1, 0.2) for a, b in ((10.0, 60.0), (60.0, 95.0))]
    one, other = (nurbs_shape(s, breaks_of(s, (2, 2, 2)), TURNED).patches[0] for s in shapes)
    faces = {"bottom": [(0, 2, 0)], "top": [(0, 2, 1), (1, 1, 1)]}
    patches = [one, turned(other, (1, 2, 0), 0)]
    return nurbs_body("odd", patches, faces, (2, 2, 2), material=STEEL, **conditions), 0.18


def asymmetry(matrix):
    """Largest difference of a matrix from its transpose, relative to the matrix."""
    difference = matrix.copy()
    difference.axpy(-1.0, matrix.transpose(type(matrix)()), structure=False)
    return difference.norm() / matrix.norm()


def numbers(name):
    """Frequencies, norms, work of the load, traces and samples of one body."""
    part, top = cases(name)
    modes = solve_modes(Pencil.of(part.stiffness(), part.mass()), top)
    x = solve_static(Pencil.of(part.stiffness()), part.load()).displacement
    full = part.expansion.createVecLeft()
    part.expansion.mult(x, full)
    u = gather(full).reshape(-1, part.dim)
    shown = {
        "frequencies": sorted(modes.frequencies.tolist()),
        "norms": [part.stiffness().norm(), part.mass().norm(), part.load().norm()],
        "work": part.load().dot(x),
        "free": list(part.expansion.getSize()),
    }
    for surface in part.surfaces.values():
        points = surface.gauss_points(2)
        traced = surface.trace(points.at) @ u
        slope = np.stack([g @ u for g in surface.gradient(points.at)])
        shown[f"area of {surface.name}"] = surface.area
        shown[f"trace on {surface.name}"] = (points.weight @ traced**2).tolist()
        shown[f"gradient on {surface.name}"] = float(points.weight @ (slope**2).sum(axis=(0, 2)))
    sample = part.volume_sample(2)
    shown["sample"] = [len(sample.cells), *(sample.points**2).mean(axis=0).tolist()]
    shown["sampled"] = ((sample.values @ u) ** 2).mean(axis=0).tolist()
    symmetry = max(asymmetry(part.stiffness()), asymmetry(part.mass()))
    return {"same": shown, "asymmetry": symmetry}
