"""Bodies of a deck: numbered nodes and elements, and surfaces."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError
from cea.mesh import Cell, Mesh, matching_nodes, reference_nodes
from meshes.files.content import named_sides
from meshes.files.elements import KINDS, facet_sides, full_kind, side_nodes
from scenes.building.build import body_mesh, used_surfaces
from scenes.spec.body import BodySpec
from scenes.spec.reading import Scene

ELEMENTS: Mapping[tuple[Cell, int], str] = {
    ("tetrahedron", 1): "C3D4",
    ("tetrahedron", 2): "C3D10",
    ("hexahedron", 1): "C3D8",
}
"""Element types by cell and degree. CalculiX has no element with the inner node of a triquadratic
hexahedron."""


def set_name(place: str) -> str:
    """Return the name of the node set and the surface for "body.surface"."""
    return place.replace(".", "-")


@dataclass(frozen=True)
class DeckBody:
    """A body with its mesh and its numbering in a deck."""

    name: str  # also of its node and element sets
    spec: BodySpec
    mesh: Mesh
    element_type: str
    points: Floats  # nodes (m), (n_nodes, 3)
    elements: Ints  # nodes of each element in the order of its type, right-handed
    faces: Mapping[str, tuple[Ints, Ints]]  # elements, from 0, and their faces, from 1, by surface
    first_node: int  # numbered from 1 over all bodies
    first_element: int

    def nodes_of(self, surface: str) -> Ints:
        """Return the sorted indices of the nodes of a surface."""
        elements, faces = self.faces[surface]
        cell, count = self.mesh.cell, self.elements.shape[1]
        sides = enumerate(side_nodes(cell, KINDS[f"{cell}{count}"].reference), start=1)
        on = [self.elements[elements[faces == face]][:, nodes].ravel() for face, nodes in sides]
        return np.unique(np.concatenate(on))


def deck_bodies(scene: Scene) -> dict[str, DeckBody]:
    """Mesh and number the bodies of a validated scene; return them by name."""
    bodies: dict[str, DeckBody] = {}
    node = element = 1
    for name, spec in scene.bodies.items():
        mesh = body_mesh(name, spec, used_surfaces(scene, name)).without_loose_points()
        mesh = _right_handed(mesh)
        degree = spec.fe_degree or mesh.order
        if (mesh.cell, degree) not in ELEMENTS or mesh.order not in (1, degree):
            allowed = (
                "the order of the cells for a deck, in space, and 1 of hexahedra: this file has "
                f"a {mesh.cell} of order {mesh.order}"
            )
            raise InputError(f"bodies.{name}.mesh.degree", degree, allowed)
        points, elements = _elements(mesh, degree)
        element_type, faces = ELEMENTS[mesh.cell, degree], _faces(mesh)
        bodies[name] = DeckBody(
            name, spec, mesh, element_type, points, elements, faces, node, element
        )
        node, element = node + len(points), element + len(elements)
    return bodies


def _right_handed(mesh: Mesh) -> Mesh:
    """Return the mesh with the first two axes of left-handed cells swapped."""
    own = reference_nodes(mesh.cell, mesh.order)
    corners = np.vstack([np.zeros(mesh.dim), np.eye(mesh.dim)])
    first = np.abs(corners[:, None] - own).max(axis=2).argmin(axis=1)
    x = mesh.points[mesh.cells[:, first]]
    mirrored = np.linalg.det(x[:, 1:] - x[:, :1]) < 0
    swapped = mesh.cells[:, matching_nodes(own[:, [1, 0, *range(2, mesh.dim)]], own)]
    return replace(mesh, cells=np.where(mirrored[:, None], swapped, mesh.cells))


def _elements(mesh: Mesh, degree: int) -> tuple[Floats, Ints]:
    """Return nodes (m) and elements; midpoints of straight edges are added for degree 2."""
    own = reference_nodes(mesh.cell, mesh.order)
    elements = mesh.cells[:, matching_nodes(full_kind(mesh.cell, mesh.order).reference, own)]
    if mesh.order == degree:
        return mesh.points, elements
    ends = full_kind(mesh.cell, degree).groups[elements.shape[1] :]
    pairs = np.sort(elements[:, np.array(ends)], axis=2)
    edges, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    points = np.vstack([mesh.points, mesh.points[edges].mean(axis=1)])
    return points, np.hstack([elements, len(mesh.points) + number.reshape(len(elements), -1)])


def _faces(mesh: Mesh) -> dict[str, tuple[Ints, Ints]]:
    """Return the sorted elements of each surface, and their faces."""
    found = {}
    for name, on_surface in named_sides(mesh).items():
        elements, facets = np.nonzero(on_surface)
        faces = facet_sides(mesh.cell)[facets] + 1
        rising = np.lexsort((faces, elements))
        found[name] = elements[rising], faces[rising]
    return found
