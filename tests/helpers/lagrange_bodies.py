"""Lagrange bodies of every cell and degree, in space and in the plane."""

from bodies import PLASTIC, shape_body

from meshes.placement import Placement
from meshes.shapes import Annulus, Box, Rectangle, Ring

MATERIAL = PLASTIC
SPACE = Placement(axis=(1.0, 2.0, -0.5), angle=37.0, translation=(0.3, -0.2, 0.7))
PLANE = Placement(angle=37.0, translation=(0.3, -0.2, 0.0))
ROUND = {3: Annulus(0.5, 1.0, 0.0, 0.3), 2: Ring(0.5, 1.0)}
FLAT = {3: Box((1.0, 0.8, 0.5)), 2: Rectangle((1.0, 0.8))}
DIMENSION = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}


def body_of(shapes, cell, degree, *, order=None, elements=(1, 8, 1), **options):
    dim = DIMENSION[cell]
    mesh = elements[:dim] if cell in ("hexahedron", "quadrilateral") else 0.6
    placement = SPACE if dim == 3 else PLANE
    return shape_body(shapes[dim], cell, degree, mesh, order=order, placement=placement, **options)
