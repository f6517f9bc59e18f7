"""Bodies of a scene as a deck has them: numbered nodes and elements, and their surfaces."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cea.errors import InputError
from cea.mesh import Floats, Ints, Mesh, lattice
from scenes.building.body_meshes import body_mesh, used_surfaces
from scenes.export.decks.elements import ELEMENTS, element_nodes, faces_of
from scenes.spec.body import BodySpec
from scenes.spec.reading import Scene

_POINTS = 6
"""Gauss points along each direction of a facet: its area element is smooth."""


def set_name(place: str) -> str:
    """Name of the set of nodes, and of the surface, of a surface "body.surface"."""
    return place.replace(".", "-")


def material_name(body: str) -> str:
    """Name of the material of a body."""
    return f"{body}-material"


@dataclass(frozen=True)
class DeckBody:
    """A body with its mesh and the numbers it has in a deck.

    Parameters
    ----------
    name
        Name of the body, which is that of its sets of nodes and elements.
    spec
        What the scene says of it.
    mesh
        Its mesh; nodes are those of its elements.
    first_node, first_element
        Numbers of its first node and element, from 1 through all bodies.
    """

    name: str
    spec: BodySpec
    mesh: Mesh
    first_node: int
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
        """Elements, from 0, and faces, from 1, of a surface."""
        return faces_of(self.mesh, surface)

    def area_of(self, surface: str) -> float:
        """Area of a surface (m^2; m in the plane)."""
        return float(np.linalg.norm(self.area_vectors(surface), axis=-1).sum())

    def area_vectors(self, surface: str) -> Floats:
        """Normals times area at Gauss points of the facets, of either sense, (n, points, dim)."""
        mesh = self.mesh
        at, weights = _gauss(mesh.dim - 1, mesh.is_simplex)
        nodes = lattice(mesh.dim - 1, mesh.order, mesh.is_simplex) / mesh.order
        powers = lattice(mesh.dim - 1, mesh.order, mesh.is_simplex)
        coefficients = np.linalg.inv(_monomials(nodes, powers))
        x = mesh.points[mesh.surfaces[surface]]
        tangents = np.stack(
            [
                np.einsum("pj,jk,nkd->npd", _monomials(at, powers, i), coefficients, x)
                for i in range(mesh.dim - 1)
            ]
        )
        if mesh.dim == 2:
            normal = np.stack([tangents[0, ..., 1], -tangents[0, ..., 0]], axis=-1)
        else:
            normal = np.cross(tangents[0], tangents[1])
        return normal * weights[:, None]


def _monomials(x: Floats, powers: Ints, derivative: int | None = None) -> Floats:
    """Monomials, or their derivatives along one direction, at points, (n, n_monomials)."""
    factor = np.ones(len(powers))
    if derivative is not None:
        factor = powers[:, derivative].astype(float)
        lowered = np.maximum(powers - np.eye(powers.shape[1], dtype=int)[derivative], 0)
        powers = lowered
    return np.prod(x[:, None] ** powers, axis=2) * factor


def _gauss(dim: int, simplex: bool) -> tuple[Floats, Floats]:
    """Points and weights of the unit interval, square or triangle."""
    x, w = np.polynomial.legendre.leggauss(_POINTS)
    x, w = (x + 1) / 2, w / 2
    if dim == 1:
        return x[:, None], w
    s, t = (each.ravel() for each in np.meshgrid(x, x, indexing="ij"))
    weights = np.outer(w, w).ravel()
    if simplex:
        return np.stack([s, (1 - s) * t], axis=1), weights * (1 - s)
    return np.stack([s, t], axis=1), weights


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
        return straight_quadratic(mesh)
    if degree != mesh.order or (mesh.cell, mesh.order) not in ELEMENTS:
        allowed = (
            "the order of the cells for a deck, and 1 where they are no simplices: this file has "
            f"a {mesh.cell} of order {mesh.order}"
        )
        raise InputError(f"bodies.{name}.mesh.degree", degree, allowed)
    return mesh


def straight_quadratic(mesh: Mesh) -> Mesh:
    """A mesh of straight simplices with a node in the middle of each edge besides."""
    corners = lattice(mesh.dim, 1, simplex=True)
    places = lattice(mesh.dim, 2, simplex=True)
    ends = _ends(places, corners)
    pairs = np.sort(mesh.cells[:, ends], axis=2)
    edges, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    middle = edges[:, 0] != edges[:, 1]
    points = np.vstack([mesh.points, mesh.points[edges[middle]].mean(axis=1)])
    row = np.where(middle, len(mesh.points) + np.cumsum(middle) - 1, edges[:, 0])

    facet = _ends(lattice(mesh.dim - 1, 2, simplex=True), lattice(mesh.dim - 1, 1, simplex=True))
    key = edges[:, 0] * len(mesh.points) + edges[:, 1]  # rising, as the edges are sorted
    surfaces = {}
    for name, facets in mesh.surfaces.items():
        wanted = np.sort(facets[:, facet], axis=2)
        at = np.searchsorted(key, wanted[..., 0] * len(mesh.points) + wanted[..., 1])
        surfaces[name] = row[at]
    cells = row[number.reshape(pairs.shape[:2])]
    return replace(mesh, order=2, points=points, cells=cells, surfaces=surfaces)


def _ends(places: Ints, corners: Ints) -> Ints:
    """Two corners for each place of a quadratic lattice, in the middle of which it is."""
    sums = corners[:, None] + corners[None]
    return np.array([np.argwhere((sums == place).all(axis=2))[0] for place in places])
