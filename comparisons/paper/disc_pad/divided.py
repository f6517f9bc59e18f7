"""Tetrahedra that trace what hexahedra trace: every hexahedron divided into six.

The six have the diagonal from the first to the last corner in common, and go along one direction
after the other, so that faces of neighbours are divided alike. Nodes are those of the hexahedra.
"""

from collections.abc import Iterable, Mapping
from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.body import Body, Floats, Ints
from scenes.build import fe_body
from scenes.read import Scene

_FAMILIES = {3: ("Hexahedron", "Tetrahedron"), 2: ("Quadrangle", "Triangle")}
"""What is divided and into what, by dimension, in gmsh's names."""


def divided_bodies(scene: Scene) -> Mapping[str, Body]:
    """Bodies of a scene whose meshes are hexahedra, on tetrahedra."""
    bodies = {}
    for name, spec in scene.bodies.items():
        assert spec.mesh.fe is not None
        bodies[name] = fe_body(name, spec, spec.mesh.fe, change=_divide)
    return bodies


def _divide(model: Any, order: int) -> None:
    """Replace the mesh of a gmsh model by one whose hexahedra and their faces are divided."""
    for dim, (family, part) in _FAMILIES.items():
        whole, smaller = (model.mesh.getElementType(f, order) for f in (family, part))
        chosen = _parts(_lattice(model, whole, dim, order), _places(model, smaller, dim, order))
        for _, entity in model.getEntities(dim):
            _, nodes = model.mesh.getElementsByType(whole, entity)
            cells = np.asarray(nodes).reshape(-1, chosen.max() + 1)[:, chosen]
            model.mesh.removeElements(dim, entity)
            model.mesh.addElementsByType(entity, smaller, [], cells.ravel())


def _places(model: Any, kind: int, dim: int, order: int) -> Ints:
    """Steps along the edges of a simplex at which its nodes lie, (n_nodes, dim)."""
    local = np.reshape(model.mesh.getElementProperties(kind)[4], (-1, dim))
    return np.rint(local * order).astype(int)


def _lattice(model: Any, kind: int, dim: int, order: int) -> Mapping[tuple[int, ...], int]:
    """Number of the node of a box at each place of its lattice."""
    local = np.reshape(model.mesh.getElementProperties(kind)[4], (-1, dim))
    places = np.rint((local + 1) / 2 * order).astype(int)
    return {tuple(place): node for node, place in enumerate(places.tolist())}


def _parts(lattice: Mapping[tuple[int, ...], int], places: Ints) -> NDArray[np.int64]:
    """Nodes of a box that each of its simplices takes, (parts, n_nodes)."""
    dim = places.shape[1]
    parts = []
    for way in permutations(range(dim)):
        edges = _edges(way)
        parts.append([lattice[tuple(place)] for place in (places @ edges).tolist()])
    return np.array(parts)


def _edges(way: Iterable[int]) -> Floats:
    """Edges from the first corner of a simplex to the others, right-handed, (dim, dim)."""
    corners = np.cumsum(np.eye(len(tuple(way)), dtype=int)[list(way)], axis=0)
    if np.linalg.det(corners) < 0:
        corners[[0, 1]] = corners[[1, 0]]
    return corners
