"""Bodies on one backend in one call."""

from cea.body import Body
from cea.material import IsotropicMaterial
from cea.mesh import DIMENSION
from cea.petsc import MPI
from cea.ranks import made_on_first
from fe_cea import LagrangeSpace
from iga_cea import NurbsSpace
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box, Rectangle, Ring

PLASTIC = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
PLAIN = Placement()
SPACE = Placement(axis=(1.0, 2.0, -0.5), angle=37.0, translation=(0.3, -0.2, 0.7))
PLANE = Placement(angle=37.0, translation=(0.3, -0.2, 0.0))
ROUND = {3: Annulus(0.5, 1.0, 0.0, 0.3), 2: Ring(0.5, 1.0)}
FLAT = {3: Box((1.0, 0.8, 0.5)), 2: Rectangle((1.0, 0.8))}

_OF_SPACES = ("degree", "continuity", "mass_quadrature", "true_surfaces", "comm")


def _body(make_space, name, *arguments, **options):
    of_space = {key: options.pop(key) for key in _OF_SPACES if key in options}
    return Body(name, make_space(*arguments, field=f"bodies.{name}", **of_space), **options)


def lagrange_body(name, mesh, **options):
    """Body on a mesh of plain arrays."""
    return _body(LagrangeSpace.from_mesh, name, mesh, **options)


def dolfinx_body(name, mesh, facet_tags, surface_tags, **options):
    """Body on a mesh of dolfinx."""
    return _body(LagrangeSpace, name, mesh, facet_tags, surface_tags, **options)


def nurbs_body(name, patches, faces, degree, **options):
    """Body of NURBS patches."""
    return _body(NurbsSpace, name, patches, faces, degree, **options)


def shape_body(shape, cell, degree, mesh, *, order=None, placement=PLAIN, **options):
    """Body of a shape: cells of a kind, or NURBS patches where that is None.

    Its mesh is the number of elements along each direction, or the size of triangles and
    tetrahedra.
    """
    options.setdefault("material", PLASTIC)
    given = {"size": mesh} if isinstance(mesh, float) else {"breaks": breaks_of(shape, mesh)}
    if cell is None:
        patches, faces = nurbs_shape(shape, given["breaks"], placement)
        degrees = degree if isinstance(degree, tuple) else (degree,) * len(mesh)
        return nurbs_body("part", patches, faces, degrees, **options)
    made = made_on_first(
        MPI.COMM_WORLD,
        lambda: shape_mesh(shape, cell, order or degree, placement=placement, **given),
    )
    return lagrange_body("part", made, degree=degree, **options)


def body_of(shapes, cell, degree, *, order=None, elements=(1, 8, 1), **options):
    """Turned body of cells of a kind, of the shape of its dimension."""
    dim = DIMENSION[cell]
    mesh = elements[:dim] if cell in ("hexahedron", "quadrilateral") else 0.6
    placement = SPACE if dim == 3 else PLANE
    return shape_body(shapes[dim], cell, degree, mesh, order=order, placement=placement, **options)
