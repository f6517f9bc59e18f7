"""Bodies on one backend in one call."""

import numpy as np

from cea.body import Body
from cea.petsc import MPI
from cea.ranks import made_on_first
from fe_cea import LagrangeSpace
from iga_cea import NurbsSpace
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh

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


def shape_body(shape, cell, mesh, degree, *, placement=None, **options):
    """Body of a shape: of NURBS where the cell is None, of Lagrange elements else; collective.

    The mesh is the elements along each direction, or the size of unstructured ones.
    """
    placement = placement or Placement()
    if cell is None:
        data = nurbs_shape(shape, breaks_of(shape, mesh), placement)
        degrees = tuple(np.broadcast_to(degree, len(mesh)).tolist())
        return nurbs_body("part", data.patches, data.faces, degrees, **options)
    given = {"size": mesh} if isinstance(mesh, float) else {"breaks": breaks_of(shape, mesh)}
    made = made_on_first(
        MPI.COMM_WORLD, lambda: shape_mesh(shape, cell, degree, placement=placement, **given)
    )
    return lagrange_body("part", made, degree=degree, **options)
