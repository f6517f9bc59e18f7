"""The Lagrange mesh of a body as its scene describes it."""

from cea.errors import InputError
from cea.mesh import Mesh
from scenes.spec.body import BodySpec


def lagrange_mesh(spec: BodySpec) -> Mesh:
    """Mesh of a body, as plain arrays; nothing is spread over ranks.

    Raises
    ------
    InputError
        When the body has no Lagrange mesh, or its shape cannot be meshed so.
    """
    from meshes.breaks import breaks_of
    from meshes.shape_mesh import shape_mesh

    mesh = spec.mesh.fe
    if mesh is None:
        raise InputError("mesh.fe", None, "needed for 'fe'")
    breaks = None
    if mesh.elements is not None:
        breaks = breaks_of(spec.geometry, mesh.elements, mesh.boundaries)
    return shape_mesh(
        spec.geometry,
        mesh.cell,
        mesh.geometry_degree or mesh.degree,
        breaks=breaks,
        size=mesh.size,
        placement=spec.placement,
        edges=mesh.edges,
        layers=mesh.layers,
    )
