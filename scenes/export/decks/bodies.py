"""Bodies of a scene as a deck has them: numbered nodes and elements, and their surfaces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Ints
from cea.errors import InputError
from cea.mesh import Cell, Mesh, lattice, matching_nodes, reference_nodes
from meshes.files.content import named_sides
from meshes.files.elements import facet_sides, full_kind
from scenes.building.build import body_mesh, used_surfaces
from scenes.spec.body import BodySpec
from scenes.spec.reading import Scene

ELEMENTS: Mapping[tuple[Cell, int], str] = {
    ("tetrahedron", 1): "C3D4",
    ("tetrahedron", 2): "C3D10",
    ("hexahedron", 1): "C3D8",
}
"""Elements by kind of cell and degree; none there has the node inside a cube of higher degree."""


def set_name(place: str) -> str:
    """Name of the set of nodes, and of the surface, of a surface "body.surface"."""
    return place.replace(".", "-")


@dataclass(frozen=True)
class DeckBody:
    """A body with its mesh and the numbers it has in a deck."""

    name: str  # that of its sets of nodes and elements too
    spec: BodySpec
    mesh: Mesh  # whose nodes are those of its elements
    first_node: int  # numbers from 1 through all bodies
    first_element: int

    @property
    def element_type(self) -> str:
        """Name of its elements."""
        return ELEMENTS[self.mesh.cell, self.mesh.order]

    @cached_property
    def elements(self) -> Ints:
        """Nodes of its elements, rows of the mesh's points, (n_elements, n_nodes)."""
        return element_nodes(self.mesh)

    def nodes_of(self, surface: str) -> Ints:
        """Rows of the nodes of a surface, rising."""
        return np.unique(self.mesh.surfaces[surface])

    def faces_of(self, surface: str) -> tuple[Ints, Ints]:
        """Elements, from 0, rising, and their faces, from 1, of a surface, (n_facets,)."""
        mesh = self.mesh
        elements, facets = np.nonzero(named_sides(mesh)[surface])
        sides = facet_sides(mesh.cell)
        # Facets of simplices lie across an axis each, of boxes two.
        swapped = [1, 0] if mesh.is_simplex else [2, 3, 0, 1]
        mirrored = sides[[*swapped, *range(len(swapped), len(sides))]]
        faces = np.where(_is_mirrored(mesh)[elements], mirrored[facets], sides[facets]) + 1
        rising = np.lexsort((faces, elements))
        return elements[rising], faces[rising]


def element_nodes(mesh: Mesh) -> Ints:
    """Nodes of each cell in the order of its element type, right-handed, (n_cells, n_nodes)."""
    nodes = full_kind(mesh.cell, mesh.order).reference
    own = reference_nodes(mesh.cell, mesh.order)
    straight = mesh.cells[:, matching_nodes(nodes, own)]
    mirrored = mesh.cells[:, matching_nodes(nodes[:, [1, 0, *range(2, mesh.dim)]], own)]
    return np.where(_is_mirrored(mesh)[:, None], mirrored, straight)


def _is_mirrored(mesh: Mesh) -> NDArray[np.bool_]:
    """Whether the first two axes of a cell change places in its element, (n_cells,)."""
    first = np.vstack([np.zeros(mesh.dim), np.eye(mesh.dim)])
    apart = np.abs(first[:, None] - reference_nodes(mesh.cell, mesh.order)).max(axis=2)
    x = mesh.points[mesh.cells[:, apart.argmin(axis=1)]]
    return np.linalg.det(x[:, 1:] - x[:, :1]) < 0


def deck_bodies(scene: Scene) -> dict[str, DeckBody]:
    """Bodies of a scene by name, meshed and numbered; the scene was checked before."""
    bodies: dict[str, DeckBody] = {}
    node = element = 1
    for name, spec in scene.bodies.items():
        mesh = _mesh(name, spec, used_surfaces(scene, name))
        bodies[name] = DeckBody(name, spec, mesh, node, element)
        node, element = node + len(mesh.points), element + len(mesh.cells)
    return bodies


def _mesh(name: str, spec: BodySpec, surfaces: Sequence[str]) -> Mesh:
    """Mesh whose nodes are those of the elements."""
    mesh, degree = body_mesh(name, spec, surfaces).without_loose_points(), spec.fe_degree
    if degree == 2 and mesh.order == 1 and mesh.is_simplex:
        return _straight_quadratic(mesh)
    if degree != mesh.order or (mesh.cell, mesh.order) not in ELEMENTS:
        allowed = (
            "the order of the cells for a deck, in space, and 1 of hexahedra: this file has "
            f"a {mesh.cell} of order {mesh.order}"
        )
        raise InputError(f"bodies.{name}.mesh.degree", degree, allowed)
    return mesh


def _straight_quadratic(mesh: Mesh) -> Mesh:
    """A mesh of straight simplices with a node in the middle of each edge besides."""
    pairs = np.sort(mesh.cells[:, _ends(mesh.dim)], axis=2)
    edges, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    middle = edges[:, 0] != edges[:, 1]
    points = np.vstack([mesh.points, mesh.points[edges[middle]].mean(axis=1)])
    row = np.where(middle, len(mesh.points) + np.cumsum(middle) - 1, edges[:, 0])
    key = edges[:, 0] * len(mesh.points) + edges[:, 1]  # rising, as the edges are sorted
    surfaces = {}
    for name, facets in mesh.surfaces.items():
        wanted = np.sort(facets[:, _ends(mesh.dim - 1)], axis=2)
        surfaces[name] = row[
            np.searchsorted(key, wanted[..., 0] * len(mesh.points) + wanted[..., 1])
        ]
    cells = row[number.reshape(pairs.shape[:2])]
    return replace(mesh, order=2, points=points, cells=cells, surfaces=surfaces)


def _ends(dim: int) -> Ints:
    """Two corners for each node of a quadratic simplex, in the middle of which it is."""
    corners, places = (lattice(dim, order, simplex=True) for order in (1, 2))
    sums = corners[:, None] + corners[None]
    return np.array([np.argwhere((sums == place).all(axis=2))[0] for place in places])
