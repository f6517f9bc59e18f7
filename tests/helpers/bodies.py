"""Bodies on one backend in one call."""

from cea.body import Body
from fe_cea import LagrangeSpace
from iga_cea import NurbsSpace

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
