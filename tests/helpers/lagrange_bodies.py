"""Lagrange bodies of every cell and degree, in space and in the plane."""

import scipy.sparse as sp
from bodies import lagrange_body

from cea.material import IsotropicMaterial
from meshes.breaks import breaks_of
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box, Rectangle, Ring

MATERIAL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
SPACE = Placement(axis=(1.0, 2.0, -0.5), angle=37.0, translation=(0.3, -0.2, 0.7))
PLANE = Placement(angle=37.0, translation=(0.3, -0.2, 0.0))
ROUND = {3: Annulus(0.5, 1.0, 0.0, 0.3), 2: Ring(0.5, 1.0)}
FLAT = {3: Box((1.0, 0.8, 0.5)), 2: Rectangle((1.0, 0.8))}
DIMENSION = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}


def body_of(shapes, cell, degree, *, order=None, elements=(1, 8, 1), **options):
    dim = DIMENSION[cell]
    shape, placement = shapes[dim], SPACE if dim == 3 else PLANE
    mesh = {"size": 0.6}
    if cell in ("hexahedron", "quadrilateral"):
        mesh = {"breaks": breaks_of(shape, elements[:dim])}
    made = shape_mesh(shape, cell, order or degree, placement=placement, **mesh)
    return lagrange_body("part", made, degree=degree, material=MATERIAL, **options)


def csr(matrix):
    starts, columns, values = matrix.getValuesCSR()
    return sp.csr_array((values, columns, starts), shape=matrix.getSize())
