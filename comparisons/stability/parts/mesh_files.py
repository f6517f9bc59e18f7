"""Scenes whose bodies are written to a mesh file, and read from it again."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cea.mesh import Ints, Mesh, facet_nodes
from comparisons.stability.parts.problems import Answer, OfScene
from meshes.breaks import breaks_of
from meshes.mesh_file import METRES, Unit
from meshes.shape_mesh import shape_mesh
from scenes.export.decks.bodies import element_nodes
from scenes.export.decks.lines import element_lines, set_lines
from scenes.spec.reading import Scene, read_scene

_ELEMENTS = {1: ("CPE4", 4), 2: ("CPE8R", 8)}
"""Type in a deck and number of nodes of quadrilaterals of each order."""


@dataclass(frozen=True)
class OfMeshFile:
    """A scene in the plane whose bodies are written to a deck of Abaqus and read from it.

    Parameters
    ----------
    data
        What a scene file holds, its bodies of shapes.
    unit
        Unit of length of the deck.
    numbers
        Steps between the numbers of nodes.
    geometry
        Fields of the geometry of every body that differ, such as its unit.
    notches
        Bodies without the cells beyond a point along both axes (m), by name; the sides that this
        lays open are the surface notch.
    surfaces
        Surfaces of several others of a body, by their name and that of the body; of such a body
        no others are named that it is made of.
    """

    data: Mapping[str, Any]
    unit: Unit = "m"
    numbers: int = 1
    geometry: Mapping[str, Any] | None = None
    notches: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    surfaces: Mapping[str, Mapping[str, Sequence[str]]] = field(default_factory=dict)

    def solve(self, max_frequency: float | None) -> Answer:
        """Write, read, and solve."""
        data = deepcopy(dict(self.data))
        whole = {**data, "contacts": {}, "analysis": {"kind": "cea", "max_frequency": 1.0}}
        meshes = _meshes(read_scene(whole))
        meshes |= {name: _notched(meshes[name], at) for name, at in self.notches.items()}
        with TemporaryDirectory() as folder:
            deck = Path(folder) / "bodies.inp"
            deck.write_text(_deck(meshes, self.unit, self.numbers))
            for name, mesh in meshes.items():
                faces = self._faces(name, mesh)
                fields = {"file": str(deck), "unit": self.unit, "part": name, "faces": faces}
                geometry = {"shape": "mesh_file", **fields, **(self.geometry or {})}
                data["bodies"][name] |= {"geometry": geometry, "mesh": {}}
            return OfScene(data).solve(max_frequency)

    def _faces(self, body: str, mesh: Mesh) -> dict[str, list[str]]:
        """Sets of the deck that make the surfaces of a body."""
        several = {name: parts[body] for name, parts in self.surfaces.items() if body in parts}
        taken = {part for parts in several.values() for part in parts}
        alone = {name: (name,) for name in mesh.surfaces if name not in taken}
        every = {**alone, **several}
        return {name: [f"{body}_{part}" for part in parts] for name, parts in every.items()}


def _notched(mesh: Mesh, at: tuple[float, float]) -> Mesh:
    """A mesh without the cells beyond a point along both axes."""
    gone = (mesh.points[mesh.cells].mean(axis=1) > at).all(axis=1)
    facets = facet_nodes(mesh.cell, mesh.order)

    def sides(cells: Ints) -> set[tuple[int, ...]]:
        return {tuple(sorted(row)) for nodes in facets for row in cells[:, nodes].tolist()}

    left, cut = sides(mesh.cells[~gone]), sides(mesh.cells[gone])
    surfaces = {
        name: np.array([row for row in part.tolist() if tuple(sorted(row)) in left])
        for name, part in mesh.surfaces.items()
    }
    surfaces["notch"] = np.array(sorted(left & cut))
    return replace(mesh, cells=mesh.cells[~gone], surfaces=surfaces).without_loose_points()


def _meshes(scene: Scene) -> dict[str, Mesh]:
    """Meshes of the bodies of a scene, of quadrilaterals."""
    meshes = {}
    for name, body in scene.bodies.items():
        fe = body.mesh.fe
        assert fe is not None
        assert fe.elements is not None
        breaks = breaks_of(body.geometry, fe.elements, fe.through)
        meshes[name] = shape_mesh(body.geometry, "quadrilateral", fe.degree, breaks=breaks)
    return meshes


def _deck(meshes: Mapping[str, Mesh], unit: Unit, step: int) -> str:
    """Nodes, elements and a set of nodes for each surface."""
    above, below = METRES[unit]
    lines, first, element = [], 0, 0
    for name, mesh in meshes.items():
        kind, corners_and_middles = _ELEMENTS[mesh.order]
        nodes = element_nodes(mesh)[:, :corners_and_middles]
        used, numbers = np.unique(nodes), step * (1 + first + np.arange(len(mesh.points)))
        places = zip(numbers[used], (mesh.points[used] * below / above).tolist(), strict=True)
        lines += ["*NODE", *(f"{number}, {x!r}, {y!r}" for number, (x, y) in places)]
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        lines += element_lines(element + 1, numbers[nodes])
        for surface, facets in mesh.surfaces.items():
            lines += [f"*NSET, NSET={name}_{surface}", *set_lines(numbers[np.unique(facets)])]
        first, element = first + len(mesh.points), element + len(nodes)
    return "\n".join(lines) + "\n"
