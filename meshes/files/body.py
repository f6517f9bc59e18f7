"""The mesh of a body from the content of a mesh file, checked."""

from collections.abc import Mapping, Sequence

import numpy as np

from cea.mesh import Mesh, facet_nodes
from meshes.files.checks import check_elements, check_matching
from meshes.files.content import FileContent
from meshes.files.kinds import facet_sides
from meshes.files.part import Part, check_nodes
from meshes.files.surfaces import surface_faces
from meshes.files.tetrahedra import completed, tetrahedra


def body_mesh(
    content: FileContent, own: Part, faces: Mapping[str, Sequence[str]], name: str | None = None
) -> Mesh:
    """Mesh of a part of a file, in its unit."""
    check_nodes(content, own, name)
    points = content.points[:, : own.dim]
    if own.is_divided:
        points, cells, elements, sides = tetrahedra(points, own.blocks)
    else:
        points, (cells,) = completed(points, own.blocks)
        elements = np.arange(len(cells))
        sides = np.tile(facet_sides(own.cell, own.order), (len(cells), 1))
    check_elements(own.cell, own.order, points, cells, own.numbers[elements])
    check_matching(own.cell, own.order, cells, own.numbers[elements])
    facets = facet_nodes(own.cell, own.order)
    surfaces = {}
    for surface, (on, _) in surface_faces(content, own, faces).items():
        chosen = on[elements[:, None], sides] & (sides >= 0)
        surfaces[surface] = np.concatenate(
            [cells[chosen[:, i]][:, facet] for i, facet in enumerate(facets)]
        )
    return Mesh(own.cell, own.order, points, cells, surfaces).without_loose_points()
