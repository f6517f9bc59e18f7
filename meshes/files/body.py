"""The mesh of a body from the content of a mesh file, checked."""

from collections.abc import Mapping, Sequence

from cea.mesh import Mesh
from meshes.files.content import FileContent
from meshes.files.jacobians import check_elements
from meshes.files.part import Part, check_nodes
from meshes.files.serendipity import completed
from meshes.files.surfaces import surface_facets


def body_mesh(
    content: FileContent, own: Part, faces: Mapping[str, Sequence[str]], name: str | None = None
) -> Mesh:
    """Mesh of a part of a file, in its unit.

    Parameters
    ----------
    content
        The file.
    own
        Its elements that make the body.
    faces
        Sets of each named surface (:func:`meshes.files.surfaces.surface_facets`).
    name
        Set that they are, for messages.

    Raises
    ------
    InputError
        Naming file, part, merge_nodes or faces.
    """
    check_nodes(content, own, name)
    points, cells = completed(content.points[:, : own.dim], own)
    check_elements(own.cell, own.order, points, cells, own.numbers)
    surfaces = surface_facets(content, own, cells, faces)
    return Mesh(own.cell, own.order, points, cells, surfaces).without_loose_points()
