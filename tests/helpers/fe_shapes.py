"""Small Lagrange bodies of plain shapes, and what their matrices are held against."""

import numpy as np
from bodies import lagrange_body

from cea.material import IsotropicMaterial
from meshes.breaks import breaks_of
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box

MATERIAL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
ELEMENTS = [("tetrahedron", 1), ("tetrahedron", 2), ("hexahedron", 1), ("hexahedron", 2)]
PLACEMENT = Placement(axis=(1.0, 2.0, -0.5), angle=37.0, translation=(0.3, -0.2, 0.7))
BOX = Box((2.0, 1.0, 0.5), origin=(0.1, -0.3, 0.2))
ANNULUS = Annulus(0.5, 1.0, 0.0, 0.3)


def body_of(shape, cell, degree, *, elements=None, size=None, placement=None, **options):
    mesh = {"size": size} if cell == "tetrahedron" else {"breaks": breaks_of(shape, *elements)}
    material = options.pop("material", MATERIAL)
    made = shape_mesh(shape, cell, degree, placement=placement or Placement(), **mesh)
    return lagrange_body("part", made, degree=degree, material=material, **options)


def box(cell, degree, **options):
    elements = ((3, 2, 2), {"x": [0.6]})
    return body_of(BOX, cell, degree, elements=elements, size=0.6, **options)


def annulus(cell, degree, **options):
    return body_of(ANNULUS, cell, degree, elements=((2, 12, 1),), size=0.3, **options)


def coordinates(body, degree):
    """Positions of the scalar dofs: at the nodes, basis functions are one or zero."""
    sample = body.space.volume_sample(degree)
    rounded = sample.values.copy()
    rounded.data = np.rint(rounded.data)
    assert abs(rounded - sample.values).max() < 1e-13
    return rounded.T @ sample.points


def rigid_motions(x):
    columns = [np.broadcast_to(e, x.shape).ravel() for e in np.eye(3)]
    return np.column_stack(columns + [np.cross(e, x).ravel() for e in np.eye(3)])


def exact_measures(shape):
    area = np.pi * (shape.outer_radius**2 - shape.inner_radius**2)
    height = shape.top - shape.bottom
    return {
        "volume": area * height,
        "top": area,
        "bottom": area,
        "inner": 2 * np.pi * shape.inner_radius * height,
        "outer": 2 * np.pi * shape.outer_radius * height,
    }
