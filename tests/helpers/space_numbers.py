"""Numbers of a small body on each backend that must not depend on the number of ranks."""

import numpy as np
from bodies import lagrange_body, nurbs_body

from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil
from cea.eigen.static import solve_static
from cea.material import IsotropicMaterial
from cea.matrices import gather
from cea.petsc import MPI, PETSc
from cea.ranks import made_on_first
from cea.rotation import Rotation
from cea.supports.boundary import Force, Pressure, Spring, Support
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus

SHAPE = Annulus(0.5, 1.0, 0.0, 0.3)


def numbers(backend):
    """Frequencies, work of loads, areas, traces, norms and asymmetry of an annulus."""
    conditions = {
        "material": IsotropicMaterial(2.0, 0.3, 1.5),
        "supports": [Support("bottom", (2,))],
        "springs": [Spring("bottom", (1.0, 2.0, 3.0))],
        "pressures": [Pressure("top", 0.3)],
        "forces": [Force((0.1, 0.0, 0.2)), Force((0.1, 0.3, 0.0), "outer")],
    }
    breaks = breaks_of(SHAPE, (1, 8, 1))
    if backend == "fe":
        mesh = made_on_first(
            MPI.COMM_WORLD, lambda: shape_mesh(SHAPE, "hexahedron", 2, breaks=breaks)
        )
        part = lagrange_body("part", mesh, degree=2, **conditions)
    else:
        data = nurbs_shape(SHAPE, breaks)
        part = nurbs_body("part", data.patches, data.faces, (2, 2, 2), **conditions)
    modes = solve_modes(Pencil.of(part.stiffness(), part.mass()), 0.35)
    x = solve_static(Pencil.of(part.stiffness()), part.load()).displacement
    full = part.expansion.createVecLeft()
    part.expansion.mult(x, full)
    u = gather(full)
    points = part.surfaces["top"].gauss_points(2)
    traced = part.surfaces["top"].trace(points.at) @ u.reshape(-1, 3)
    rotation = Rotation(2.0, coriolis=False)
    geometric, gyroscopic = part.geometric_stiffness(u), part.gyroscopic(rotation)
    return {
        "frequencies": sorted(modes.frequencies.tolist()),
        "work": part.load().dot(x),
        "areas": [s.area for s in part.surfaces.values()],
        "trace": (points.weight @ traced**2).tolist(),
        "geometric": geometric.norm(),
        "gyroscopic": gyroscopic.norm(),
        "asymmetry": [asymmetry(part.stiffness()), asymmetry(part.mass()), asymmetry(geometric)],
    }


def asymmetry(matrix):
    """Largest entry of a matrix less its transpose: zero on any number of ranks."""
    difference = matrix.transpose(PETSc.Mat())
    difference.axpy(-1.0, matrix)
    return float(np.abs(difference.getValuesCSR()[2]).max(initial=0.0))
